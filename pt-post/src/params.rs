//! Knobs of exposure, tone mapping and output.

use crate::records::{TONEMAP_ACES, TONEMAP_NONE, TONEMAP_REINHARD};
use pt_core::settings::{InvalidValue, Validate, check_range};

/// How the exposure is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ExposureMode {
    /// From the frame's luminance histogram, every frame by itself.
    Auto,
    /// `ev100`.
    Manual,
}

/// Curve from exposed values to display values, per channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Tonemap {
    /// Narkowicz's fit of the ACES reference rendering (2015).
    Aces,
    /// `x / (1 + x)` (Reinhard et al. 2002, eq. 3).
    Reinhard,
    /// Clamp to 0..1.
    None,
}

impl Tonemap {
    pub(crate) fn code(self) -> u32 {
        match self {
            Self::Aces => TONEMAP_ACES,
            Self::Reinhard => TONEMAP_REINHARD,
            Self::None => TONEMAP_NONE,
        }
    }
}

/// What an EXR of `pt render` holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Output {
    /// Linear scene radiance before exposure.
    Linear,
    /// The tone-mapped picture.
    Display,
}

/// Knobs of exposure, tone mapping and output.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PostParams {
    /// How the exposure is found.
    pub exposure: ExposureMode,
    /// Exposure value at ISO 100 in manual mode, and in auto mode for a frame without any light; -32 to 32 stops. Radiance
    /// `1.2 * 2^ev100` is exposed to 1 (Lagarde and de Rousiers 2014, section 5.1).
    pub ev100: f32,
    /// Exposure compensation, -16 to 16 stops; positive is brighter, in both modes.
    pub compensation: f32,
    /// Auto: share of the lit pixels below the metered range, 0 to `meter_high` - 0.01.
    pub meter_low: f32,
    /// Auto: share of the lit pixels up to the upper end of the metered range, 0.01 to 1. The default range is that of the
    /// Quake II RTX tone mapper: small bright sources and most shadows do not count.
    pub meter_high: f32,
    /// Auto: how far the metered range lies above the scene's average, -8 to 8 stops. The meter takes what it measures for
    /// middle grey; the brighter fifth of the default range is a stop above that.
    pub meter_bias: f32,
    /// Auto: least exposure value, -32 to `max_ev100` stops.
    pub min_ev100: f32,
    /// Auto: greatest exposure value, to 32 stops.
    pub max_ev100: f32,
    /// Tone curve.
    pub tonemap: Tonemap,
    /// What an EXR of `pt render` holds.
    pub output: Output,
}

impl Default for PostParams {
    fn default() -> Self {
        Self {
            exposure: ExposureMode::Auto,
            ev100: 0.0,
            compensation: 0.0,
            meter_low: 0.7,
            meter_high: 0.9,
            meter_bias: 1.0,
            min_ev100: -16.0,
            max_ev100: 20.0,
            tonemap: Tonemap::Aces,
            output: Output::Linear,
        }
    }
}

impl Validate for PostParams {
    fn validate(&self) -> Result<(), InvalidValue> {
        check_range("ev100", self.ev100, -32.0..=32.0, "EV")?;
        check_range("compensation", self.compensation, -16.0..=16.0, "stops")?;
        // A range of no width has no pixels to meter.
        check_range("meter_low", self.meter_low, 0.0..=self.meter_high - 0.01, "")?;
        check_range("meter_high", self.meter_high, 0.01..=1.0, "")?;
        check_range("meter_bias", self.meter_bias, -8.0..=8.0, "stops")?;
        check_range("min_ev100", self.min_ev100, -32.0..=self.max_ev100, "EV")?;
        check_range("max_ev100", self.max_ev100, -32.0..=32.0, "EV")
    }
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
        assert_eq!(key(PostParams { compensation: 17.0, ..default }), "compensation");
    }
}
