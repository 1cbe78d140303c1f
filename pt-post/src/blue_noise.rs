//! The blue-noise tile that dithers 8-bit codes: void and cluster (Ulichney 1993, "The void-and-cluster method for dither array
//! generation").

use crate::records::NOISE_SIDE;
use half::f16;
use pt_core::{Buffer, Device, Result};
use std::sync::OnceLock;

const SIDE: usize = NOISE_SIDE as usize;
const COUNT: usize = SIDE * SIDE;

/// The tile: every value of `(i + 0.5) / 4096` once, so that neighbours differ and any patch has nearly the mean 1/2. Tiles
/// seamlessly; the same on every machine (integers only).
pub fn blue_noise() -> &'static [f32] {
    static TILE: OnceLock<Vec<f32>> = OnceLock::new();
    TILE.get_or_init(|| ranks().iter().map(|&rank| (rank as f32 + 0.5) / COUNT as f32).collect())
}

/// Where in the tile red, green and blue look, so that their errors differ.
const SHIFTS: [[usize; 2]; 3] = [[0, 0], [23, 41], [47, 11]];

/// Triangular noise of -1..1 for three channels, four half floats a texel.
pub(crate) fn noise_buffer(device: &Device) -> Result<Buffer> {
    let tile = blue_noise();
    let triangular = |x: usize, y: usize| {
        let t = 2.0 * tile[y % SIDE * SIDE + x % SIDE] - 1.0;
        f16::from_f32(t.signum() * (1.0 - (1.0 - t.abs()).sqrt())).to_bits()
    };
    let texels: Vec<[u16; 4]> = (0..COUNT)
        .map(|i| {
            let [r, g, b] = SHIFTS.map(|[x, y]| triangular(i % SIDE + x, i / SIDE + y));
            [r, g, b, 0]
        })
        .collect();
    Buffer::from_slice(device, "blue_noise", &texels)
}

/// Set texels and, for every texel, how crowded its surroundings are.
struct Pattern {
    set: Vec<bool>,
    crowd: Vec<u64>,
    /// Crowding by a set texel at an offset, on the torus.
    kernel: Vec<u64>,
}

impl Pattern {
    fn new() -> Self {
        let distance = |a: usize| a.min(SIDE - a) as f64;
        let kernel = (0..COUNT)
            .map(|i| {
                let squared = distance(i % SIDE).powi(2) + distance(i / SIDE).powi(2);
                // Ulichney's standard deviation of 1.5 texels; rounded, so that sums are exact in any order.
                ((-squared / (2.0 * 1.5 * 1.5)).exp() * 1e9).round() as u64
            })
            .collect();
        Self { set: vec![false; COUNT], crowd: vec![0; COUNT], kernel }
    }

    fn toggle(&mut self, at: usize) {
        let adding = !self.set[at];
        self.set[at] = adding;
        let (x, y) = (at % SIDE, at / SIDE);
        for (i, crowd) in self.crowd.iter_mut().enumerate() {
            let dx = (i % SIDE + SIDE - x) % SIDE;
            let dy = (i / SIDE + SIDE - y) % SIDE;
            let k = self.kernel[dy * SIDE + dx];
            *crowd = if adding { *crowd + k } else { *crowd - k };
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

fn ranks() -> Vec<u32> {
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
        ranks[at] = rank as u32;
    }
    for rank in set.len()..COUNT {
        let at = start.void();
        start.toggle(at);
        ranks[at] = rank as u32;
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_once() {
        let mut sorted = blue_noise().to_vec();
        sorted.sort_by(f32::total_cmp);
        for (i, value) in sorted.iter().enumerate() {
            assert_eq!(*value, (i as f32 + 0.5) / COUNT as f32);
        }
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
