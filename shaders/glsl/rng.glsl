// Random numbers as a pure function of (pixel, frame, dimension, seed): PCG-4D of Jarzynski and Olano 2020,
// "Hash Functions for GPU Rendering". The host twin is pt_core::rng.

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

// Dimensions: every decision that draws numbers has one of its own.
const uint DIM_PIXEL = 0u;       // x, y: position in the pixel; z, w: position on the lens
const uint DIM_LIGHT = 1u;       // x: kind of light, y: light, z, w: point on it
const uint DIM_LIGHT_ALIAS = 2u; // x: alias table, second number; y: unused; z, w: unused

// Four numbers in [0, 1). `key`: x = flat pixel (x | y << 16), y = frame (channel rng_seed).
vec4 random4(uvec2 key, uint dimension, uint seed) {
    // 24 bits: exact in fp32 and never 1.
    return vec4(pcg4d(uvec4(key, dimension, seed)) >> 8u) * (1.0 / 16777216.0);
}
