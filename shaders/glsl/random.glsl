// Random numbers of the frame's stages, from the source that the kernel is made for: a pure function of (pixel, frame, dimension, seed).
// Host twin: pt_core::random.
//
// RANDOM_WHITE: a hash (rng.glsl).
// RANDOM_BLUE_NOISE: neighbouring pixels differ as much as possible, so that a filter over the picture finds little error. Every
// number of every dimension and frame sees the mask from another place: frames are independent.
// RANDOM_SOBOL: over the frames a pixel goes through a scrambled Sobol sequence (sampler.glsl), the same for all pixels but for a
// digital shift (exclusive or) by the mask, which stays where it is. The shift keeps the stratification, exactly: 2^k frames
// that begin at a multiple of 2^k have one number in each of 2^k strata.
#include "frame.glsl"
#include "blue_noise.glsl"

// Tells the hashes of places in the mask from those of numbers.
const uint PLACE_KEY = 0x80000000u;

// Hash that says where the numbers of a dimension lie in the mask.
uvec4 mask_hash(uvec2 key, uint dimension) {
    uint moving = random_source == RANDOM_SOBOL ? 0u : key.y;
    return pcg4d(uvec4(PLACE_KEY, moving, dimension, frame.seed));
}

// The mask at the four numbers' places. They are at least a quarter of the tile apart: near each other, the numbers would depend on
// each other, and their pairs would leave parts of the square out.
uvec4 mask_bits_4(uvec2 pixel, uvec4 hash) {
    const uint half_side = BLUE_NOISE_SIDE / 2u, quarter = BLUE_NOISE_SIDE / 4u;
    uvec4 x = pixel.x + hash.x + uvec4(0u, half_side, 0u, half_side) + (hash >> 24u) % quarter;
    uvec4 y = pixel.y + hash.y + uvec4(0u, 0u, half_side, half_side) + (hash >> 16u) % quarter;
    return uvec4(mask_bits(uvec2(x.x, y.x)), mask_bits(uvec2(x.y, y.y)), mask_bits(uvec2(x.z, y.z)), mask_bits(uvec2(x.w, y.w)));
}

// Four words of 32 random bits. `key`: channel rng_seed; `dimension`: DIM_*.
uvec4 random_bits(uvec2 key, uint dimension) {
    uvec4 bits = random4_bits(key, dimension, frame.seed);
    if (random_source != RANDOM_WHITE) {
        uvec4 hash = mask_hash(key, dimension);
        uvec4 mask = mask_bits_4(uvec2(key.x, key.x >> 16u), hash);
        if (random_source == RANDOM_SOBOL) mask ^= scrambled_sobol(key.y, hash);
        bits = mask & MASK_BITS | bits & ~MASK_BITS;
    }
    return bits;
}

// Four numbers in [0, 1).
vec4 random_numbers(uvec2 key, uint dimension) { return unit_from_bits(random_bits(key, dimension)); }

// For the ray that follows from the decision with that dimension, as trace.glsl takes it.
uvec2 random_coverage(uvec2 key, uint dimension) {
    if (random_source == RANDOM_WHITE) return white_coverage(coverage_seed(key, dimension, frame.seed));
    uint hash = mask_hash(key, DIM_COVERAGE + dimension).x;
    // The record of a ray holds 20 bits of the frame.
    return masked_coverage(hash + pcg(key.y >> 20u), uvec2(key.x, key.x >> 16u), key.y);
}
