//! The first visible surface: primary rays into the split G-buffer; then mirrors and glass are replaced by what they show.
//!
//! * [`PrimaryRays`]: one ray a pixel through a thin lens; at its hit the whole contract is written: visibility, normals,
//!   material, motion, inverse footprint depth, ray-cone texture gradients;
//! * [`Effects`]: particles, sprites, beams and fog between the camera and these surfaces, if the scene has any;
//! * [`Godrays`]: the medium between the camera and these surfaces, with the sunlight that it scatters, if there is one;
//! * [`ReflectRefract`]: at mirrors and glass one ray on; the surface that it finds takes the place of the first one. The pass
//!   is repeated [`GbufferParams::reflect_refract`] times;
//! * [`ReplacedMotion`]: where the last frame shows what is seen in curved mirrors and through glass;
//! * [`oracle`]: the same mathematics on the CPU.
#![forbid(unsafe_code)]

mod camera_interior;
mod effects;
mod godrays;
mod hidden_lobes;
pub mod images;
mod jitter;
pub mod oracle;
mod params;
mod planes;
mod primary;
pub mod records;
mod reflect_refract;
mod replaced_motion;

pub use effects::Effects;
pub use godrays::{Godrays, GodraysParams};
pub use hidden_lobes::hidden_lobes;
pub use jitter::{frame_jitter, halton, r2};
pub use params::{Decomposition, GbufferParams, Jitter, MotionOfReplaced, TextureFilter, ThinRefraction};
pub use planes::plane_count;
pub use primary::PrimaryRays;
pub use reflect_refract::ReflectRefract;
pub use replaced_motion::ReplacedMotion;

mod kernels {
    include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
}
