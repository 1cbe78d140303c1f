//! `gradients.glsl`, `gradient_filter.glsl` and `antilag.glsl`.

use super::frame::{Guided, Light, luminance, usable};
use super::low_frequency::{LfHistory, LowFrequency, is_light};
use super::temporal::{History, taps};
use crate::{AntilagParams, DenoiseParams, GradientFilter, TemporalParams};

/// A gradient pixel: what `gradient_sample` says of a stratum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GradientSample {
    /// 1 + number of the pixel in the stratum; 0: there is none.
    pub number: u32,
    /// Luminance of the diffuse and of the specular light in the last frame.
    pub luminance: [f32; 2],
}

/// Strata of `side` pixels along both axes.
pub fn strata(size: [u32; 2], side: u32) -> [usize; 2] {
    size.map(|pixels| pixels.div_ceil(side) as usize)
}

/// The pixel with a number of a stratum, if it is in the picture.
pub(super) fn pixel_of(size: [u32; 2], side: u32, stratum: usize, number: usize) -> Option<usize> {
    let (across, side) = (strata(size, side)[0], side as usize);
    let at = [side * (stratum % across) + number % side, side * (stratum / across) + number / side];
    let inside = at[0] < size[0] as usize && at[1] < size[1] as usize;
    inside.then(|| at[1] * size[0] as usize + at[0])
}

/// Stratum and number of a pixel.
pub(super) fn stratum_of(size: [u32; 2], side: u32, i: usize) -> (usize, u32) {
    let [x, y] = [i % size[0] as usize, i / size[0] as usize];
    let across = strata(size, side)[0];
    let side = side as usize;
    (y / side * across + x / side, (y % side * side + x % side) as u32)
}

/// Change and greatest luminance of the gradient pixels: of diffuse, then of specular light.
pub fn gradients(
    size: [u32; 2],
    pixels: &[Guided],
    light: &[Light],
    samples: &[GradientSample],
    params: &AntilagParams,
) -> Vec<[f64; 4]> {
    let one = |(stratum, sample): (usize, &GradientSample)| {
        let number = sample.number.checked_sub(1)?;
        let i = pixel_of(size, params.stratum.side(), stratum, number as usize)?;
        // A gradient pixel has a surface.
        let pixel = Guided { material: 1, ..pixels[i] };
        let now = usable(&pixel, &light[i])?.map(luminance);
        let before = sample.luminance.map(f64::from);
        let top = [0, 1].map(|c| now[c].max(before[c]));
        let change = [0, 1].map(|c| ((now[c] - before[c]).abs() - f64::from(params.gate) * top[c]).max(0.0));
        Some([change[0], top[0], change[1], top[1]])
    };
    samples.iter().enumerate().map(|sample| one(sample).unwrap_or_default()).collect()
}

/// A history as the sums see it.
struct Before {
    mean: f64,
    second: f64,
    frames: f64,
}

/// Sums over strata of a light in this frame and in the history, and the variance of their difference, by the squares of the differences and by the moments of the
/// history. `now`: of a pixel; `before`: of a pixel of the last frame; `alpha`: least weight of a frame.
#[allow(clippy::too_many_arguments, reason = "of one light and the other")]
fn sums<'a>(
    size: [u32; 2],
    side: u32,
    pixels: &[Guided],
    now: &dyn Fn(usize) -> Option<f64>,
    previous: &dyn Fn(usize) -> &'a Guided,
    before: &dyn Fn(usize) -> Option<Before>,
    alpha: f32,
    params: &TemporalParams,
) -> Vec<[f64; 4]> {
    let [across, down] = strata(size, side);
    let one = |stratum: usize| {
        let mut sum = [0.0; 4];
        for i in (0..(side * side) as usize).filter_map(|number| pixel_of(size, side, stratum, number)) {
            let Some(now) = now(i) else { continue };
            let taps = taps(size, i, &pixels[i], previous, params);
            let known: Vec<_> = taps.iter().filter_map(|&(w, j)| Some((w, before(j)?))).collect();
            let total: f64 = known.iter().map(|(w, _)| w).sum();
            if total > 0.0 {
                let mean =
                    |of: &dyn Fn(&Before) -> f64| known.iter().map(|(w, v)| w * of(v)).sum::<f64>() / total;
                let before = mean(&|v| v.mean);
                let alpha = f64::from(alpha);
                let share = (1.0 / mean(&|v| v.frames)).max(alpha / (2.0 - alpha));
                let variance = (mean(&|v| v.second) - before.powi(2)).max(0.0);
                let variance = variance * (1.0 + share) / (1.0 - share).max(0.5);
                let terms = [now, before, (now - before).powi(2), variance];
                sum.iter_mut().zip(terms).for_each(|(sum, v)| *sum += v);
            }
        }
        sum
    };
    (0..across * down).map(one).collect()
}

/// Sums of the luminance of direct light, of channel 0 (diffuse) or 1 (specular), without the gradient pixels.
pub fn sums_direct(
    size: [u32; 2],
    pixels: &[Guided],
    light: &[Light],
    samples: &[GradientSample],
    previous: Option<&[History]>,
    channel: usize,
    params: &DenoiseParams,
) -> Vec<[f64; 4]> {
    let Some(previous) = previous else { return vec![[0.0; 4]; samples.len()] };
    let side = params.antilag.stratum.side();
    let params = &params.temporal;
    let now = |i: usize| {
        let (stratum, number) = stratum_of(size, side, i);
        let repeated = samples[stratum].number == number + 1;
        usable(&pixels[i], &light[i]).filter(|_| !repeated).map(|l| luminance(l[channel]))
    };
    let before = |j: usize| {
        let was = &previous[j];
        let [mean, second] = [0, 1].map(|k| was.moments[2 * channel + k]);
        (was.length > 0).then(|| Before { mean, second, frames: was.length.into() })
    };
    let alpha = [params.alpha_hf, params.alpha_spec][channel];
    sums(size, side, pixels, &now, &|j| &previous[j].pixel, &before, alpha, params)
}

/// Sums of the luma of indirect diffuse light.
pub fn sums_lf(
    size: [u32; 2],
    pixels: &[Guided],
    light: &[LowFrequency],
    previous: Option<&[LfHistory]>,
    params: &DenoiseParams,
) -> Vec<[f64; 4]> {
    let side = params.antilag.stratum.side();
    let params = &params.temporal;
    let Some(previous) = previous else { return vec![[0.0; 4]; strata(size, side).iter().product()] };
    let now = |i: usize| (pixels[i].material != 0 && is_light(&light[i])).then(|| light[i][3]);
    let before = |j: usize| {
        let was = &previous[j];
        let frames = was.length.into();
        (was.length > 0).then(|| Before { mean: was.light[3], second: was.second, frames })
    };
    sums(size, side, pixels, &now, &|j| &previous[j].pixel, &before, params.alpha_lf, params)
}

/// One level of the filter; `of_sums`: the third and fourth component are variances.
pub fn filter_gradients(
    size: [u32; 2],
    gradients: &[[f64; 4]],
    level: u32,
    of_sums: bool,
    params: &AntilagParams,
) -> Vec<[f64; 4]> {
    let [across, down] = strata(size, params.stratum.side()).map(|n| n as i64);
    let (taps, step): (&[f64], i64) = match params.filter {
        GradientFilter::Atrous => (&[0.5, 0.25], 1 << level),
        GradientFilter::Strided => (&[0.375, 0.25, 0.0625], 3i64.pow(level)),
    };
    let reach = taps.len() as i64 - 1;
    let weight = |x: i64, y: i64| taps[x.unsigned_abs() as usize] * taps[y.unsigned_abs() as usize];
    let offsets: Vec<[i64; 2]> =
        (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| [x, y])).collect();
    let all_squares: f64 = offsets.iter().map(|&[x, y]| weight(x, y).powi(2)).sum();
    let one = |stratum: usize| {
        let own = [stratum as i64 % across, stratum as i64 / across];
        let (mut sum, mut total, mut squares) = ([0.0; 4], 0.0, 0.0);
        for &[x, y] in &offsets {
            let at = [own[0] + x * step, own[1] + y * step];
            if (0..across).contains(&at[0]) && (0..down).contains(&at[1]) {
                let w = weight(x, y);
                let tap = gradients[(at[1] * across + at[0]) as usize];
                sum.iter_mut().zip(tap).for_each(|(sum, v)| *sum += w * v);
                total += w;
                squares += w * w;
            }
        }
        let mut mean = sum.map(|v| v / total);
        if of_sums {
            let border = squares / (total * total) / all_squares;
            let factor = (f64::from(params.filter.variance_factor(level)) * border).min(1.0);
            mean[2] *= factor;
            mean[3] *= factor;
        }
        mean
    };
    (0..gradients.len()).map(one).collect()
}

fn relative(change: f32, greatest: f32) -> f32 {
    if greatest > 0.0 { (change / greatest).clamp(0.0, 1.0) } else { 0.0 }
}

/// How much of the histories of diffuse and specular light is forgotten because of gradient pixels, in the precision of the kernel: lengths are rounded
/// down.
fn antilag(gradient: [f32; 4], params: &AntilagParams) -> [f32; 2] {
    let [a, b, c, d] = gradient;
    [(params.hf * relative(a, b)).min(1.0), (params.spec * relative(c, d)).min(1.0)]
}

/// The same because of sums.
fn antilag_of_sums(sums: [f32; 4], k: f32, params: &AntilagParams) -> f32 {
    let [now, before, of_frame, of_history] = sums;
    let variance = of_frame.max(of_history);
    let noise = params.gate_noise * variance.max(0.0).sqrt();
    let change = ((now - before).powi(2) - noise.powi(2)).max(0.0).sqrt();
    (k * relative(change, now.max(before))).min(1.0)
}

/// Length of a history that is left.
pub(super) fn kept_frames(frames: u32, lag: f32) -> u32 {
    let kept = 1.0 - lag;
    let second = kept * kept;
    let fourth = second * second;
    (frames as f32 * (fourth * fourth * second)) as u32
}

/// What the histories follow changes of the light by; all are images of the strata.
#[derive(Clone, Copy, Debug)]
pub struct Adaptive<'a> {
    /// Filtered gradients of gradient pixels, as the kernel reads them.
    pub gradients: &'a [[f32; 4]],
    /// Filtered sums of diffuse, specular and indirect diffuse light.
    pub sums: [&'a [[f32; 4]]; 3],
    /// Gradient pixels.
    pub samples: &'a [GradientSample],
    /// Knobs.
    pub params: &'a AntilagParams,
}

impl Adaptive<'_> {
    /// How much a pixel forgets of diffuse and specular light, and whether its light is the last frame's sample, taken again.
    pub(super) fn direct(&self, size: [u32; 2], i: usize) -> ([f32; 2], bool) {
        let (stratum, number) = stratum_of(size, self.params.stratum.side(), i);
        let of_pixels = antilag(self.gradients[stratum], self.params);
        let of_sums = |c: usize| {
            antilag_of_sums(self.sums[c][stratum], [self.params.hf, self.params.spec][c], self.params)
        };
        ([0, 1].map(|c| of_pixels[c].max(of_sums(c))), self.samples[stratum].number == number + 1)
    }

    /// The same of indirect diffuse light.
    pub(super) fn indirect(&self, size: [u32; 2], i: usize) -> (f32, bool) {
        let (stratum, number) = stratum_of(size, self.params.stratum.side(), i);
        let lag = antilag_of_sums(self.sums[2][stratum], self.params.lf, self.params);
        (lag, self.samples[stratum].number == number + 1)
    }
}
