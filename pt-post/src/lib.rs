//! What happens to the flat frame: running mean or temporal anti-aliasing, bloom, exposure, tone curve, display codes,
//! upscaling. Each stage takes images and leaves its result in one; the caller puts them together.

#![forbid(unsafe_code)]

mod accumulate;
mod bloom;
mod blue_noise;
mod exposure;
mod fsr;
pub mod oracle;
mod params;
mod picture;
mod records;
mod taa;
mod tone_map;

mod kernels {
    include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
}

pub use accumulate::Accumulate;
pub use bloom::{Bloom, BloomMix, BloomMode, BloomParams, Bloomed, MAX_LEVELS};
pub use blue_noise::blue_noise;
pub use exposure::Exposure;
pub use fsr::{Fsr, FsrParams, PRESETS};
pub use params::{CurveParams, ExposureMode, Output, PostParams, Upscale, camera_ev100, exposure_scale};
pub use picture::{PictureError, picture_layers, write_picture};
pub use records::{ClipSpace, Encoding, ExposureRecord, Rectify, Tonemap};
pub use taa::{Taa, TaaParams};
pub use tone_map::ToneMap;

use pt_core::{ChannelImages, Image};
use pt_shaders::channels::{ACCUMULATED, FLAT_COLOR};

/// Which image holds the frame's linear radiance before bloom and exposure: what `taa` resolved, else the mean that `accumulate`
/// keeps, else the flat frame itself.
pub fn radiance<'a>(
    images: &'a ChannelImages,
    accumulate: Option<&Accumulate>,
    taa: Option<&'a Taa>,
) -> &'a Image {
    match taa {
        Some(taa) => taa.resolved(),
        None if accumulate.is_some() => images.current(ACCUMULATED),
        None => images.current(FLAT_COLOR),
    }
}
