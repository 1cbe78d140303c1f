//! A renderer that takes light samples again.

use super::{Random, count, grey};
use pt_denoise::oracle::{GradientSample, Light, strata};

/// A light sample of a light of brightness 1.
pub type Draw = fn(&mut Random) -> f32;

/// A wall under lights of a brightness by frame and pixel, of which one shadow ray in four finds one. Gradient pixels are those of a renderer: last frame's
/// sample under this frame's light.
pub struct Renderer<F: Fn(usize, usize) -> f32> {
    size: [u32; 2],
    brightness: F,
    random: Random,
    draw: Draw,
    last: Vec<f32>,
    repeated: Vec<bool>,
}

impl<F: Fn(usize, usize) -> f32> Renderer<F> {
    pub fn new(size: [u32; 2], brightness: F) -> Self {
        let repeated = vec![false; count(size)];
        Self {
            size,
            brightness,
            random: Random(77),
            draw: |random| random.sparse(4),
            last: Vec::new(),
            repeated,
        }
    }

    /// With light samples of another distribution.
    pub fn drawing(self, draw: Draw) -> Self {
        Self { draw, ..self }
    }

    /// Light of a frame, and its gradient pixels.
    pub fn frame(&mut self, frame: usize) -> (Vec<Light>, Vec<GradientSample>) {
        let mut unit: Vec<f32> = (0..count(self.size)).map(|_| (self.draw)(&mut self.random)).collect();
        let [across, down] = strata(self.size, 3);
        let mut samples = vec![GradientSample::default(); across * down];
        let mut repeated = vec![false; count(self.size)];
        for (s, sample) in samples.iter_mut().enumerate().filter(|_| frame > 0) {
            let pixel = |n: usize| {
                let at = [3 * (s % across) + n % 3, 3 * (s / across) + n / 3];
                (at[0] < self.size[0] as usize && at[1] < self.size[1] as usize)
                    .then(|| at[1] * self.size[0] as usize + at[0])
            };
            let before = |i: usize| self.last[i] * (self.brightness)(frame - 1, i);
            let first = (self.random.bits() % 9) as usize;
            let mut candidates = (first..first + 9).filter_map(|n| Some((n % 9, pixel(n % 9)?)));
            if let Some((n, i)) = candidates.find(|(_, i)| !self.repeated[*i]) {
                unit[i] = self.last[i];
                repeated[i] = true;
                *sample = GradientSample { number: n as u32 + 1, luminance: [before(i); 2] };
            }
        }
        let light = unit.iter().enumerate().map(|(i, v)| grey(v * (self.brightness)(frame, i))).collect();
        (self.last, self.repeated) = (unit, repeated);
        (light, samples)
    }
}
