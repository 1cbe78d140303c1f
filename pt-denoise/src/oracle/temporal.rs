//! `temporal.comp` and its forms.

use super::frame::{
    Guided, Light, Rgb, cosine, limited, luminance, mean_without_brightest, neighbour, usable,
};
use super::gradients::{Adaptive, kept_frames};
use super::reflections::{self, Reflections};
use crate::TemporalParams;

/// What a pixel carries to the next frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct History {
    /// The pixel that it belongs to.
    pub pixel: Guided,
    /// Diffuse light.
    pub hf: Rgb,
    /// Specular light.
    pub spec: Rgb,
    /// Means of luminance and squared luminance, diffuse and specular.
    pub moments: [f64; 4],
    /// Frames; 0 = none.
    pub length: u32,
    /// The same of specular light, which may have a history of its own.
    pub spec_length: u32,
}

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
                *length = if again { *length } else { (*length + 1).min(crate::passes::MAX_LENGTH) };
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

/// Where the surface of a pixel was in the last frame, flat pixels, and its distance there.
pub(super) fn place_before(size: [u32; 2], i: usize, pixel: &Guided) -> Option<[f32; 2]> {
    let [mx, my, mz, _] = pixel.motion;
    let moves = pixel.material != 0 && mx.is_finite() && my.is_finite() && mz.is_finite();
    let own = [i % size[0] as usize, i / size[0] as usize];
    // In the precision of the kernel, which decides about pixels on a border.
    moves.then(|| [0, 1].map(|k| own[k] as f32 + [mx, my][k] * size[k] as f32))
}

/// Whether pixel `was`, at `at` in the last frame, shows the surface of pixel `i`; `more`: further tolerance of the distance.
pub(super) fn shows_surface(
    size: [u32; 2],
    i: usize,
    pixel: &Guided,
    at: [i64; 2],
    was: &Guided,
    more: f32,
    params: &TemporalParams,
) -> bool {
    let own = [i % size[0] as usize, i / size[0] as usize];
    let depth = pixel.depth + pixel.motion[2];
    let tolerance = params.depth * depth.abs() + 2.0 / pixel.motion[3].max(1e-18) + more;
    let other_field = (at[0] + at[1] + own[0] as i64 + own[1] as i64) % 2 != 0;
    (was.material, was.flags) == (pixel.material, pixel.flags)
        && !(pixel.has_two_paths() && other_field)
        && (was.depth - depth).abs() <= tolerance
        && cosine(was.vertex_normal, pixel.vertex_normal) >= f64::from(params.normal).to_radians().cos()
}

/// The pixels of the last frame that show the surface of pixel `i`, with their bilinear weights. `previous`: pixels of the last frame.
pub(super) fn taps<'a>(
    size: [u32; 2],
    i: usize,
    pixel: &Guided,
    previous: &dyn Fn(usize) -> &'a Guided,
    params: &TemporalParams,
) -> Vec<(f64, usize)> {
    let Some(place) = place_before(size, i, pixel) else { return Vec::new() };
    taps_at(size, i, pixel, place, 0.0, previous, params)
}

/// The same around another place; `more`: further tolerance of the distance, metres.
pub(super) fn taps_at<'a>(
    size: [u32; 2],
    i: usize,
    pixel: &Guided,
    place: [f32; 2],
    more: f32,
    previous: &dyn Fn(usize) -> &'a Guided,
    params: &TemporalParams,
) -> Vec<(f64, usize)> {
    let corner = place.map(f32::floor);
    let f = [0, 1].map(|k| place[k] - corner[k]);
    let mut found = Vec::new();
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let weight = (if dx == 1 { f[0] } else { 1.0 - f[0] }) * (if dy == 1 { f[1] } else { 1.0 - f[1] });
        let at = [corner[0] as i64 + dx, corner[1] as i64 + dy];
        if f64::from(weight) < 1e-3 || !(0..2).all(|k| (0..i64::from(size[k])).contains(&at[k])) {
            continue;
        }
        let tap = (at[1] * i64::from(size[0]) + at[0]) as usize;
        if shows_surface(size, i, pixel, at, previous(tap), more, params) {
            found.push((f64::from(weight), tap));
        }
    }
    found
}
