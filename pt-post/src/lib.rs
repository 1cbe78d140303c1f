//! What happens to the flat frame: running mean, exposure, tone curve, display encoding.

#![forbid(unsafe_code)]

mod accumulate;
pub mod oracle;
mod params;
mod records;
mod tone_map;

mod kernels {
    include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
}

pub use accumulate::Accumulate;
pub use params::{ExposureMode, Output, PostParams, Tonemap, exposure_scale};
pub use records::ExposureRecord;
pub use tone_map::{Radiance, ToneMap};
