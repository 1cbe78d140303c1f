//! Records and constants that the kernels share with the host (`post_records.glsl`).

use pt_shaders::glam::{UVec2, Vec2};
use pt_shaders::{gpu_struct, named_enum};

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
/// The same of `easu_half.comp`.
pub const EASU_HALF_ROWS: u32 = 4;
/// Columns of pixels that a group of `rcas.comp`, `rcas_codes.comp` or `rcas_half.comp` does; two threads more read their neighbours.
pub const RCAS_COLUMNS: u32 = 30;
/// Rows of pixels that it does, even.
pub const RCAS_ROWS: u32 = 16;
/// Side of the square of pixels that a thread of `histogram.comp` counts.
pub const HISTOGRAM_SPAN: u32 = 4;
/// Texels that a thread of `bloom_blur.comp` makes, beside each other along the blurred axis; odd.
pub const BLUR_OUTPUTS: u32 = 3;
/// Largest `BlurPush::radius`.
pub const BLUR_MAX_RADIUS: u32 = 400;

named_enum! {
    /// Curve from exposed values to display values; `TONEMAP_*` in GLSL.
    pub enum Tonemap: "TONEMAP" {
        /// Narkowicz's fit of the ACES reference rendering (2015), per channel.
        Aces = "aces",
        /// Hill's fit of the ACES reference rendering and sRGB output transforms, with their desaturation.
        AcesHill = "aces-hill",
        /// AgX, base look (Sobotka 2022).
        Agx = "agx",
        /// Khronos PBR Neutral (2024): base colours stay what they are.
        Neutral = "neutral",
        /// Curve of least contrast distortion for the frame's histogram (Eilertsen et al. 2015), blended with Reinhard's.
        NoiseAware = "noise-aware",
        /// `x / (1 + x)` per channel (Reinhard et al. 2002, eq. 3).
        Reinhard = "reinhard",
        /// Clamp to 0..1.
        None = "none",
    }
}

named_enum! {
    /// What the picture's codes mean; `ENCODING_*` in GLSL.
    pub enum Encoding: "ENCODING" {
        /// sRGB (IEC 61966-2-1), 8 bits: every display.
        Srgb = "srgb",
        /// PQ (SMPTE ST 2084) with Rec. 2020 primaries: HDR displays and files.
        Pq = "pq",
        /// Linear, Rec. 709 primaries, 1 = 80 cd/m2 (IEC 61966-2-2): HDR on a desktop.
        Scrgb = "scrgb",
    }
}

named_enum! {
    /// In which space history is compared with the neighbourhood and blended; `SPACE_*` in GLSL.
    pub enum ClipSpace: "SPACE" {
        /// PQ codes of R, G, B: steps look alike at all luminances.
        Pq = "pq",
        /// Compared in luma and chroma (YCoCg) of the PQ codes: a tighter box along grey; blended in PQ.
        Ycocg = "ycocg",
        /// Linear R, G, B: blends keep energy, bright pixels dominate.
        Rgb = "rgb",
    }
}

named_enum! {
    /// What happens to history outside of the neighbourhood's box; `RECTIFY_*` in GLSL.
    pub enum Rectify: "RECTIFY" {
        /// Nothing: no aliasing, but moving things leave trails.
        Off = "off",
        /// Each channel is clamped.
        Clamp = "clamp",
        /// The colour moves towards the mean until it is inside: keeps its hue.
        Clip = "clip",
    }
}

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
    /// Push constants of `matte.comp`.
    pub struct MattePush {
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
