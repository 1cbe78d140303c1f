//! `histogram.comp`, `meter.comp`, `curve.comp`.

use crate::params::{CurveParams, PostParams};
use crate::records::*;

/// Luminance histogram: weight of the pixels per bin, and the weighted sum of their places within it.
pub fn histogram(size: [u32; 2], pixels: &[[f32; 3]], centre_weight: f32) -> (Vec<u64>, Vec<u64>) {
    let mut counts = vec![0; HISTOGRAM_BINS as usize];
    let mut steps = counts.clone();
    for (index, c) in pixels.iter().enumerate() {
        let y = 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
        if c.iter().all(|v| v.is_finite()) && y.is_finite() && y > 0.0 {
            let octave = f64::from(y).log2().floor();
            let within_octave = f64::from(y) / octave.exp2() - 1.0;
            let bin = (octave - f64::from(MIN_LOG_LUMINANCE) + within_octave) * f64::from(1 << BIN_BITS);
            let place = (bin * f64::from(1 << STEP_BITS)).floor();
            let place = place.clamp(0.0, f64::from((HISTOGRAM_BINS << STEP_BITS) - 1)) as u32;

            let column = index as u32 % size[0];
            let row = index as u32 / size[0];
            let centred = |at: u32, side: u32| (f64::from(at) + 0.5) / f64::from(side) - 0.5;
            let distance = centred(column, size[0]).hypot(centred(row, size[1]));
            let share = (1.0 - 1.5 * distance).clamp(0.01, 1.0);
            let weight = 1.0 + (share - 1.0) * f64::from(centre_weight);
            let weight = ((weight * f64::from(FULL_WEIGHT) + 0.5) as u64).max(1);
            counts[(place >> STEP_BITS) as usize] += weight;
            steps[(place >> STEP_BITS) as usize] += weight * u64::from(place % (1 << STEP_BITS));
        }
    }
    (counts, steps)
}

/// EV100 that the meter finds for `pixels`, without adaptation and compensation.
pub fn meter(size: [u32; 2], pixels: &[[f32; 3]], params: &PostParams) -> f64 {
    let (counts, steps) = histogram(size, pixels, params.centre_weight);
    let total: f64 = counts.iter().map(|&n| n as f64).sum();
    let (low, high) = (f64::from(params.meter_low) * total, f64::from(params.meter_high) * total);
    let (mut weight, mut sum, mut below) = (0.0, 0.0, 0.0);
    for (bin, (&count, &step_sum)) in counts.iter().zip(&steps).enumerate() {
        let end = below + count as f64;
        let inside = f64::min(end, high) - f64::max(below, low);
        below = end;
        if inside > 0.0 {
            let place = (step_sum as f64 / count as f64 + 0.5) / f64::from(1 << STEP_BITS);
            let position = (bin as f64 + place) / f64::from(1 << BIN_BITS);
            let log_luminance =
                f64::from(MIN_LOG_LUMINANCE) + position.floor() + (1.0 + position.fract()).log2();
            weight += inside;
            sum += inside * log_luminance;
        }
    }
    if weight == 0.0 {
        return f64::from(params.fixed_ev100());
    }
    let ev100 = sum / weight + (100.0f64 / 12.5).log2() - f64::from(params.meter_bias);
    ev100.clamp(params.min_ev100.into(), params.max_ev100.into())
}

/// EV100 after `dt` seconds of adaptation from `adapted` to `metered`: `1 - exp(-dt * speed)` of the way.
pub fn adapt(adapted: f64, metered: f64, dt: f64, params: &PostParams) -> f64 {
    let speed = if metered > adapted { params.speed_up } else { params.speed_down };
    adapted + (metered - adapted) * (1.0 - (-dt.max(0.0) * f64::from(speed)).exp())
}

/// The noise-aware curve of a frame that is adapted to `ev100`, from the shares of the curve's bins: log2 display luminance at
/// the lower edge of each bin and at the end of the last.
pub fn noise_aware_curve(shares: &[f64], ev100: f64, params: &CurveParams) -> Vec<f64> {
    let bins = shares.len();
    let per_octave = f64::from(CURVE_BINS_PER_OCTAVE);
    let range = f64::from(params.range);
    let bins_of_range = range * per_octave;
    let noise_at = (ev100 - 3.0 - f64::from(params.noise_stops) - f64::from(MIN_LOG_LUMINANCE)) * per_octave;
    let noise_bin = (noise_at + 0.5).clamp(0.0, bins as f64 - 66.0) as usize;

    let empty = 1e-6;
    let p: Vec<f64> = shares.iter().map(|s| (s + empty) / (1.0 + empty * bins as f64)).collect();
    let mut inside: Vec<bool> = (0..bins).map(|bin| bin >= noise_bin).collect();
    let set = |inside: &[bool]| {
        let members = (0..bins).filter(|&bin| inside[bin]);
        members.fold((0.0, 0.0), |(n, sum), bin| (n + 1.0, sum + 1.0 / p[bin]))
    };
    for _ in 0..16 {
        let (n, sum) = set(&inside);
        inside = (0..bins).map(|bin| bin >= noise_bin && p[bin] * sum >= n - bins_of_range).collect();
    }
    let (n, sum) = set(&inside);
    let slope = |bin: usize| {
        if inside[bin] { (1.0 - (n - bins_of_range) / (p[bin] * sum)).max(0.0) } else { 0.0 }
    };
    let slopes: Vec<f64> = (0..bins).map(slope).collect();
    let blurred = |bin: usize| {
        if bin < noise_bin || params.blur == 0.0 {
            return slopes[bin];
        }
        let (mut total, mut weights) = (0.0, 0.0);
        for i in -13i64..=13 {
            let weight = (-0.5 * (i * i) as f64 / f64::from(params.blur).powi(2)).exp();
            let at = (bin as i64 + i).clamp(noise_bin as i64, bins as i64 - 1) as usize;
            total += weight * slopes[at];
            weights += weight;
        }
        total / weights
    };
    let slopes: Vec<f64> = (0..bins).map(blurred).collect();
    let used: f64 = slopes.iter().sum();
    let mut curve: Vec<f64> = (0..=noise_bin)
        .map(|edge| -range - f64::from(params.noise_slope) / per_octave * (noise_bin - edge) as f64)
        .collect();
    for slope in &slopes[noise_bin..] {
        curve.push(curve[curve.len() - 1] + slope / used * range);
    }
    curve
}
