//! Host twin of shaders/glsl/rng.glsl: random numbers as a pure function of (pixel, frame, dimension, seed).

use pt_shaders::dimensions::DIM_COVERAGE;

/// PCG-4D hash (Jarzynski and Olano 2020).
pub fn pcg4d(mut v: [u32; 4]) -> [u32; 4] {
    let mix = |v: &mut [u32; 4]| {
        v[0] = v[0].wrapping_add(v[1].wrapping_mul(v[3]));
        v[1] = v[1].wrapping_add(v[2].wrapping_mul(v[0]));
        v[2] = v[2].wrapping_add(v[0].wrapping_mul(v[1]));
        v[3] = v[3].wrapping_add(v[1].wrapping_mul(v[2]));
    };
    v = v.map(|x| x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    mix(&mut v);
    v = v.map(|x| x ^ (x >> 16));
    mix(&mut v);
    v
}

/// PCG hash of one word (Jarzynski and Olano 2020).
pub fn pcg(v: u32) -> u32 {
    let state = v.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// The seed with which a ray decides about BLEND surfaces. Arguments as of [`random4`].
pub fn coverage_seed(pixel: [u32; 2], frame: u32, dimension: u32, seed: u32) -> u32 {
    pcg4d([pixel[0] | pixel[1] << 16, frame, DIM_COVERAGE + dimension, seed])[0]
}

/// Four numbers in [0, 1) for a flat pixel, frame, dimension and seed.
pub fn random4(pixel: [u32; 2], frame: u32, dimension: u32, seed: u32) -> [f32; 4] {
    pcg4d([pixel[0] | pixel[1] << 16, frame, dimension, seed]).map(|x| (x >> 8) as f32 / 16_777_216.0)
}
