//! `atrous_permuted.glsl` and `atrous_dilated.glsl`.

use super::frame::{Accumulated, Guided, Rgb, cosine, depth_weight, luminance, neighbour, same_path};
use crate::{AtrousKernel, AtrousParams};

/// One level of the filter over a flat frame.
pub fn atrous(
    size: [u32; 2],
    pixels: &[Guided],
    light: &[Accumulated],
    level: u32,
    params: &AtrousParams,
) -> Vec<Accumulated> {
    let step = 1i64 << level;
    let smooth = |i: usize, c: usize| -> Option<f64> {
        (light[i].variance[c] >= 0.0).then_some(())?;
        let taps: Vec<_> = (0..9)
            .map(|k| [k % 3 - 1, k / 3 - 1])
            .filter_map(|o| {
                let variance = light[neighbour(size, i, o.map(|v: i64| v * step))?].variance[c];
                (variance >= 0.0).then_some((0.5f64.powi((o[0].abs() + o[1].abs()) as i32), variance))
            })
            .collect();
        let total: f64 = taps.iter().map(|(w, _)| w).sum();
        Some(taps.iter().map(|(w, v)| w * v).sum::<f64>() / total)
    };
    let smoothed: Vec<_> = (0..light.len()).map(|i| [0, 1].map(|c| smooth(i, c))).collect();
    (0..light.len()).map(|i| filter(size, pixels, light, &smoothed, i, step, params)).collect()
}

impl AtrousKernel {
    /// Weights along an axis, from the middle on.
    const fn weights(self) -> &'static [f64] {
        match self {
            Self::Three => &[0.5, 0.25],
            Self::Five => &[0.375, 0.25, 0.0625],
        }
    }
}

fn filter(
    size: [u32; 2],
    pixels: &[Guided],
    light: &[Accumulated],
    smoothed: &[[Option<f64>; 2]],
    i: usize,
    step: i64,
    params: &AtrousParams,
) -> Accumulated {
    let (p, own) = (&pixels[i], light[i]);
    if p.normal == 0 {
        return own;
    }
    let channels = |light: &Accumulated| [light.hf, light.spec];
    // Per channel: weights without and with the luminance, index.
    let mut taps: [Vec<(f64, f64, usize)>; 2] = Default::default();
    let weights = params.kernel.weights();
    let radius = weights.len() as i64 - 1;
    let offsets = (-radius..=radius).flat_map(|y| (-radius..=radius).map(move |x| [x, y]));
    for offset in offsets {
        let Some(j) = neighbour(size, i, offset.map(|v| v * step)) else { continue };
        let q = &pixels[j];
        if j == i || q.normal == 0 || !same_path(p, q, offset.map(|v| v * step)) {
            continue;
        }
        let [x, y] = offset.map(|v| v.unsigned_abs() as usize);
        let distance = step as f64 * (x as f64).hypot(y as f64);
        let w = weights[x] * weights[y] * depth_weight(p, q, distance, params.depth.into());
        let turn = (cosine(p.normal, q.normal) - 1.0).min(0.0);
        let [rough_p, rough_q] = [p.roughness, q.roughness].map(f64::from);
        let alpha = rough_p.min(rough_q).powi(2).max(1e-4);
        let reach = f64::from(params.lobe) * alpha;
        let lobe = (-(distance * f64::from(p.pixel_angle) / reach).powi(2)).exp();
        let alike = (1.0 - 10.0 * (rough_p - rough_q).abs()).max(0.0);
        let normal = f64::from(params.normal);
        let power = (8.0 / (reach * reach)).clamp(normal, 1e4);
        let geometric = [w * (normal * turn).exp(), w * lobe * alike * (power * turn).exp()];
        for c in 0..2 {
            let Some(variance) = smoothed[j][c] else { continue };
            let sigma = f64::from([params.luminance_hf, params.luminance_spec][c]);
            let l = smoothed[i][c].map_or(1.0, |own_variance| {
                let difference = luminance(channels(&own)[c]) - luminance(channels(&light[j])[c]);
                (-difference.abs() / (sigma * own_variance.max(variance).sqrt() + 1e-20)).exp()
            });
            taps[c].push((geometric[c], geometric[c] * l, j));
        }
    }
    let mut colours: [Rgb; 2] = channels(&own);
    let mut variances = own.variance;
    for c in 0..2 {
        let taken: f64 = taps[c].iter().map(|t| t.1).sum();
        let known = own.variance[c] >= 0.0;
        let total = match known {
            true => taps[c].iter().map(|t| t.0).sum::<f64>() + weights[0] * weights[0],
            false if taken > 1e-12 => taken,
            false => continue,
        };
        let rest = if known { 1.0 - taken / total } else { 0.0 };
        let before = colours[c];
        let sum = |of: &dyn Fn(usize) -> f64| taps[c].iter().map(|t| t.1 / total * of(t.2)).sum::<f64>();
        colours[c] = [0, 1, 2].map(|k| rest * before[k] + sum(&|j| channels(&light[j])[c][k]));
        let others: f64 = taps[c].iter().map(|t| (t.1 / total).powi(2) * light[t.2].variance[c]).sum();
        variances[c] = others + rest * rest * own.variance[c].max(0.0);
    }
    Accumulated { hf: colours[0], spec: colours[1], variance: variances }
}

#[cfg(test)]
mod tests {
    /// The weight by normals is an exponential of the cosine, where Schied et al. 2017 take a power of it.
    #[test]
    fn the_exponential_is_close_to_the_power() {
        for sharpness in [1.0, 8.0, 128.0, 1024.0] {
            let greater = |k: i32| {
                let cosine: f64 = f64::from(k) / 100_000.0;
                (sharpness * (cosine - 1.0)).exp() - cosine.powf(sharpness)
            };
            let [least, most] = [f64::min, f64::max].map(|pick| (0..=100_000).map(greater).fold(0.0, pick));
            assert!(least >= 0.0 && most < 0.37 / sharpness, "{sharpness}: {least} to {most}");
        }
    }
}
