//! The passes on the CPU, in simple loops: what the kernels are tested against.

mod atrous;
mod composite;
mod frame;
mod gradients;
mod low_frequency;
mod temporal;
mod variance;

pub use atrous::atrous;
pub use composite::{Pixel, composite, diffuse_albedo, specular_f0};
pub use frame::{Accumulated, Guided, Light, Rgb};
pub use gradients::{Adaptive, GradientSample, filter_gradients, gradients, strata, sums_direct, sums_lf};
pub use low_frequency::{LfHistory, LowFrequency, Tile, accumulate_lf, atrous_lf, downsample, upsample};
pub use temporal::{History, accumulate};
pub use variance::{spatial_variance, temporal_variance};
