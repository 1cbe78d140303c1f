//! Accumulation, metering and tone mapping on the CPU: what the kernels are tested against.

use crate::params::{PostParams, Tonemap};
use crate::records::{BIN_BITS, HISTOGRAM_BINS, MIN_LOG_LUMINANCE, STEP_BITS};

/// Running mean of one channel of one pixel, in the arithmetic of `accumulate.comp`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RunningMean {
    /// What the channel holds.
    pub mean: f32,
    /// What rounding left out of `mean`.
    pub residual: f32,
    /// Samples so far.
    pub count: f32,
}

impl RunningMean {
    /// With one more sample; non-finite ones are left out.
    pub fn with(self, x: f32) -> Self {
        if !x.is_finite() {
            return self;
        }
        let count = self.count + 1.0;
        let change = ((x - self.mean) - self.residual) / count + self.residual;
        let mean = self.mean + change;
        let taken = mean - self.mean;
        let residual = (self.mean - (mean - taken)) + (change - taken);
        Self { mean, residual, count }
    }
}

/// Luminance histogram: pixels per bin, and the sum of their places within it.
pub fn histogram(pixels: &[[f32; 3]]) -> (Vec<u32>, Vec<u32>) {
    let mut counts = vec![0; HISTOGRAM_BINS as usize];
    let mut steps = counts.clone();
    for c in pixels {
        let y = 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
        if c.iter().all(|v| v.is_finite()) && y.is_finite() && y > 0.0 {
            let octave = f64::from(y).log2().floor();
            let within_octave = f64::from(y) / octave.exp2() - 1.0;
            let bin = (octave - f64::from(MIN_LOG_LUMINANCE) + within_octave) * f64::from(1 << BIN_BITS);
            let place = (bin * f64::from(1 << STEP_BITS)).floor();
            let place = place.clamp(0.0, f64::from((HISTOGRAM_BINS << STEP_BITS) - 1)) as u32;
            counts[(place >> STEP_BITS) as usize] += 1;
            steps[(place >> STEP_BITS) as usize] += place % (1 << STEP_BITS);
        }
    }
    (counts, steps)
}

/// EV100 that the meter finds for `pixels`, without the compensation.
pub fn meter(pixels: &[[f32; 3]], params: &PostParams) -> f64 {
    let (counts, steps) = histogram(pixels);
    let total: f64 = counts.iter().map(|&n| f64::from(n)).sum();
    let (low, high) = (f64::from(params.meter_low) * total, f64::from(params.meter_high) * total);
    let (mut weight, mut sum, mut below) = (0.0, 0.0, 0.0);
    for (bin, (&count, &step_sum)) in counts.iter().zip(&steps).enumerate() {
        let end = below + f64::from(count);
        let inside = f64::min(end, high) - f64::max(below, low);
        below = end;
        if inside > 0.0 {
            let place = (f64::from(step_sum) / f64::from(count) + 0.5) / f64::from(1 << STEP_BITS);
            let position = (bin as f64 + place) / f64::from(1 << BIN_BITS);
            let log_luminance =
                f64::from(MIN_LOG_LUMINANCE) + position.floor() + (1.0 + position.fract()).log2();
            weight += inside;
            sum += inside * log_luminance;
        }
    }
    if weight == 0.0 {
        return f64::from(params.ev100);
    }
    let ev100 = sum / weight + (100.0f64 / 12.5).log2() - f64::from(params.meter_bias);
    ev100.clamp(params.min_ev100.into(), params.max_ev100.into())
}

/// Tone curve: exposed value to linear display value, 0 to 1.
pub fn tone_curve(exposed: f64, tonemap: Tonemap) -> f64 {
    let x = exposed.clamp(0.0, 65504.0);
    let y = match tonemap {
        Tonemap::Aces => x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14),
        Tonemap::Reinhard => x / (1.0 + x),
        Tonemap::None => x,
    };
    y.min(1.0)
}

/// Linear display value to sRGB code value, both 0 to 1 (IEC 61966-2-1).
pub fn srgb_encode(x: f64) -> f64 {
    if x <= 0.0031308 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// Scene radiance to display code, 0 to 255, before rounding.
pub fn display_code(radiance: f32, scale: f32, tonemap: Tonemap) -> f64 {
    if radiance.is_nan() {
        return 0.0;
    }
    255.0 * srgb_encode(tone_curve(f64::from(radiance) * f64::from(scale), tonemap))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// IEC 61966-2-1 in both branches, at their seam and at its worked values.
    #[test]
    fn srgb_at_known_values() {
        for (linear, code) in [(0.0, 0.0), (0.001, 0.01292), (0.18, 0.461_356), (0.214_041, 0.5), (1.0, 1.0)]
        {
            assert!((srgb_encode(linear) - code).abs() < 1e-6, "{linear}");
        }
        assert!((srgb_encode(0.0031308) - srgb_encode(0.003_130_801)).abs() < 1e-6);
    }

    /// Values of the fitted curve worked out by hand from its five published coefficients.
    #[test]
    fn aces_at_known_values() {
        let known = [
            (0.0, 0.0),
            (0.18, 0.086724 / 0.324932),
            (0.5, 0.6425 / 1.0425),
            (1.0, 2.54 / 3.16),
            (2.0, 10.1 / 11.04),
        ];
        for (x, y) in known {
            assert!(
                (tone_curve(x, Tonemap::Aces) - y).abs() < 1e-12,
                "{x}: {}",
                tone_curve(x, Tonemap::Aces)
            );
        }
        assert_eq!(tone_curve(1.0, Tonemap::Reinhard), 0.5);
    }

    #[test]
    fn curves_rise_and_stay_in_range() {
        for tonemap in [Tonemap::Aces, Tonemap::Reinhard, Tonemap::None] {
            let mut last = -1e-12;
            for step in 0..20_000 {
                let y = tone_curve(10f64.powf(f64::from(step) / 2000.0 - 5.0), tonemap);
                assert!(
                    y >= last && (0.0..=1.0).contains(&y),
                    "{tonemap:?} at step {step}: {y} after {last}"
                );
                last = y;
            }
            assert_eq!(tone_curve(f64::INFINITY, tonemap).min(0.999), 0.999);
        }
    }
}
