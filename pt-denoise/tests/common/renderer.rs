//! A renderer that takes light samples again.

use super::{Random, count, grey};
use pt_denoise::AntilagParams;
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
    /// Pixels along a side of a stratum.
    side: usize,
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
            side: AntilagParams::default().stratum.side() as usize,
        }
    }

    /// With light samples of another distribution.
    pub fn drawing(self, draw: Draw) -> Self {
        Self { draw, ..self }
    }

    /// With other strata.
    pub fn with_strata(self, side: u32) -> Self {
        Self { side: side as usize, ..self }
    }

    /// Light of a frame, and its gradient pixels.
    pub fn frame(&mut self, frame: usize) -> (Vec<Light>, Vec<GradientSample>) {
        let mut unit: Vec<f32> = (0..count(self.size)).map(|_| (self.draw)(&mut self.random)).collect();
        let (side, count_of_stratum) = (self.side, self.side * self.side);
        let [across, down] = strata(self.size, side as u32);
        let mut samples = vec![GradientSample::default(); across * down];
        let mut repeated = vec![false; count(self.size)];
        for (s, sample) in samples.iter_mut().enumerate().filter(|_| frame > 0) {
            let pixel = |n: usize| {
                let at = [side * (s % across) + n % side, side * (s / across) + n / side];
                (at[0] < self.size[0] as usize && at[1] < self.size[1] as usize)
                    .then(|| at[1] * self.size[0] as usize + at[0])
            };
            let before = |i: usize| self.last[i] * (self.brightness)(frame - 1, i);
            let first = (self.random.bits() % count_of_stratum as u64) as usize;
            let numbers = (first..first + count_of_stratum).map(|n| n % count_of_stratum);
            let mut candidates = numbers.filter_map(|n| Some((n, pixel(n)?)));
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
