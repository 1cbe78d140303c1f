//! Records and constants that the kernels share with the host (`post_records.glsl`).

use pt_shaders::gpu_struct;

/// Bins of the luminance histogram: 32 octaves, 8 bins each.
pub const HISTOGRAM_BINS: u32 = 256;
/// Base-2 logarithm of the bins per octave.
pub const BIN_BITS: u32 = 3;
/// Base-2 logarithm of the steps in which a pixel's place within its bin is counted. The sum over a bin fits 32 bits for
/// images of up to 16384 x 16384 pixels: 2^28 * (2^4 - 1) < 2^32.
pub const STEP_BITS: u32 = 4;
/// Base-2 logarithm of the histogram's lowest luminance.
pub const MIN_LOG_LUMINANCE: i32 = -16;

/// `TonemapPush::operator`: clamp to 0..1.
pub const TONEMAP_NONE: u32 = 0;
/// `TonemapPush::operator`: Reinhard.
pub const TONEMAP_REINHARD: u32 = 1;
/// `TonemapPush::operator`: ACES fit.
pub const TONEMAP_ACES: u32 = 2;

gpu_struct! {
    /// The exposure of a frame.
    pub struct ExposureRecord {
        /// Exposure value at ISO 100, without the compensation.
        pub ev100: f32,
        /// Factor that takes scene radiance to exposed values: `2^compensation / (1.2 * 2^ev100)`.
        pub scale: f32,
        /// Pixels that the meter counted: finite, luminance above 0. 0 in manual mode.
        pub metered_pixels: u32,
    }
}

gpu_struct! {
    /// Push constants of `meter.comp`; see `PostParams`.
    pub struct MeterPush {
        /// Start of the metered part of the histogram, as a fraction of the pixels.
        pub low: f32,
        /// Its end.
        pub high: f32,
        /// Stops by which the metered range lies above the average.
        pub bias: f32,
        /// Least result, EV100.
        pub min_ev100: f32,
        /// Greatest result, EV100.
        pub max_ev100: f32,
        /// Result without any pixel to meter, EV100.
        pub fallback_ev100: f32,
        /// Exposure compensation, stops.
        pub compensation: f32,
    }
}

gpu_struct! {
    /// Push constants of `tonemap.comp`.
    pub struct TonemapPush {
        /// `TONEMAP_*`.
        pub operator: u32,
    }
}

gpu_struct! {
    /// Push constants of `accumulate.comp`.
    pub struct AccumulatePush {
        /// 1 = start over with this frame.
        pub reset: u32,
    }
}
