//! The passes on the CPU, in simple loops: what the kernels are tested against.

mod antilag;
mod atrous;
mod composite;
mod frame;
mod gradient_pixels;
mod gradients;
mod low_frequency;
mod recurrent;
mod reflections;
mod reprojection;
mod temporal;
mod variance;

pub use antilag::{Adaptive, GradientSample, strata};
pub use atrous::atrous;
pub use composite::{Pixel, composite, diffuse_albedo, reflected, specular_f0};
pub use frame::{Accumulated, Guided, History, Light, Rgb};
pub use gradient_pixels::{Forward, Seen, brightest_candidates, forward_candidates};
pub use gradients::{filter_gradients, gradients, sums_direct, sums_lf};
pub use low_frequency::{
    LfHistory, LowFrequency, Tile, accumulate_lf, atrous_lf, deflicker, downsample, upsample,
};
pub use recurrent::{Lit, blur, fix_history};
pub use reflections::Reflections;
pub use temporal::accumulate;
pub use variance::{spatial_variance, temporal_variance};
