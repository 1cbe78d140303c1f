//! The blue-noise mask that dithers 8-bit codes and moves random numbers from pixel to pixel: void and cluster (Ulichney 1993, "The
//! void-and-cluster method for dither array generation").

use crate::buffer::Buffer;
use crate::device::Device;
use crate::error::Result;
use pt_shaders::constants::BLUE_NOISE_SIDE;
use std::sync::OnceLock;

/// Side of the mask in texels.
pub const SIDE: usize = BLUE_NOISE_SIDE as usize;
const COUNT: usize = SIDE * SIDE;

/// The mask, row by row: every rank below 4096 once, so that the texels below any rank are spread evenly. Tiles seamlessly; the same
/// on every machine (integers only).
pub fn ranks() -> &'static [u16] {
    static RANKS: OnceLock<Vec<u16>> = OnceLock::new();
    RANKS.get_or_init(void_and_cluster)
}

/// The mask as numbers `(rank + 0.5) / 4096`: neighbours differ, and any patch has nearly the mean 1/2.
pub fn blue_noise() -> Vec<f32> {
    ranks().iter().map(|&rank| (f32::from(rank) + 0.5) / COUNT as f32).collect()
}

/// A texel of the mask as kernels see it (`SceneRecord::blue_noise`): the rank in the upper 12 bits of a word.
pub fn mask_word(x: u32, y: u32) -> u32 {
    u32::from(ranks()[(y % BLUE_NOISE_SIDE * BLUE_NOISE_SIDE + x % BLUE_NOISE_SIDE) as usize]) << 20
}

/// The words of the mask on the device.
///
/// # Errors
/// When the device refuses.
pub fn mask_buffer(device: &Device) -> Result<Buffer> {
    let words: Vec<u32> = (0..COUNT as u32).map(|i| mask_word(i, i / BLUE_NOISE_SIDE)).collect();
    Buffer::from_slice(device, "blue noise", &words)
}

/// Set texels and, for every texel, how crowded its surroundings are.
struct Pattern {
    set: Vec<bool>,
    crowd: Vec<u64>,
    /// Crowding by a set texel at an offset, on the torus, where it is not 0.
    kernel: Vec<(usize, usize, u64)>,
}

impl Pattern {
    fn new() -> Self {
        let distance = |a: usize| a.min(SIDE - a) as f64;
        let kernel = (0..COUNT)
            .map(|i| {
                let squared = distance(i % SIDE).powi(2) + distance(i / SIDE).powi(2);
                // Ulichney's standard deviation of 1.5 texels; rounded, so that sums are exact in any order.
                (i % SIDE, i / SIDE, ((-squared / (2.0 * 1.5 * 1.5)).exp() * 1e9).round() as u64)
            })
            .filter(|&(.., crowding)| crowding > 0)
            .collect();
        Self { set: vec![false; COUNT], crowd: vec![0; COUNT], kernel }
    }

    fn toggle(&mut self, at: usize) {
        let adding = !self.set[at];
        self.set[at] = adding;
        let (x, y) = (at % SIDE, at / SIDE);
        for &(dx, dy, crowding) in &self.kernel {
            let crowd = &mut self.crowd[(y + dy) % SIDE * SIDE + (x + dx) % SIDE];
            *crowd = if adding { *crowd + crowding } else { *crowd - crowding };
        }
    }

    /// The most crowded set texel.
    fn cluster(&self) -> usize {
        (0..COUNT).filter(|&i| self.set[i]).max_by_key(|&i| (self.crowd[i], i)).unwrap_or(0)
    }

    /// The least crowded free texel.
    fn void(&self) -> usize {
        (0..COUNT).filter(|&i| !self.set[i]).min_by_key(|&i| (self.crowd[i], i)).unwrap_or(0)
    }
}

fn void_and_cluster() -> Vec<u16> {
    let mut start = Pattern::new();
    // A tenth of the texels, scattered; then evened out: the tightest cluster moves to the largest void until that is where
    // it came from.
    let mut word = 1u32;
    let mut scattered = 0;
    while scattered < COUNT / 10 {
        word = word.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let at = (word >> 20) as usize % COUNT;
        if !start.set[at] {
            start.toggle(at);
            scattered += 1;
        }
    }
    loop {
        let cluster = start.cluster();
        start.toggle(cluster);
        let void = start.void();
        start.toggle(void);
        if void == cluster {
            break;
        }
    }
    let mut ranks = vec![0; COUNT];
    let set: Vec<usize> = (0..COUNT).filter(|&i| start.set[i]).collect();
    let mut pattern = Pattern::new();
    set.iter().for_each(|&at| pattern.toggle(at));
    for rank in (0..set.len()).rev() {
        let at = pattern.cluster();
        pattern.toggle(at);
        ranks[at] = rank as u16;
    }
    for rank in set.len()..COUNT {
        let at = start.void();
        start.toggle(at);
        ranks[at] = rank as u16;
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rank_once() {
        let mut sorted = ranks().to_vec();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..COUNT as u16));
    }

    /// Power at low frequencies, relative to white noise: what makes it blue. Threshold a half of the radius below which
    /// white noise would have 1.
    #[test]
    fn low_frequencies_are_missing() {
        let tile = blue_noise();
        let power = |fx: usize, fy: usize| {
            let (mut re, mut im) = (0.0f64, 0.0f64);
            for (i, value) in tile.iter().enumerate() {
                let phase =
                    std::f64::consts::TAU * ((i % SIDE * fx + i / SIDE * fy) % SIDE) as f64 / SIDE as f64;
                re += (f64::from(*value) - 0.5) * phase.cos();
                im += (f64::from(*value) - 0.5) * phase.sin();
            }
            (re * re + im * im) / (COUNT as f64 / 12.0)
        };
        let mean = |frequencies: &[(usize, usize)]| {
            frequencies.iter().map(|&(x, y)| power(x, y)).sum::<f64>() / frequencies.len() as f64
        };
        let low: Vec<_> = (0..8).flat_map(|y| (0..8).map(move |x| (x, y))).filter(|&f| f != (0, 0)).collect();
        let high: Vec<_> = (24..32).flat_map(|y| (24..32).map(move |x| (x, y))).collect();
        assert!(mean(&low) < 0.1, "{}", mean(&low));
        assert!(mean(&high) > 0.8, "{}", mean(&high));
    }
}
