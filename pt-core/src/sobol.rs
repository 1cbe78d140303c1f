//! Host twin of Sobol's sequence and of Owen's scrambling in shaders/glsl/sampler.glsl, where the methods are described.

use crate::rng::pcg;

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

/// Point `index` of the sequence, with its order and its values scrambled by the seeds. Points of different seeds are uncorrelated.
pub fn scrambled_sobol(index: u32, seeds: [u32; 4]) -> [u32; 4] {
    let x = sobol(owen_scramble(index, pcg(seeds[0] ^ seeds[3])));
    std::array::from_fn(|d| owen_scramble(x[d], seeds[d]))
}
