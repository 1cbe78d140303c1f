//! The direct lighting pass.
//!
//! [`DirectLighting`] lights the surfaces of the G-buffer; how lights are chosen and sampled is pt-light-sampling's part.

mod caustics;
mod direct;
pub mod images;
mod nee_at;
pub mod oracle;
mod params;
pub mod records;
mod restir;
mod shadow_rays;
pub mod synthetic;

pub use caustics::caustic_targets;
pub use direct::{Counted, DirectLighting};
pub use nee_at::NeeAt;
pub use params::DirectParams;
pub use restir::duplicated_samples;

mod kernels {
    include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
}
