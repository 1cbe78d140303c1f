//! Ground truth: an unbiased path tracer with next event estimation and multiple importance sampling, and direct light by brute
//! force on the CPU to check it against.
//!
//! * [`PathTracer`]: the kernels and the sums that they add to; [`Progressive`]: a render that can be stopped and resumed;
//! * [`FilmState`]: sums on the host, bit by bit; [`Estimate`]: mean and variance, which can be merged;
//! * [`EstimateFile`], [`Checkpoint`]: both as files, with the [`Identity`] of the render;
//! * [`direct`]: direct light in double precision.

#![forbid(unsafe_code)]

mod bvh;
mod camera_interior;
pub mod direct;
mod files;
mod film;
mod identity;
pub mod oracle;
mod params;
mod path_tracer;
mod progressive;
pub mod records;

pub use files::{Checkpoint, EstimateFile, ReferenceFileError, denoiser_inputs};
pub use film::{Estimate, EstimatePixel, FilmState, MergeError};
pub use identity::Identity;
pub use params::{LightTypes, MediumParams, ReferenceParams};
pub use path_tracer::{Iterations, PathTracer, Tile};
pub use progressive::Progressive;
pub use pt_shaders::records::{Background, SamplerKind};
pub use records::{Heuristic, Strategy};

mod kernels {
    include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
}
