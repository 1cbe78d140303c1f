//! Post-processing of the flat frame: accumulation or temporal anti-aliasing, bloom, exposure, tone curve, display codes,
//! upscaling. [`PostChain`] composes the stages.

#![forbid(unsafe_code)]

mod accumulate;
mod bloom;
mod chain;
mod dither;
mod exposure;
mod fsr;
pub mod images;
mod matte;
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
pub use chain::{ChainParts, PostChain, Written};
pub use exposure::{Exposure, Metered};
pub use fsr::Fsr;
pub use matte::Matte;
pub use params::{
    CurveParams, ExposureMode, FsrParams, Output, PRESETS, PostParams, Upscale, camera_ev100, exposure_scale,
};
pub use picture::{PictureError, picture_layers, write_picture};
pub use records::{ClipSpace, Encoding, ExposureRecord, Rectify, Tonemap};
pub use taa::{Taa, TaaParams};
pub use tone_map::ToneMap;
