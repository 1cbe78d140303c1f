//! The passes on the CPU, in simple loops: what the kernels are tested against.

mod atrous;
mod composite;
mod frame;
mod temporal;
mod variance;

pub use atrous::atrous;
pub use composite::{Pixel, composite, diffuse_albedo, specular_f0};
pub use frame::{Accumulated, Guided, Light, Rgb};
pub use temporal::{History, accumulate};
pub use variance::{spatial_variance, temporal_variance};
