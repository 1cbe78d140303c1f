//! `temporal.comp` and its forms.

use super::antilag::{Adaptive, kept_frames};
use super::frame::{
    Guided, History, Light, Rgb, limited, luminance, mean_without_brightest, neighbour, usable,
};
use super::reflections::{self, Reflections};
use super::reprojection::taps;
use crate::TemporalParams;

/// Accumulates a frame of flat pixels into the histories of the frame before; `None`: there is none. `adaptive`: of `asvgf`; `reflections`: where specular history
/// follows mirror images.
pub fn accumulate(
    size: [u32; 2],
    pixels: &[Guided],
    light: &[Light],
    previous: Option<&[History]>,
    params: &TemporalParams,
    adaptive: Option<Adaptive<'_>>,
    reflections: Option<&Reflections<'_>>,
) -> Vec<History> {
    let samples: Vec<_> = pixels.iter().zip(light).map(|(p, l)| usable(p, l)).collect();
    (0..pixels.len())
        .map(|i| {
            let pixel = pixels[i];
            let past = previous.map(|previous| reproject(size, i, &pixel, previous, params));
            let mut now = History { pixel, ..past.unwrap_or_default() };
            if let (Some(reflections), Some(previous)) = (reflections, previous) {
                let own = reflections::specular_history(size, i, &pixel, previous, params, reflections);
                (now.spec, now.moments[2], now.moments[3], now.spec_length) =
                    (own.light, own.moments[0], own.moments[1], own.length);
            }
            let (mut lag, mut repeated) = ([0.0; 2], false);
            if let Some(adaptive) = adaptive {
                let is_repeated;
                (lag, is_repeated) = adaptive.direct(size, i);
                repeated = is_repeated && now.length > 0;
                now.length = kept_frames(now.length, lag[0].max(lag[1]));
                now.spec_length = kept_frames(now.spec_length, lag[0].max(lag[1]));
                if repeated && now.length == 0 {
                    return now;
                }
            }
            let Some(mut sample) = samples[i] else { return now };
            if let Some(firefly) = params.firefly {
                for (channel, colour) in sample.iter_mut().enumerate() {
                    let around: Vec<f64> = (0..9)
                        .filter(|k| *k != 4)
                        .filter_map(|k| samples[neighbour(size, i, [k % 3 - 1, k / 3 - 1])?])
                        .map(|around| luminance(around[channel]))
                        .collect();
                    let expected = mean_without_brightest(&around).max(now.moments[2 * channel]);
                    *colour = limited(*colour, f64::from(firefly) * expected);
                }
            }
            let again = [repeated && now.length > 0, repeated && now.spec_length > 0];
            for (length, again) in [(&mut now.length, again[0]), (&mut now.spec_length, again[1])] {
                *length = if again { *length } else { (*length + 1).min(crate::histories::MAX_LENGTH) };
            }
            let lengths = [now.length, now.spec_length];
            let weight = |channel: usize, least: f32, lag: f32| {
                let own = (1.0 / f64::from(lengths[channel])).max(f64::from(least));
                let own = if again[channel] { 0.0 } else { own };
                own + (1.0 - own) * f64::from(lag)
            };
            let mix = |a: Rgb, b: Rgb, t: f64| [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * t);
            now.hf = mix(now.hf, sample[0], weight(0, params.alpha_hf, lag[0]));
            now.spec = mix(now.spec, sample[1], weight(1, params.alpha_spec, lag[1]));
            let [a, b] = sample.map(luminance);
            let moments = [a, a * a, b, b * b];
            let t = [0, 1].map(|c| weight(c, params.alpha_moments, lag[0].max(lag[1])));
            now.moments = [0, 1, 2, 3].map(|k| now.moments[k] + (moments[k] - now.moments[k]) * t[k / 2]);
            now
        })
        .collect()
}

fn reproject(
    size: [u32; 2],
    i: usize,
    pixel: &Guided,
    previous: &[History],
    params: &TemporalParams,
) -> History {
    let mut sum = History::default();
    let (mut weights, mut length) = (0.0, 0.0);
    for (weight, tap) in taps(size, i, pixel, &|j| &previous[j].pixel, params) {
        let was = &previous[tap];
        if was.length > 0 {
            for k in 0..3 {
                sum.hf[k] += weight * was.hf[k];
                sum.spec[k] += weight * was.spec[k];
            }
            (0..4).for_each(|k| sum.moments[k] += weight * was.moments[k]);
            length += weight * f64::from(was.length);
            weights += weight;
        }
    }
    if weights == 0.0 {
        return History::default();
    }
    History {
        hf: sum.hf.map(|v| v / weights),
        spec: sum.spec.map(|v| v / weights),
        moments: sum.moments.map(|v| v / weights),
        length: ((length / weights).round() as u32).max(1),
        spec_length: ((length / weights).round() as u32).max(1),
        ..sum
    }
}
