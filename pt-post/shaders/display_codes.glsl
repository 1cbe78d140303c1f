// Linear display values to the codes of an output.
#include "post_records.glsl"
#include "constants.glsl"
#include "pq.glsl"

// IEC 61966-2-1. Written so that 1 stays 1: less would be cut off to the next half float, and dithered white would not be white.
vec3 srgb_encode(vec3 x) {
    vec3 p = pow(x, vec3(1.0 / 2.4));
    return mix(p + 0.055 * (p - 1.0), 12.92 * x, lessThanEqual(x, vec3(0.0031308)));
}

// ITU-R BT.2087: linear Rec. 709 to Rec. 2020. Columns.
const mat3 REC2020_FROM_REC709 = mat3(0.6274, 0.0691, 0.0164, 0.3293, 0.9195, 0.0880, 0.0433, 0.0114, 0.8956);
const mat3 REC709_FROM_REC2020 = mat3(1.660496, -0.124547, -0.018154, -0.587656, 1.132895, -0.100597, -0.072840,
                                      -0.008348, 1.118751);
// Linear values of scRGB (IEC 61966-2-2) per 10000 cd/m2.
const float SCRGB_PER_PQ = 10000.0 / 80.0;

// 8-bit codes as fractions, with triangular noise of -1..1 steps. Beside black and white it would be cut off and the mean
// wrong: half a step of uniform noise is right there, and black and white stay.
vec3 quantize(vec3 code, vec3 triangular) {
    vec3 steps = clamp(code, 0.0, 1.0) * 255.0;
    // The distribution function undone: u - 1/2 of the uniform number u that the triangular one was made from.
    vec3 uniform_noise = triangular * (1.0 - 0.5 * abs(triangular));
    vec3 noise = mix(triangular, uniform_noise, greaterThan(abs(steps - 127.5), vec3(126.5)));
    // Rounded here: drivers may round to either neighbour when they store.
    return clamp(floor(steps + noise + 0.5), 0.0, 255.0) * (1.0 / 255.0);
}

#ifdef DITHERED
// Triangular noise for red, green and blue as half floats; the last 16 bits are 0.
layout(set = 2, binding = 8, scalar) readonly buffer blue_noise { uvec2 noise_tile[BLUE_NOISE_SIDE * BLUE_NOISE_SIDE]; };

vec3 to_8_bits(vec3 code, ivec2 p, bool dither) {
    uvec2 at = uvec2(p) % BLUE_NOISE_SIDE;
    uvec2 halves = noise_tile[at.y * BLUE_NOISE_SIDE + at.x];
    vec3 noise = vec3(unpackHalf2x16(halves.x), unpackHalf2x16(halves.y).x);
    return quantize(code, dither ? noise : vec3(0.0));
}
#endif
