//! `antilag.glsl`: strata, and how much of the histories is forgotten.

use crate::AntilagParams;

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
