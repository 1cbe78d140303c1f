//! Indirect light: what reaches the surfaces of the G-buffer by bounces.
//!
//! * [`IndirectLighting`]: the stage, one path of bounce rays a pixel, a pass for each step of the paths;
//! * `sh.glsl` (in pt-shaders): diffuse light as it is filtered and stored, luma with its direction in spherical harmonics up to l = 1,
//!   chroma without;
//! * `reuse=restir-gi`: what the paths of other pixels and frames have found, resampled (ReSTIR GI);
//! * [`oracle`]: the same mathematics on the CPU.

#![forbid(unsafe_code)]

mod bounces;
pub mod images;
mod indirect;
pub mod oracle;
mod params;
pub mod records;
mod reuse;

pub use indirect::IndirectLighting;
pub use params::{BounceLights, IndirectParams};

mod kernels {
    include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
}
