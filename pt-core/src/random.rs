//! Host twin of shaders/glsl/random.glsl: the random numbers of the frame's stages, from any of their sources.

use crate::blue_noise::mask_word;
use crate::rng::{coverage_seed, pcg, pcg4d};
use crate::sobol::{owen_scramble, scrambled_sobol};
use pt_shaders::constants::BLUE_NOISE_SIDE;
use pt_shaders::dimensions::DIM_COVERAGE;
pub use pt_shaders::records::RandomSource;

/// The mask has 12 bits.
const MASK_BITS: u32 = 0xfff0_0000;
const PLACE_KEY: u32 = 0x8000_0000;

/// The mask at the places of a dimension's four numbers.
fn mask_bits(pixel: [u32; 2], hash: [u32; 4]) -> [u32; 4] {
    const HALF: u32 = BLUE_NOISE_SIDE / 2;
    const QUARTER: u32 = BLUE_NOISE_SIDE / 4;
    let base = [0, 1].map(|axis| pixel[axis].wrapping_add(hash[axis]));
    std::array::from_fn(|i| {
        let (column, row) = (i as u32 % 2 * HALF, i as u32 / 2 * HALF);
        mask_word(
            base[0].wrapping_add(column + (hash[i] >> 24) % QUARTER),
            base[1].wrapping_add(row + (hash[i] >> 16) % QUARTER),
        )
    })
}

fn mask_hash(source: RandomSource, frame: u32, dimension: u32, seed: u32) -> [u32; 4] {
    let moving = if source == RandomSource::Sobol { 0 } else { frame };
    pcg4d([PLACE_KEY, moving, dimension, seed])
}

/// Four words of 32 random bits for a flat pixel, frame, dimension and seed.
pub fn random_bits(source: RandomSource, pixel: [u32; 2], frame: u32, dimension: u32, seed: u32) -> [u32; 4] {
    let white = pcg4d([pixel[0] | pixel[1] << 16, frame, dimension, seed]);
    if source == RandomSource::White {
        return white;
    }
    let hash = mask_hash(source, frame, dimension, seed);
    let mask = mask_bits(pixel, hash);
    let point = if source == RandomSource::Sobol { scrambled_sobol(frame, hash) } else { [0; 4] };
    std::array::from_fn(|i| (mask[i] ^ point[i]) & MASK_BITS | white[i] & !MASK_BITS)
}

/// Four numbers in [0, 1) for a flat pixel, frame, dimension and seed.
pub fn random_numbers(
    source: RandomSource,
    pixel: [u32; 2],
    frame: u32,
    dimension: u32,
    seed: u32,
) -> [f32; 4] {
    random_bits(source, pixel, frame, dimension, seed).map(unit)
}

fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 / 16_777_216.0
}

/// The random state of a ray that decides which BLEND surfaces stop it. `dimension`: that of the decision that created the ray.
pub fn random_coverage(
    source: RandomSource,
    pixel: [u32; 2],
    frame: u32,
    dimension: u32,
    seed: u32,
) -> [u32; 2] {
    if source == RandomSource::White {
        return [coverage_seed(pixel, frame, dimension, seed), 0];
    }
    let [hash, ..] = mask_hash(source, frame, DIM_COVERAGE + dimension, seed);
    [hash.wrapping_add(pcg(frame >> 20)), frame << 12 | (pixel[1] & 63) << 6 | pixel[0] & 63]
}

/// Number in [0, 1) for a ray and a triangle: the triangle is there when its coverage is above.
pub fn coverage_number(source: RandomSource, ray_coverage: [u32; 2], instance: u32, triangle: u32) -> f32 {
    let [seed, place] = ray_coverage;
    let hash = pcg(triangle.wrapping_add(pcg(instance.wrapping_add(seed))));
    if source == RandomSource::White {
        return unit(hash);
    }
    let mut bits = mask_word(place.wrapping_add(hash), (place >> 6).wrapping_add(hash >> 6));
    if source == RandomSource::Sobol {
        let order = owen_scramble(place >> 12, pcg(hash));
        bits ^= owen_scramble(order.reverse_bits(), pcg(hash.wrapping_add(1)));
    }
    unit(bits & MASK_BITS | pcg(hash ^ place) & !MASK_BITS)
}
