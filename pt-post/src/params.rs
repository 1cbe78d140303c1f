//! Knobs of everything that happens to the flat frame.

use crate::bloom::BloomParams;
use crate::fsr::FsrParams;
use crate::records::*;
use crate::taa::TaaParams;
use pt_core::FrameSizes;
use pt_core::settings::{InvalidValue, Validate, check_range};
use serde::{Deserialize, Serialize};

/// How the exposure is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ExposureMode {
    /// From the frame's luminance histogram, with the eye's adaptation.
    Auto,
    /// `ev100`.
    Manual,
    /// From `aperture`, `shutter` and `iso`, as a camera would.
    Camera,
}

/// Curve from exposed values to display values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Tonemap {
    /// Narkowicz's fit of the ACES reference rendering (2015), per channel.
    Aces,
    /// Hill's fit of the ACES reference rendering and sRGB output transforms, with their desaturation.
    AcesHill,
    /// AgX, base look (Sobotka 2022).
    Agx,
    /// Khronos PBR Neutral (2024): base colours stay what they are.
    Neutral,
    /// Curve of least contrast distortion for the frame's histogram (Eilertsen et al. 2015), blended with Reinhard's.
    NoiseAware,
    /// `x / (1 + x)` per channel (Reinhard et al. 2002, eq. 3).
    Reinhard,
    /// Clamp to 0..1.
    None,
}

impl Tonemap {
    /// All curves.
    pub const ALL: [Self; 7] =
        [Self::Aces, Self::AcesHill, Self::Agx, Self::Neutral, Self::NoiseAware, Self::Reinhard, Self::None];

    pub(crate) fn code(self) -> u32 {
        match self {
            Self::Aces => TONEMAP_ACES,
            Self::AcesHill => TONEMAP_ACES_HILL,
            Self::Agx => TONEMAP_AGX,
            Self::Neutral => TONEMAP_NEUTRAL,
            Self::NoiseAware => TONEMAP_NOISE_AWARE,
            Self::Reinhard => TONEMAP_REINHARD,
            Self::None => TONEMAP_NONE,
        }
    }
}

/// What the picture's codes mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Encoding {
    /// sRGB (IEC 61966-2-1), 8 bits: every display.
    Srgb,
    /// PQ (SMPTE ST 2084) with Rec. 2020 primaries: HDR displays and files.
    Pq,
    /// Linear, Rec. 709 primaries, 1 = 80 cd/m2 (IEC 61966-2-2): HDR on a desktop.
    Scrgb,
}

impl Encoding {
    pub(crate) fn code(self) -> u32 {
        match self {
            Self::Srgb => ENCODING_SRGB,
            Self::Pq => ENCODING_PQ,
            Self::Scrgb => ENCODING_SCRGB,
        }
    }

    /// Whether the picture is in `display_hdr` rather than `display`.
    pub fn is_hdr(self) -> bool {
        self != Self::Srgb
    }
}

/// How a frame smaller than the picture becomes the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Upscale {
    /// Not at all: both have one size.
    None,
    /// Temporal anti-aliasing that collects the samples of several frames.
    Taau,
    /// AMD FidelityFX Super Resolution 1: one frame alone, edges first.
    Fsr1,
}

/// What an EXR of `pt render` holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Output {
    /// Linear scene radiance before exposure.
    Linear,
    /// The tone-mapped picture.
    Display,
}

/// Knobs of the noise-aware tone curve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CurveParams {
    /// Dynamic range of the display, 1 to 16 stops. Default 7.
    pub range: f32,
    /// From how many stops below the metered luminance on noise is expected, 0 to 16. Default 8.
    pub noise_stops: f32,
    /// Slope of the curve there, 0 (all the same) to 1 (contrast as in the scene). Default 0.5.
    pub noise_slope: f32,
    /// Standard deviation of the blur of the curve's slopes, 0 to 32 bins of a quarter stop. Default 12.
    pub blur: f32,
    /// Stops on top of the curve, -8 to 8. Default -1.
    pub bias: f32,
    /// Share of auto-exposed Reinhard (2002, eq. 4), 0 to 1. Default 0.5.
    pub reinhard: f32,
    /// Display value from which on the curve bends towards white, 0.1 to 0.99. Default 0.6.
    pub knee: f32,
    /// Value that becomes white, 1.1 to 1000. Default 10.
    pub white_point: f32,
}

impl Default for CurveParams {
    fn default() -> Self {
        Self {
            range: 7.0,
            noise_stops: 8.0,
            noise_slope: 0.5,
            blur: 12.0,
            bias: -1.0,
            reinhard: 0.5,
            knee: 0.6,
            white_point: 10.0,
        }
    }
}

impl Validate for CurveParams {
    fn validate(&self) -> Result<(), InvalidValue> {
        check_range("range", self.range, 1.0..=16.0, "stops")?;
        check_range("noise_stops", self.noise_stops, 0.0..=16.0, "stops")?;
        check_range("noise_slope", self.noise_slope, 0.0..=1.0, "")?;
        check_range("blur", self.blur, 0.0..=32.0, "bins")?;
        check_range("bias", self.bias, -8.0..=8.0, "stops")?;
        check_range("reinhard", self.reinhard, 0.0..=1.0, "")?;
        check_range("knee", self.knee, 0.1..=0.99, "")?;
        check_range("white_point", self.white_point, 1.1..=1000.0, "")
    }
}

/// Knobs of everything that happens to the flat frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PostParams {
    /// How a frame smaller than the picture becomes the picture: `none`, `taau` or `fsr1`. Default `none`.
    pub upscale: Upscale,
    /// Sides of the frame over those of the picture, 0.25 to 1; below 1 only with `upscale`. Default 1.
    pub render_scale: f32,
    /// Temporal anti-aliasing and upscaling.
    pub taa: TaaParams,
    /// Bloom.
    pub bloom: BloomParams,
    /// How the exposure is found: `auto`, `manual` or `camera`. Default `auto`.
    pub exposure: ExposureMode,
    /// Exposure value at ISO 100 in manual mode, and in auto mode for a frame without any light; -32 to 32 stops. Radiance
    /// `1.2 * 2^ev100` is exposed to 1 (Lagarde and de Rousiers 2014, section 5.1).
    pub ev100: f32,
    /// Exposure compensation, -16 to 16 stops; positive is brighter, in all modes.
    pub compensation: f32,
    /// Camera: f-number, 0.5 to 64. Default 4.
    pub aperture: f32,
    /// Camera: exposure time in seconds, 1e-5 to 60. Default 1/60.
    pub shutter: f32,
    /// Camera: sensitivity, ISO 1 to 1e6. Default 100.
    pub iso: f32,
    /// Auto: share of the lit pixels below the metered range, 0 to `meter_high` - 0.01.
    pub meter_low: f32,
    /// Auto: share of the lit pixels up to the upper end of the metered range, 0.01 to 1. The default range is that of the
    /// Quake II RTX tone mapper: small bright sources and most shadows do not count.
    pub meter_high: f32,
    /// Auto: how far the metered range lies above the scene's average, -8 to 8 stops. The meter takes what it measures for
    /// middle grey; the brighter fifth of the default range is a stop above that.
    pub meter_bias: f32,
    /// Auto: how much less the pixels weigh that are far from the middle of the frame, 0 (not at all) to 1. Default 0.
    pub centre_weight: f32,
    /// Auto: adaptation to more light, 0 to 1000 per second: after 1/x seconds 1/e of the difference in stops is left.
    /// Default 2.
    pub speed_up: f32,
    /// Auto: adaptation to less light, as `speed_up`. Default 1.
    pub speed_down: f32,
    /// Auto: least exposure value, -32 to `max_ev100` stops.
    pub min_ev100: f32,
    /// Auto: greatest exposure value, to 32 stops.
    pub max_ev100: f32,
    /// Tone curve: `aces`, `aces-hill`, `agx`, `neutral`, `noise-aware`, `reinhard` or `none`.
    pub tonemap: Tonemap,
    /// The noise-aware curve.
    pub curve: CurveParams,
    /// What the picture's codes mean: `srgb`, `pq` or `scrgb`. Default `srgb`.
    pub encoding: Encoding,
    /// HDR output: luminance of display value 1, 10 to 1000 cd/m2. Default 203 (ITU-R BT.2408).
    pub paper_white: f32,
    /// HDR output: greatest luminance, 80 to 10000 cd/m2. Default 1000.
    pub peak: f32,
    /// Whether 8-bit codes are dithered with blue noise, so that dark gradients do not band. Default true.
    pub dither: bool,
    /// Sharpening and upscaling of the display codes.
    pub fsr: FsrParams,
    /// What an EXR of `pt render` holds.
    pub output: Output,
}

impl Default for PostParams {
    fn default() -> Self {
        Self {
            upscale: Upscale::None,
            render_scale: 1.0,
            taa: TaaParams::default(),
            bloom: BloomParams::default(),
            exposure: ExposureMode::Auto,
            ev100: 0.0,
            compensation: 0.0,
            aperture: 4.0,
            shutter: 1.0 / 60.0,
            iso: 100.0,
            meter_low: 0.7,
            meter_high: 0.9,
            meter_bias: 1.0,
            centre_weight: 0.0,
            speed_up: 2.0,
            speed_down: 1.0,
            min_ev100: -16.0,
            max_ev100: 20.0,
            tonemap: Tonemap::Aces,
            curve: CurveParams::default(),
            encoding: Encoding::Srgb,
            paper_white: 203.0,
            peak: 1000.0,
            dither: true,
            fsr: FsrParams::default(),
            output: Output::Linear,
        }
    }
}

impl Validate for PostParams {
    fn validate(&self) -> Result<(), InvalidValue> {
        check_range("render_scale", self.render_scale, 0.25..=1.0, "")?;
        if self.render_scale < 1.0 && self.upscale == Upscale::None {
            return Err(InvalidValue {
                key: "render_scale".into(),
                value: self.render_scale.to_string(),
                expected: "1 without upscale (taau or fsr1)".into(),
            });
        }
        self.taa.validate().map_err(|e| e.within("taa"))?;
        self.bloom.validate().map_err(|e| e.within("bloom"))?;
        check_range("ev100", self.ev100, -32.0..=32.0, "EV")?;
        check_range("compensation", self.compensation, -16.0..=16.0, "stops")?;
        check_range("aperture", self.aperture, 0.5..=64.0, "")?;
        check_range("shutter", self.shutter, 1e-5..=60.0, "s")?;
        check_range("iso", self.iso, 1.0..=1e6, "")?;
        // A range of no width has no pixels to meter.
        check_range("meter_low", self.meter_low, 0.0..=self.meter_high - 0.01, "")?;
        check_range("meter_high", self.meter_high, 0.01..=1.0, "")?;
        check_range("meter_bias", self.meter_bias, -8.0..=8.0, "stops")?;
        check_range("centre_weight", self.centre_weight, 0.0..=1.0, "")?;
        check_range("speed_up", self.speed_up, 0.0..=1000.0, "per second")?;
        check_range("speed_down", self.speed_down, 0.0..=1000.0, "per second")?;
        check_range("min_ev100", self.min_ev100, -32.0..=self.max_ev100, "EV")?;
        check_range("max_ev100", self.max_ev100, -32.0..=32.0, "EV")?;
        self.curve.validate().map_err(|e| e.within("curve"))?;
        check_range("paper_white", self.paper_white, 10.0..=1000.0, "cd/m2")?;
        check_range("peak", self.peak, 80.0..=10_000.0, "cd/m2")?;
        self.fsr.validate().map_err(|e| e.within("fsr"))
    }
}

impl PostParams {
    /// Whether temporal anti-aliasing runs: asked for, or needed to upscale.
    pub fn uses_taa(&self) -> bool {
        self.taa.enabled || self.upscale == Upscale::Taau
    }

    /// Whether codes are upscaled or sharpened after the tone map.
    pub fn uses_fsr(&self) -> bool {
        self.upscale == Upscale::Fsr1 || self.fsr.sharpen
    }

    /// Whether display codes are made larger.
    pub fn upscales_codes(&self) -> bool {
        self.upscale == Upscale::Fsr1 && self.render_scale != 1.0
    }

    /// Sizes of the frame for a picture of `output_size`.
    pub fn sizes(&self, output_size: [u32; 2]) -> FrameSizes {
        let frame = self.render_size(output_size);
        // What comes before FSR 1 has the size of the frame, what comes after temporal upscaling that of the picture.
        let resolved = if self.upscale == Upscale::Taau { output_size } else { frame };
        FrameSizes { frame, resolved, output: output_size }
    }

    /// Size of the frame for a picture of `output_size`, at least one pixel.
    pub fn render_size(&self, output_size: [u32; 2]) -> [u32; 2] {
        output_size.map(|side| ((side as f32 * self.render_scale).round() as u32).max(1))
    }

    /// Bias on texture levels of detail that an upscaled frame wants: `log2` of the render scale, 0 without upscaling.
    pub fn mip_bias(&self) -> f32 {
        self.render_scale.log2()
    }

    /// EV100 of the modes that do not meter.
    pub fn fixed_ev100(&self) -> f32 {
        match self.exposure {
            ExposureMode::Camera => camera_ev100(self.aperture, self.shutter, self.iso),
            ExposureMode::Auto | ExposureMode::Manual => self.ev100,
        }
    }
}

/// Exposure value at ISO 100 of a camera's settings: `log2(N^2 / t * 100 / S)` (Lagarde and de Rousiers 2014, section 5.1).
pub fn camera_ev100(aperture: f32, shutter: f32, iso: f32) -> f32 {
    (aperture * aperture / shutter * 100.0 / iso).log2()
}

/// Factor that takes scene radiance to exposed values.
pub fn exposure_scale(ev100: f32, compensation: f32) -> f32 {
    (compensation - ev100).exp2() / 1.2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_checked() {
        let default = PostParams::default();
        default.validate().unwrap();
        let key = |params: PostParams| params.validate().unwrap_err().key;
        assert_eq!(key(PostParams { meter_low: 0.9, ..default.clone() }), "meter_low");
        assert_eq!(key(PostParams { ev100: f32::NAN, ..default.clone() }), "ev100");
        assert_eq!(key(PostParams { min_ev100: 25.0, ..default.clone() }), "min_ev100");
        assert_eq!(key(PostParams { compensation: 17.0, ..default.clone() }), "compensation");
        assert_eq!(key(PostParams { render_scale: 0.5, ..default.clone() }), "render_scale");
        let scaled = |render_scale| PostParams { render_scale, upscale: Upscale::Fsr1, ..default.clone() };
        scaled(0.5).validate().unwrap();
        assert_eq!(key(scaled(0.2)), "render_scale");
        assert_eq!(key(scaled(1.5)), "render_scale");
        let curve = CurveParams { white_point: 1.0, ..CurveParams::default() };
        assert_eq!(key(PostParams { curve, ..default }), "curve.white_point");
    }

    /// The exposure table of any camera manual: sunny 16, and one stop for each doubling.
    #[test]
    fn camera_exposure_follows_its_definition() {
        assert_eq!(camera_ev100(1.0, 1.0, 100.0), 0.0);
        assert!((camera_ev100(16.0, 1.0 / 125.0, 100.0) - 14.965_784).abs() < 1e-5);
        let ev = camera_ev100(2.8, 1.0 / 60.0, 400.0);
        assert!((camera_ev100(2.8, 1.0 / 120.0, 400.0) - ev - 1.0).abs() < 1e-5);
        assert!((camera_ev100(2.8, 1.0 / 60.0, 800.0) - ev + 1.0).abs() < 1e-5);
        // Lmax = 1.2 * 2^EV100 is exposed to 1.
        for ev100 in [-3.0f32, 0.0, 7.5, 15.0] {
            let saturating = 1.2 * ev100.exp2();
            assert!((exposure_scale(ev100, 0.0) * saturating - 1.0).abs() < 1e-6);
        }
        // A meter that reads an 18 % grey card under E lux sets EV100 = log2(0.18 E / pi * 8): the card comes out at
        // 12.5 / 100 / 1.2 of the saturating luminance, whatever E is.
        for lux in [1.0f32, 400.0, 1e5] {
            let luminance = 0.18 * lux / std::f32::consts::PI;
            let ev100 = (luminance * 100.0 / 12.5).log2();
            assert!((exposure_scale(ev100, 0.0) * luminance - 0.125 / 1.2).abs() < 1e-6);
        }
    }

    #[test]
    fn sizes_are_rounded_and_never_empty() {
        let half = PostParams { upscale: Upscale::Taau, render_scale: 0.5, ..PostParams::default() };
        assert_eq!(half.render_size([1280, 720]), [640, 360]);
        assert_eq!(half.render_size([3, 1]), [2, 1]);
        assert_eq!(half.mip_bias(), -1.0);
        assert_eq!(PostParams::default().mip_bias(), 0.0);
    }
}
