//! Numbers for Monte Carlo integration; the bits of sampler.glsl, where the methods are described.

use pt_core::rng::{pcg, pcg4d};
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

/// Direction numbers of dimensions 2 to 4, from the primitive polynomials and initial values of Joe and Kuo 2008.
pub fn direction_numbers() -> [[u32; 3]; 32] {
    // Degree, coefficients, initial values.
    let dimensions: [(usize, u32, &[u32]); 3] = [(1, 0, &[1]), (2, 1, &[1, 3]), (3, 1, &[1, 3, 1])];
    let mut table = [[0; 3]; 32];
    for (d, (degree, coefficients, initial)) in dimensions.into_iter().enumerate() {
        for i in 0..32 {
            table[i][d] = if i < degree {
                initial[i] << (31 - i)
            } else {
                let mut v = table[i - degree][d] ^ table[i - degree][d] >> degree;
                for k in 1..degree {
                    if coefficients >> (degree - 1 - k) & 1 == 1 {
                        v ^= table[i - k][d];
                    }
                }
                v
            };
        }
    }
    table
}

/// Four dimensions of Sobol's sequence.
pub fn sobol(index: u32) -> [u32; 4] {
    let table = direction_numbers();
    let mut x = [index.reverse_bits(), 0, 0, 0];
    for (bit, directions) in table.iter().enumerate().filter(|(bit, _)| index >> bit & 1 == 1) {
        debug_assert!(bit < 32);
        for d in 0..3 {
            x[d + 1] ^= directions[d];
        }
    }
    x
}

fn laine_karras(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul(seed >> 16 | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x
}

/// Owen's scrambling: every bit is flipped as a function of those above it.
pub fn owen_scramble(x: u32, seed: u32) -> u32 {
    laine_karras(x.reverse_bits(), seed).reverse_bits()
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
        let x = sobol(owen_scramble(self.index, pcg(seeds[0] ^ seeds[3])));
        std::array::from_fn(|d| owen_scramble(x[d], seeds[d]))
    }

    /// Four numbers in [0, 1).
    pub fn next_4d(&mut self) -> [f64; 4] {
        self.bits().map(|word| f64::from(word >> 8) / 16_777_216.0)
    }
}
