// Random numbers as a pure function of (pixel, frame, dimension, seed): PCG-4D of Jarzynski and Olano 2020, "Hash Functions for GPU
// Rendering". The host twin is pt_core::rng. Stages draw their numbers from random.glsl.
#include "dimensions.glsl"

uvec4 pcg4d(uvec4 v) {
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v ^= v >> 16u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

// Four words of 32 random bits. `key`: x = flat pixel (x | y << 16), y = frame (channel rng_seed).
uvec4 random4_bits(uvec2 key, uint dimension, uint seed) { return pcg4d(uvec4(key, dimension, seed)); }

// Every ray decides with a number of its own which BLEND surfaces are there for it. `dimension`: that of the decision which the ray
// follows from.
uint coverage_seed(uvec2 key, uint dimension, uint seed) { return random4_bits(key, DIM_COVERAGE + dimension, seed).x; }

// PCG of the same paper, for hashes that are nested.
uint pcg(uint v) {
    uint state = v * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

// Numbers in [0, 1). 24 bits: exact in fp32 and never 1.
vec4 unit_from_bits(uvec4 bits) { return vec4(bits >> 8u) * (1.0 / 16777216.0); }

vec4 random4(uvec2 key, uint dimension, uint seed) { return unit_from_bits(random4_bits(key, dimension, seed)); }
