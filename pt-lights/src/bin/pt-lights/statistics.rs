//! Means, intervals and errors of pictures.

use super::truth::Truth;
use glam::DVec3;
use pt_core::split::{flat_to_split, split_size};
use pt_image::metrics::RELMSE_EPSILON;

/// Pixels on a side of a block.
pub const BLOCK: u32 = 16;
/// Standard errors that the mean of a block may be off.
pub const BLOCK_BAR: f64 = 3.0;

/// Mean over independent runs with its 95 % interval (Student's t).
#[derive(Clone, Copy, Debug, Default)]
pub struct Interval {
    pub mean: f64,
    pub low: f64,
    pub high: f64,
}

impl Interval {
    /// Of a value for each run.
    pub fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        let reach = student(values.len()) * (variance / n).sqrt();
        Self { mean, low: mean - reach, high: mean + reach }
    }

    /// Of values that are `factor` times these.
    pub fn scaled(self, factor: f64) -> Self {
        Self { mean: self.mean * factor, low: self.low * factor, high: self.high * factor }
    }
}

/// 97.5 % quantile of Student's t for n - 1 degrees of freedom, n from 2 on: Cornish-Fisher expansion (Abramowitz and Stegun 26.7.5), exact
/// values for the first few.
fn student(n: usize) -> f64 {
    const FIRST: [f64; 10] = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228];
    let degrees = n.saturating_sub(1).max(1);
    if let Some(exact) = FIRST.get(degrees - 1) {
        return *exact;
    }
    let (z, v) = (1.959_964f64, degrees as f64);
    z + (z.powi(3) + z) / (4.0 * v) + (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * v * v)
}

/// Mean of (x - t)^2 / (t^2 + epsilon) over the pixels that count, less what the variance of t adds. The pixels are `factor` x `picture`.
pub fn relmse(picture: &[DVec3], factor: f64, truth: &Truth, mask: &[bool]) -> f64 {
    let term = |i: usize| {
        let (x, t) = (picture[i] * factor, truth.mean[i]);
        (((x - t) * (x - t) - truth.variance[i]) / (t * t + RELMSE_EPSILON)).element_sum() / 3.0
    };
    mean((0..picture.len()).filter(|i| mask[*i]).map(term))
}

/// Light of `factor` x `picture` over that of the reference, in the pixels that count.
pub fn ratio(picture: &[DVec3], factor: f64, truth: &Truth, mask: &[bool]) -> f64 {
    let sum = |of: &[DVec3]| (0..of.len()).filter(|i| mask[*i]).map(|i| of[i].element_sum()).sum::<f64>();
    let truth = sum(&truth.mean);
    if truth > 0.0 { factor * sum(picture) / truth } else { 1.0 }
}

pub fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0u64), |(sum, count), v| (sum + v, count + 1));
    sum / count.max(1) as f64
}

/// Index in the split frame of a pixel of the flat frame.
pub fn texel_of(pixel: usize, width: u32) -> usize {
    let pixel = pixel as u32;
    let [x, y] = flat_to_split([pixel % width, pixel / width], pt_shaders::records::field_width(width));
    (y * split_size([width, 1])[0] + x) as usize
}

/// Of the 8 neighbours of a pixel, how many have the same choice; mean over the pixels that have one and count.
pub fn neighbours_alike(choices: &[[u32; 2]], [width, height]: [u32; 2], mask: &[bool]) -> f64 {
    let at = |x: u32, y: u32| choices[texel_of((y * width + x) as usize, width)];
    let inner = (1..height.saturating_sub(1)).flat_map(|y| (1..width.saturating_sub(1)).map(move |x| (x, y)));
    mean(inner.filter(|&(x, y)| mask[(y * width + x) as usize] && at(x, y)[0] != u32::MAX).map(|(x, y)| {
        let own = at(x, y);
        let near = (0..9u32).filter(|i| *i != 4).map(|i| at(x + i % 3 - 1, y + i / 3 - 1));
        near.filter(|other| *other == own).count() as f64
    }))
}

/// Means of blocks of pixels, of independent runs: first and second moments.
#[derive(Default)]
pub struct Blocks {
    sums: Vec<[DVec3; 2]>,
    runs: u32,
}

/// How far the means of blocks are from the reference.
#[derive(Clone, Copy, Debug)]
pub struct BlockTest {
    /// Blocks times channels.
    pub count: usize,
    /// Share of them within [`BLOCK_BAR`] standard errors.
    pub within: f64,
    /// Largest distance in standard errors.
    pub largest: f64,
}

/// Sum over the pixels of each block that count, and their number.
fn block_sums(values: &[DVec3], width: u32, mask: &[bool]) -> Vec<(DVec3, u32)> {
    let columns = width.div_ceil(BLOCK);
    let rows = (values.len() as u32 / width).div_ceil(BLOCK);
    let mut blocks = vec![(DVec3::ZERO, 0); (columns * rows) as usize];
    for (pixel, value) in values.iter().enumerate().filter(|(pixel, _)| mask[*pixel]) {
        let (x, y) = (pixel as u32 % width, pixel as u32 / width);
        let block = &mut blocks[(y / BLOCK * columns + x / BLOCK) as usize];
        *block = (block.0 + *value, block.1 + 1);
    }
    blocks
}

impl Blocks {
    /// Adds the picture of a run.
    pub fn add(&mut self, picture: &[DVec3], width: u32, mask: &[bool]) {
        let sums = block_sums(picture, width, mask);
        self.sums.resize(sums.len(), [DVec3::ZERO; 2]);
        for (moments, (sum, _)) in self.sums.iter_mut().zip(sums) {
            *moments = [moments[0] + sum, moments[1] + sum * sum];
        }
        self.runs += 1;
    }

    /// Compares the means with the reference: the standard error is that of the mean of the runs and that of the reference together. Where
    /// neither varies, the means must be equal to a hundred-thousandth.
    pub fn test(&self, truth: &Truth, width: u32, mask: &[bool]) -> BlockTest {
        let n = f64::from(self.runs);
        let truths = block_sums(&truth.mean, width, mask);
        let variances = block_sums(&truth.variance, width, mask);
        let mut distances = Vec::new();
        for (([sum, squares], (expected, count)), (uncertain, _)) in
            self.sums.iter().zip(truths).zip(variances)
        {
            if count == 0 {
                continue;
            }
            let found = *sum / n;
            let spread = (*squares / n - found * found).max(DVec3::ZERO) / (n - 1.0).max(1.0);
            for channel in 0..3 {
                let least = 1e-5 * expected[channel].abs();
                let error = (spread[channel] + uncertain[channel]).sqrt().max(least / BLOCK_BAR);
                let distance = (found[channel] - expected[channel]).abs();
                distances.push(if distance > 0.0 { distance / error.max(f64::MIN_POSITIVE) } else { 0.0 });
            }
        }
        let within = distances.iter().filter(|d| **d <= BLOCK_BAR).count() as f64;
        BlockTest {
            count: distances.len(),
            within: within / distances.len().max(1) as f64,
            largest: distances.into_iter().fold(0.0, f64::max),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_students() {
        assert!((student(7) - 2.447).abs() < 1e-3 && (student(12) - 2.201).abs() < 3e-3);
        assert!((student(31) - 2.042).abs() < 1e-3);
        let i = Interval::of(&[1.0, 2.0, 3.0]);
        assert!((i.mean - 2.0).abs() < 1e-12 && (i.high - 2.0 - 4.303 / 3f64.sqrt()).abs() < 1e-9);
        assert!((i.scaled(2.0).low - 2.0 * i.low).abs() < 1e-12);
    }

    #[test]
    fn duplicates_are_counted_among_neighbours() {
        let size = [4, 3];
        let mut choices = vec![[u32::MAX, 0]; (split_size(size)[0] * size[1]) as usize];
        for (pixel, choice) in [(5, [7, 1]), (6, [7, 1]), (9, [7, 2]), (1, [7, 1])] {
            choices[texel_of(pixel, size[0])] = choice;
        }
        // Pixel 5 has 6 and 1 as its like, pixel 6 has 5 and 1.
        assert_eq!(neighbours_alike(&choices, size, &[true; 12]), 2.0);
    }

    /// Four blocks, the last one narrow. Runs scatter round the reference, but for one block and channel that is off by 8 standard errors.
    #[test]
    fn blocks_tell_a_bias_from_noise() {
        let (width, height) = (20u32, 20u32);
        let pixels = (width * height) as usize;
        let truth = Truth {
            mean: vec![DVec3::splat(2.0); pixels],
            variance: vec![DVec3::ZERO; pixels],
            relative_error: 0.0,
        };
        let mask: Vec<bool> = (0..pixels).map(|i| i != 0).collect();
        let test = |bias: f64| {
            let mut blocks = Blocks::default();
            for run in 0..64u32 {
                let noise = if run % 2 == 0 { 0.1 } else { -0.1 };
                let mut picture = vec![DVec3::splat(2.0 + noise); pixels];
                (0..pixels).filter(|i| i % 20 >= 16 && i / 20 >= 16).for_each(|i| picture[i].y += bias);
                blocks.add(&picture, width, &mask);
            }
            blocks.test(&truth, width, &mask)
        };
        let fair = test(0.0);
        assert_eq!((fair.count, fair.within), (12, 1.0));
        assert!(fair.largest < 1e-6, "{fair:?}");
        let biased = test(0.1);
        assert!(
            (biased.within - 11.0 / 12.0).abs() < 1e-12 && (biased.largest - 63f64.sqrt()).abs() < 1e-6,
            "{biased:?}"
        );
    }
}
