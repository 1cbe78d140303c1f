//! Records and constants that the kernels share with the host (`post_records.glsl`).

use pt_shaders::glam::{UVec2, Vec2};
use pt_shaders::gpu_struct;

/// Bins of the luminance histogram: 32 octaves, 8 bins each.
pub const HISTOGRAM_BINS: u32 = 256;
/// Base-2 logarithm of the bins per octave.
pub const BIN_BITS: u32 = 3;
/// Base-2 logarithm of the steps in which a pixel's place within its bin is counted.
pub const STEP_BITS: u32 = 4;
/// Base-2 logarithm of the histogram's lowest luminance.
pub const MIN_LOG_LUMINANCE: i32 = -16;
/// Weight of a pixel that counts fully.
pub const FULL_WEIGHT: u32 = 64;

/// Bins of the noise-aware curve: 32 octaves, 4 bins each.
pub const CURVE_BINS: u32 = 128;
/// Bins of the noise-aware curve per octave.
pub const CURVE_BINS_PER_OCTAVE: u32 = 4;

/// Columns of pixels that a group of `taa.comp` does; two threads more read their neighbours.
pub const TAA_COLUMNS: u32 = 62;
/// Rows of pixels that it does.
pub const TAA_ROWS: u32 = 8;
/// Rows of pixels that a thread of `tonemap.comp` and `tonemap_codes.comp` does.
pub const TONEMAP_ROWS: u32 = 4;
/// Rows of pixels that a thread of `easu.comp` does: a divisor of 16.
pub const EASU_ROWS: u32 = 2;
/// Columns of pixels that a group of `rcas.comp` or `rcas_codes.comp` does; two threads more read their neighbours.
pub const RCAS_COLUMNS: u32 = 30;
/// Rows of pixels that it does.
pub const RCAS_ROWS: u32 = 16;
/// Side of the square of pixels that a thread of `histogram.comp` counts.
pub const HISTOGRAM_SPAN: u32 = 4;
/// Texels that a thread of `bloom_blur.comp` makes, beside each other along the blurred axis; odd.
pub const BLUR_OUTPUTS: u32 = 3;
/// Largest `BlurPush::radius`.
pub const BLUR_MAX_RADIUS: u32 = 400;

/// `TonemapPush::operator`: clamp.
pub const TONEMAP_NONE: u32 = 0;
/// `TonemapPush::operator`: Reinhard.
pub const TONEMAP_REINHARD: u32 = 1;
/// `TonemapPush::operator`: Narkowicz's ACES fit.
pub const TONEMAP_ACES: u32 = 2;
/// `TonemapPush::operator`: Hill's ACES fit.
pub const TONEMAP_ACES_HILL: u32 = 3;
/// `TonemapPush::operator`: AgX.
pub const TONEMAP_AGX: u32 = 4;
/// `TonemapPush::operator`: Khronos PBR Neutral.
pub const TONEMAP_NEUTRAL: u32 = 5;
/// `TonemapPush::operator`: noise-aware curve blended with Reinhard.
pub const TONEMAP_NOISE_AWARE: u32 = 6;

/// `TonemapPush::encoding`: sRGB codes.
pub const ENCODING_SRGB: u32 = 0;
/// `TonemapPush::encoding`: PQ codes, Rec. 2020 primaries.
pub const ENCODING_PQ: u32 = 1;
/// `TonemapPush::encoding`: linear, 1 = 80 cd/m2, Rec. 709 primaries.
pub const ENCODING_SCRGB: u32 = 2;

/// `TaaPush::space`: PQ codes of R, G, B.
pub const SPACE_PQ: u32 = 0;
/// `TaaPush::space`: luma and chroma of PQ codes.
pub const SPACE_YCOCG: u32 = 1;
/// `TaaPush::space`: linear R, G, B.
pub const SPACE_RGB: u32 = 2;

/// `TaaPush::rectify`: history as it is.
pub const RECTIFY_OFF: u32 = 0;
/// `TaaPush::rectify`: each channel clamped.
pub const RECTIFY_CLAMP: u32 = 1;
/// `TaaPush::rectify`: moved towards the mean until it is inside.
pub const RECTIFY_CLIP: u32 = 2;

gpu_struct! {
    /// The exposure of a frame.
    pub struct ExposureRecord {
        /// Exposure value at ISO 100, without the compensation; adapted, in auto mode.
        pub ev100: f32,
        /// Factor that takes scene radiance to exposed values: `2^compensation / (1.2 * 2^ev100)`.
        pub scale: f32,
        /// What the meter read in this frame, EV100: where adaptation goes.
        pub metered_ev100: f32,
        /// Pixels that the meter counted, by their weight: finite, luminance above 0. 0 when it did not run.
        pub metered_pixels: f32,
    }
}

gpu_struct! {
    /// Push constants of `histogram.comp`.
    pub struct HistogramPush {
        /// 0: all pixels weigh the same; 1: full centre weighting.
        pub centre_weight: f32,
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
        /// Result without any pixel to meter, and of a manual exposure, EV100.
        pub fallback_ev100: f32,
        /// Exposure compensation, stops.
        pub compensation: f32,
        /// Share of the way towards a greater EV100 that this frame goes; 1 = all of it.
        pub adapt_up: f32,
        /// Share of the way towards a smaller one.
        pub adapt_down: f32,
        /// 1 = the exposure is `fallback_ev100`; only what is metered is found.
        pub manual: u32,
    }
}

gpu_struct! {
    /// Push constants of `curve.comp`; see `CurveParams`.
    pub struct CurvePush {
        /// Dynamic range of the display, stops.
        pub range: f32,
        /// Stops below the adapted luminance from which on noise is expected.
        pub noise_stops: f32,
        /// Slope of the curve there.
        pub noise_slope: f32,
        /// Standard deviation of the blur of the slopes, bins; 0 = none.
        pub blur: f32,
        /// As in `MeterPush`.
        pub adapt_up: f32,
        /// As in `MeterPush`.
        pub adapt_down: f32,
    }
}

gpu_struct! {
    /// Push constants of `tonemap.comp` and `tonemap_codes.comp`.
    pub struct TonemapPush {
        /// 1 = dither 8-bit codes.
        pub dither: u32,
        /// 1 = the exposure is manual: the noise-aware curve, which follows the histogram, is moved along.
        pub manual: u32,
        /// Noise-aware curve: stops on top of it.
        pub bias: f32,
        /// Share of Reinhard's curve in the noise-aware one.
        pub reinhard: f32,
        /// Display value from which on the noise-aware curve bends towards white; not for HDR output.
        pub knee: f32,
        /// Value that becomes white, knee and Reinhard part of the noise-aware curve.
        pub white_point: f32,
        /// Exposure compensation, stops.
        pub compensation: f32,
        /// Luminance of display value 1 for HDR output, cd/m2.
        pub paper_white: f32,
        /// Greatest luminance for HDR output, cd/m2.
        pub peak: f32,
        /// Share of the light that the bloom spreads; 0 = no bloom.
        pub glow_share: f32,
    }
}

gpu_struct! {
    /// Push constants of `accumulate.comp`.
    pub struct AccumulatePush {
        /// 1 = start over with this frame.
        pub reset: u32,
    }
}

gpu_struct! {
    /// Push constants of `taa.comp`; see `TaaParams`.
    pub struct TaaPush {
        /// Where in its pixel this frame was sampled, from the centre, pixels of the input.
        pub jitter: Vec2,
        /// `SPACE_*`.
        pub space: u32,
        /// 1 = new and old are mixed as linear radiance, 0 = as the codes of `space`.
        pub blend_linear: u32,
        /// `RECTIFY_*`.
        pub rectify: u32,
        /// Half width of the box that history must lie in, standard deviations.
        pub sigma: f32,
        /// Factor on it where reflection and refraction share the pixel.
        pub split_sigma: f32,
        /// Half width that the pixel's own changes over time give the box at least, mean absolute deviations.
        pub temporal: f32,
        /// Most that a pixel may exceed the mean of its neighbours, as a factor; 0 = no limit.
        pub sparkle_limit: f32,
        /// Weight of a new frame once history is full, where something moves.
        pub blend: f32,
        /// The same where nothing moves.
        pub blend_still: f32,
        /// Luminance of radiance 1 on the PQ scale, cd/m2.
        pub pq_scale: f32,
        /// 1 = there is no history.
        pub reset: u32,
    }
}

gpu_struct! {
    /// Push constants of `bloom_blur.comp`.
    pub struct BlurPush {
        /// 1 = along columns, 0 = along rows.
        pub vertical: u32,
        /// Standard deviation, texels.
        pub sigma: f32,
        /// Taps on either side, at most `BLUR_MAX_RADIUS`.
        pub radius: u32,
    }
}

gpu_struct! {
    /// Push constants of `bloom_up.comp` and `bloom_mix.comp`.
    pub struct MixPush {
        /// Share of the blurred image.
        pub share: f32,
    }
}

gpu_struct! {
    /// Push constants of `rcas.comp` and `rcas_codes.comp`.
    pub struct RcasPush {
        /// Factor on the strongest sharpening that does not clip; 0 = copy.
        pub strength: f32,
        /// 1 = sharpen less where a pixel stands out from its neighbours, as noise does.
        pub denoise: u32,
        /// `ENCODING_*` of the output; `ENCODING_SCRGB` decodes the PQ codes that are sharpened.
        pub encoding: u32,
        /// 1 = dither 8-bit codes.
        pub dither: u32,
    }
}

gpu_struct! {
    /// Push constants of `easu.comp`.
    pub struct EasuPush {
        /// Input size, texels.
        pub input_size: UVec2,
    }
}
