//! `variance.comp` and `variance_spatial.comp`.

use super::frame::{
    Accumulated, Guided, History, Light, cosine, depth_weight, limited, luminance, mean_without_brightest,
    neighbour, same_path, usable,
};
use crate::DenoiseParams;

/// Variances of accumulated light.
pub fn temporal_variance(size: [u32; 2], histories: &[History], params: &DenoiseParams) -> Vec<Accumulated> {
    let pixels: Vec<Guided> = histories.iter().map(|history| history.pixel).collect();
    let luminances: Vec<_> = histories
        .iter()
        .map(|h| (h.length > 0 && h.pixel.material != 0).then(|| [luminance(h.hf), luminance(h.spec)]))
        .collect();
    let variance = |i: usize| {
        luminances[i]?;
        let History { length, spec_length, moments, .. } = histories[i];
        let around = around(size, i, &pixels, &luminances, params);
        Some([0, 1].map(|channel| {
            let length = [length, spec_length][channel];
            if length < params.atrous.min_length {
                return around[channel];
            }
            let alpha = f64::from([params.temporal.alpha_hf, params.temporal.alpha_spec][channel]);
            let share = (1.0 / f64::from(length)).max(alpha / (2.0 - alpha));
            let [mean, square] = [moments[2 * channel], moments[2 * channel + 1]];
            (square - mean * mean).max(0.0) * share / (1.0 - share).max(0.5)
        }))
    };
    let light = |(i, h): (usize, &History)| match variance(i) {
        Some(variance) => Accumulated { hf: h.hf, spec: h.spec, variance },
        None => Accumulated::MISSING,
    };
    histories.iter().enumerate().map(light).collect()
}

/// Variances of one frame by itself.
pub fn spatial_variance(
    size: [u32; 2],
    pixels: &[Guided],
    light: &[Light],
    params: &DenoiseParams,
) -> Vec<Accumulated> {
    let samples: Vec<_> = pixels.iter().zip(light).map(|(p, l)| usable(p, l)).collect();
    let luminances: Vec<_> = samples.iter().map(|sample| sample.map(|s| s.map(luminance))).collect();
    let filtered = |i: usize| {
        let mut sample = samples[i]?;
        for (channel, colour) in sample.iter_mut().enumerate() {
            let around: Vec<f64> = (0..9)
                .filter(|k| *k != 4)
                .filter_map(|k| luminances[neighbour(size, i, [k % 3 - 1, k / 3 - 1])?])
                .map(|l| l[channel])
                .collect();
            let limit = params.temporal.firefly.map_or(0.0, f64::from) * mean_without_brightest(&around);
            *colour = limited(*colour, limit);
        }
        let variance = around(size, i, pixels, &luminances, params);
        Some(Accumulated { hf: sample[0], spec: sample[1], variance })
    };
    (0..pixels.len()).map(|i| filtered(i).unwrap_or(Accumulated::MISSING)).collect()
}

/// Unbiased weighted variance over 7 x 7 pixels.
fn around(
    size: [u32; 2],
    i: usize,
    pixels: &[Guided],
    luminances: &[Option<[f64; 2]>],
    params: &DenoiseParams,
) -> [f64; 2] {
    let (depth, normal) = (f64::from(params.atrous.depth), f64::from(params.atrous.normal));
    let own = luminances[i].unwrap_or_default();
    let mut taps = Vec::new();
    for offset in (0..49).map(|k| [k % 7 - 3, k / 7 - 3]) {
        let Some(q) = neighbour(size, i, offset) else { continue };
        let Some(l) = luminances[q] else { continue };
        let (a, b) = (&pixels[i], &pixels[q]);
        if !same_path(a, b, offset) {
            continue;
        }
        let pixels = (offset[0] as f64).hypot(offset[1] as f64);
        let w = if offset == [0, 0] {
            1.0
        } else {
            depth_weight(a, b, pixels, depth) * (normal * (cosine(a.normal, b.normal) - 1.0).min(0.0)).exp()
        };
        taps.push((w, l));
    }
    let total: f64 = taps.iter().map(|(w, _)| w).sum();
    let spread = 1.0 - taps.iter().map(|(w, _)| w * w).sum::<f64>() / (total * total);
    [0, 1].map(|channel| {
        if spread < 1e-3 {
            return own[channel] * own[channel];
        }
        let mean = taps.iter().map(|(w, l)| w * l[channel]).sum::<f64>() / total;
        taps.iter().map(|(w, l)| w * (l[channel] - mean).powi(2)).sum::<f64>() / total / spread
    })
}
