// Numbers of the blue-noise mask (pt_core::blue_noise), and what decides by them whether a ray stops at a BLEND surface. Host twin:
// pt_core::random.
#include "scene.glsl"
#include "sampler.glsl"

// Where the numbers come from (RANDOM_*); kernels are made for one source.
layout(constant_id = 1) const uint random_source = RANDOM_WHITE;

// The mask has 12 bits; those below are white noise, so that a number may have any value.
const uint MASK_BITS = 0xfff00000u;

// Bits of the mask at a texel. The tile repeats.
uint mask_bits(uvec2 texel) {
    uvec2 at = texel & (BLUE_NOISE_SIDE - 1u);
    return UintTable(scene.blue_noise).at[at.y * BLUE_NOISE_SIDE + at.x];
}

// What a ray knows to decide about BLEND surfaces. x: a hash. y: 0 for white noise, else bits 0-11: pixel (6 bits each), 12-31: frame.
uvec2 white_coverage(uint seed) { return uvec2(seed, 0u); }

uvec2 masked_coverage(uint hash, uvec2 pixel, uint frame_index) {
    return uvec2(hash, frame_index << 12u | (pixel.y & 63u) << 6u | pixel.x & 63u);
}

// Number in [0, 1) for a ray and a triangle: the triangle is there when its coverage is above. Every triangle has a place of its own in
// the mask and an order of its own over the frames, so that surfaces behind each other are independent.
float coverage_number(uvec2 ray_coverage, uint instance, uint triangle) {
    uint bits = pcg(triangle + pcg(instance + ray_coverage.x));
    if (random_source != RANDOM_WHITE) {
        uint hash = bits;
        bits = mask_bits(uvec2(ray_coverage.y, ray_coverage.y >> 6u) + uvec2(hash, hash >> 6u));
        if (random_source == RANDOM_SOBOL) {
            // The first dimension of the sequence alone: van der Corput's.
            uint order = owen_scramble(ray_coverage.y >> 12u, pcg(hash));
            bits ^= owen_scramble(bitfieldReverse(order), pcg(hash + 1u));
        }
        bits = bits & MASK_BITS | pcg(hash ^ ray_coverage.y) & ~MASK_BITS;
    }
    return float(bits >> 8u) * (1.0 / 16777216.0);
}
