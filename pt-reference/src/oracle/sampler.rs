//! Numbers for Monte Carlo integration; the bits of sampler.glsl, where the methods are described.

use pt_core::rng::{pcg, pcg4d};
use pt_core::sobol::scrambled_sobol;
pub use pt_shaders::records::SamplerKind;

/// Position in a sequence.
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    kind: SamplerKind,
    index: u32,
    scramble: u32,
    /// Of the next call.
    pub dimension: u32,
}

fn spread_bits(x: u32) -> u32 {
    (0..16).fold(0, |spread, bit| spread | (x >> bit & 1) << (2 * bit))
}

impl Sampler {
    /// `log2_spp`: of the samples of a pixel, for the blue noise.
    pub fn new(kind: SamplerKind, pixel: [u32; 2], index: u32, seed: u32, log2_spp: u32) -> Self {
        let hash = |a: u32, b: u32, c: u32| pcg(a.wrapping_add(pcg(b.wrapping_add(pcg(c)))));
        if kind != SamplerKind::BlueNoise {
            return Self { kind, index, scramble: hash(pixel[0], pixel[1], seed), dimension: 0 };
        }
        let side_bits = 16 - log2_spp.div_ceil(2);
        let tile = pixel.map(|p| p >> side_bits);
        let [x, y] = pixel.map(|p| spread_bits(p & ((1 << side_bits) - 1)));
        let place = (u64::from(x | y << 1) << log2_spp) as u32;
        Self {
            kind,
            index: place | index & ((1 << log2_spp) - 1),
            scramble: hash(tile[0], tile[1], seed.wrapping_add(pcg(index >> log2_spp))),
            dimension: 0,
        }
    }

    /// 4 x 32 bits.
    pub fn bits(&mut self) -> [u32; 4] {
        let index = if self.kind == SamplerKind::Pcg { self.index } else { 0 };
        let seeds = pcg4d([self.scramble, self.dimension, self.kind as u32, index]);
        self.dimension += 1;
        if self.kind == SamplerKind::Pcg {
            return seeds;
        }
        scrambled_sobol(self.index, seeds)
    }

    /// Four numbers in [0, 1).
    pub fn next_4d(&mut self) -> [f64; 4] {
        self.bits().map(|word| f64::from(word >> 8) / 16_777_216.0)
    }
}
