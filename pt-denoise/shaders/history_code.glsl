// What the histories hold (images.rs, HALF_HISTORIES): with denoise.histories=half codes of half floats, whose formats the host puts into the kernel, else the numbers
// themselves. Codes are roots, as between the levels of the a-trous filter: light up to 4e9 fits. Host twin: half_codes.rs of pt-core.
//
// An exponential mean stands still where its steps are less than half a unit of its last place. Random numbers therefore decide whether a root is rounded up or down, such
// that the mean of its squares is the number itself. The result has 11 bits: devices that truncate and devices that round store the same.
layout(constant_id = 25) const bool half_histories = false;
#include "rng.glsl"

// Smaller half floats have fewer bits: they are rounded to this one or to 0.
const float LEAST_HALF = 6.103515625e-5, GREATEST_HALF = 65504.0;

// Half floats of whose squares `v` is the expectation, for numbers `xi` in [0, 1); the nearest ones for 0.5.
vec4 rounded_roots(vec4 v, vec4 xi) {
    uvec4 bits = floatBitsToUint(sqrt(v)) & ~0x1fffu;
    vec4 below = uintBitsToFloat(bits), above = uintBitsToFloat(bits + 0x2000u);
    bvec4 least = lessThan(below, vec4(LEAST_HALF));
    below = mix(below, vec4(0.0), least);
    above = mix(above, vec4(LEAST_HALF), least);
    bvec4 up = lessThan(xi * (above * above - below * below), v - below * below);
    return min(mix(below, above, up), GREATEST_HALF);
}

// With the signs of the numbers.
vec4 rounded_signed_roots(vec4 v, vec4 xi) { return rounded_roots(abs(v), xi) * mix(vec4(1.0), vec4(-1.0), lessThan(v, vec4(0.0))); }

vec4 signed_squares(vec4 v) { return v * abs(v); }

// `pixel`: of the flat frame; `dimension`: of the image; `key`: frame and seed.
vec4 rounding_numbers(ivec2 pixel, uint dimension, uvec2 key) { return random4(uvec2(uint(pixel.x) | uint(pixel.y) << 16u, key.x), dimension, key.y); }

// Light of a code, with the variance or the hit distance in alpha; negative: missing.
vec4 decoded_light(vec4 code) {
    vec4 squares = signed_squares(code);
    return vec4(squares.rgb, squares.a * abs(squares.a));
}

vec4 light_code(vec4 light, vec4 xi) {
    vec4 roots = rounded_roots(vec4(light.rgb, sqrt(max(light.a, 0.0))), xi);
    return vec4(roots.rgb, light.a < 0.0 ? -1.0 : roots.a);
}

vec4 light_of_history(vec4 stored) { return half_histories ? decoded_light(stored) : stored; }

vec4 history_of_light(vec4 light, ivec2 pixel, uint dimension, uvec2 key) {
    return half_histories ? light_code(light, rounding_numbers(pixel, dimension, key)) : light;
}

// A variance in the alpha of history_of_light().
float history_of_variance(float variance) {
    return half_histories ? light_code(vec4(0.0, 0.0, 0.0, variance), vec4(0.5)).a : variance;
}

// Means and means of squares. Kept are means and standard deviations: a rounded mean of squares less the square of a rounded mean would be a variance of light that has no noise.
vec4 moments_of_history(vec4 stored) {
    if (!half_histories) return stored;
    vec4 v = signed_squares(stored);
    return vec4(v.x, v.x * v.x + v.y * v.y, v.z, v.z * v.z + v.w * v.w);
}

vec4 history_of_moments(vec4 moments, ivec2 pixel, uvec2 key) {
    if (!half_histories) return moments;
    vec2 deviation = sqrt(max(moments.yw - moments.xz * moments.xz, 0.0));
    return rounded_roots(vec4(moments.x, deviation.x, moments.z, deviation.y), rounding_numbers(pixel, DIM_HISTORIES + 2u, key));
}

// Luma in spherical harmonics.
vec4 luma_of_history(vec4 stored) { return half_histories ? signed_squares(stored) : stored; }

vec4 history_of_luma(vec4 luma, ivec2 pixel, uvec2 key) {
    return half_histories ? rounded_signed_roots(luma, rounding_numbers(pixel, DIM_HISTORIES + 3u, key)) : luma;
}

// Chroma, frames, and the mean of the squared luma; negative: there is no history. Kept is the variance of the luma, as with the moments. `luma`: its mean.
vec4 chroma_of_history(vec4 stored, float luma) {
    if (!half_histories) return stored;
    vec4 v = signed_squares(stored);
    return vec4(v.xy, stored.z, v.w < 0.0 ? -1.0 : luma * luma + v.w * v.w);
}

vec4 history_of_chroma(vec4 chroma, float luma, ivec2 pixel, uvec2 key) {
    if (!half_histories) return chroma;
    vec4 numbers = vec4(chroma.xy, 0.0, sqrt(max(chroma.w - luma * luma, 0.0)));
    vec4 roots = rounded_signed_roots(numbers, rounding_numbers(pixel, DIM_HISTORIES + 4u, key));
    return vec4(roots.xy, chroma.z, chroma.w < 0.0 ? -1.0 : roots.w);
}
