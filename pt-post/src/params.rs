//! Knobs of post-processing.

use crate::bloom::BloomParams;
use crate::records::{Encoding, Tonemap};
use crate::taa::TaaParams;
use pt_core::settings::{InvalidValue, check_range};
use pt_core::{FrameSizes, knobs};
use pt_shaders::named_enum;

named_enum! {
    /// How the exposure is found.
    pub enum ExposureMode {
        /// From the frame's luminance histogram, with the eye's adaptation.
        Auto = "auto",
        /// `ev100`.
        Manual = "manual",
        /// From `aperture`, `shutter` and `iso`, as a camera would.
        Camera = "camera",
    }
}

impl Encoding {
    /// Whether the picture is in `display_hdr` rather than `display`.
    pub fn is_hdr(self) -> bool {
        self != Self::Srgb
    }
}

named_enum! {
    /// How a frame smaller than the picture becomes the picture.
    pub enum Upscale {
        /// Not at all: both have one size.
        None = "none",
        /// Temporal anti-aliasing that collects the samples of several frames.
        Taau = "taau",
        /// AMD FidelityFX Super Resolution 1: one frame alone, edges first.
        Fsr1 = "fsr1",
    }
}

named_enum! {
    /// What an EXR of `pt render` holds.
    pub enum Output {
        /// Linear scene radiance before exposure.
        Linear = "linear",
        /// The tone-mapped picture.
        Display = "display",
    }
}

knobs! {
    /// Knobs of the noise-aware tone curve.
    pub struct CurveParams {
        /// Dynamic range of the display.
        pub range: f32 = 7.0, in 1.0..=16.0, unit "stops", source "Eilertsen et al. 2015";
        /// Luminance below which noise is expected, in stops below the metered luminance.
        pub noise_stops: f32 = 8.0, in 0.0..=16.0, unit "stops", source "Eilertsen et al. 2015, section 5";
        /// Slope of the curve where noise is expected: 0 shows no contrast, 1 the contrast of the scene.
        pub noise_slope: f32 = 0.5, in 0.0..=1.0, source "Eilertsen et al. 2015, section 5";
        /// Standard deviation of the blur of the curve's slopes; a bin is a quarter of a stop.
        pub blur: f32 = 12.0, in 0.0..=32.0, unit "bins";
        /// Exposure added after the curve.
        pub bias: f32 = -1.0, in -8.0..=8.0, unit "stops";
        /// Share of Reinhard's curve, with automatic exposure, in the result.
        pub reinhard: f32 = 0.5, in 0.0..=1.0, source "Reinhard et al. 2002, eq. 4";
        /// Display value above which the curve bends towards white.
        pub knee: f32 = 0.6, in 0.1..=0.99;
        /// Exposed value that is shown as white.
        pub white_point: f32 = 10.0, in 1.1..=1000.0, source "Reinhard et al. 2002, eq. 4";
    }
}

/// Quality presets of FSR 1: name and factor between the sides of frame and picture.
pub const PRESETS: &[(&str, f32)] =
    &[("ultra-quality", 1.3), ("quality", 1.5), ("balanced", 1.7), ("performance", 2.0)];

knobs! {
    /// Knobs of upscaling and sharpening.
    pub struct FsrParams {
        /// Whether RCAS sharpens pictures that FSR does not upscale.
        pub sharpen: bool = false => structural;
        /// Reduction of the sharpening from its maximum; 1 is closest to native pictures, AMD and Quake II RTX have 0.2.
        pub sharpness: f32 = 1.0, in 0.0..=10.0, unit "stops", source "Lottes 2021";
        /// Whether pixels that differ much from their neighbours, as noise does, are sharpened less.
        pub denoise: bool = false, source "Lottes 2021";
    }
}

knobs! {
    /// Knobs of everything that happens to the flat frame.
    pub struct PostParams {
        /// How the frame is upscaled to the size of the picture.
        pub upscale: Upscale = Upscale::None => structural;
        /// Width and height of the frame relative to the picture; below 1 only with `upscale`.
        pub render_scale: f32 = 1.0, in 0.25..=1.0 => structural;
        /// Temporal anti-aliasing and upscaling.
        pub taa: TaaParams;
        /// Bloom.
        pub bloom: BloomParams;
        /// How the exposure is found.
        pub exposure: ExposureMode = ExposureMode::Auto, source "Lagarde and de Rousiers 2014, section 5.1";
        /// Exposure value at ISO 100 in manual mode, and in auto mode for a frame without any light: radiance `1.2 * 2^ev100` is exposed
        /// to 1.
        pub ev100: f32 = 0.0, in -32.0..=32.0, unit "EV", source "Lagarde and de Rousiers 2014, section 5.1";
        /// Exposure compensation in all modes; positive is brighter.
        pub compensation: f32 = 0.0, in -16.0..=16.0, unit "stops";
        /// Camera: f-number.
        pub aperture: f32 = 4.0, in 0.5..=64.0, source "Lagarde and de Rousiers 2014, section 5.1";
        /// Camera: exposure time.
        pub shutter: f32 = 1.0 / 60.0, in 1e-5..=60.0, unit "s", source "Lagarde and de Rousiers 2014, section 5.1";
        /// Camera: ISO sensitivity.
        pub iso: f32 = 100.0, in 1.0..=1e6, source "Lagarde and de Rousiers 2014, section 5.1";
        /// Auto: share of the lit pixels below the metered range; at least 0.01 less than `meter_high`.
        pub meter_low: f32 = 0.7, in 0.0..=0.99, source "tone mapper of Quake II RTX";
        /// Auto: share of the lit pixels up to the upper end of the metered range; small bright sources and most shadows do not count.
        pub meter_high: f32 = 0.9, in 0.01..=1.0, source "tone mapper of Quake II RTX";
        /// Auto: the exposure value is lowered by this, because the metered range is brighter than the average of the frame.
        pub meter_bias: f32 = 1.0, in -8.0..=8.0, unit "stops";
        /// Auto: how much less pixels far from the centre of the frame weigh; 0: all weigh the same.
        pub centre_weight: f32 = 0.0, in 0.0..=1.0;
        /// Auto: rate of adaptation to more light: after 1/x seconds, 1/e of the difference in stops is left.
        pub speed_up: f32 = 2.0, in 0.0..=1000.0, unit "per second";
        /// Auto: rate of adaptation to less light, as `speed_up`.
        pub speed_down: f32 = 1.0, in 0.0..=1000.0, unit "per second";
        /// Auto: least exposure value; at most `max_ev100`.
        pub min_ev100: f32 = -16.0, in -32.0..=32.0, unit "EV";
        /// Auto: greatest exposure value.
        pub max_ev100: f32 = 20.0, in -32.0..=32.0, unit "EV";
        /// Tone curve.
        pub tonemap: Tonemap = Tonemap::Aces => structural;
        /// The noise-aware curve.
        pub curve: CurveParams;
        /// What the picture's codes mean.
        pub encoding: Encoding = Encoding::Srgb => structural;
        /// HDR output: luminance of display value 1.
        pub paper_white: f32 = 203.0, in 10.0..=1000.0, unit "cd/m2", source "ITU-R BT.2408";
        /// HDR output: greatest luminance.
        pub peak: f32 = 1000.0, in 80.0..=10_000.0, unit "cd/m2";
        /// Whether 8-bit codes are dithered with blue noise, so that dark gradients do not band.
        pub dither: bool = true, source "Ulichney 1993, void and cluster";
        /// Sharpening and upscaling of the display codes.
        pub fsr: FsrParams;
        /// What an EXR of `pt render` holds.
        pub output: Output = Output::Linear;
        check Self::check_together;
    }
}

impl PostParams {
    /// What ranges of single knobs cannot say.
    fn check_together(&self) -> Result<(), InvalidValue> {
        if self.render_scale < 1.0 && self.upscale == Upscale::None {
            return Err(InvalidValue {
                key: "render_scale".into(),
                value: self.render_scale.to_string(),
                expected: "1 without upscale (taau or fsr1)".into(),
            });
        }
        // A range of no width has no pixels to meter.
        check_range("meter_low", self.meter_low, 0.0..=self.meter_high - 0.01, "")?;
        check_range("min_ev100", self.min_ev100, -32.0..=self.max_ev100, "EV")
    }

    /// Whether temporal anti-aliasing runs: asked for, or needed to upscale.
    pub fn uses_taa(&self) -> bool {
        self.taa.enabled || self.upscale == Upscale::Taau
    }

    /// Whether the exposure or the tone curve depends on the radiance of the frame.
    pub fn meters(&self) -> bool {
        self.exposure == ExposureMode::Auto || self.tonemap == Tonemap::NoiseAware
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
    use pt_core::settings::Knobs;

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
