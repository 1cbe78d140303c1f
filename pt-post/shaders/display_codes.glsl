// Linear display values to the codes of an output.
#include "post_records.glsl"
#include "pq.glsl"

// IEC 61966-2-1.
vec3 srgb_encode(vec3 x) {
    return mix(1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, 12.92 * x, lessThanEqual(x, vec3(0.0031308)));
}

// ITU-R BT.2087: linear Rec. 709 to Rec. 2020. Columns.
const mat3 REC2020_FROM_REC709 = mat3(0.6274, 0.0691, 0.0164, 0.3293, 0.9195, 0.0880, 0.0433, 0.0114, 0.8956);
const mat3 REC709_FROM_REC2020 = mat3(1.660496, -0.124547, -0.018154, -0.587656, 1.132895, -0.100597, -0.072840,
                                      -0.008348, 1.118751);
// Linear values of scRGB (IEC 61966-2-2) per 10000 cd/m2.
const float SCRGB_PER_PQ = 10000.0 / 80.0;

// Triangular noise of -1..1 least significant bits, from a uniform number of 0..1.
float triangular(float u) {
    float t = 2.0 * u - 1.0;
    return sign(t) * (1.0 - sqrt(1.0 - abs(t)));
}

// 8-bit code as a fraction, with noise from a uniform number of 0..1. Beside black and white triangular noise would be cut
// off and the mean wrong: half a step of uniform noise is right there, and black and white stay.
float quantize(float code, float u) {
    float steps = clamp(code, 0.0, 1.0) * 255.0;
    float noise = steps < 1.0 || steps > 254.0 ? u - 0.5 : triangular(u);
    // Rounded here: drivers may round to either neighbour when they store.
    return clamp(floor(steps + noise + 0.5), 0.0, 255.0) / 255.0;
}

#ifdef DITHERED
layout(set = 2, binding = 8, scalar) readonly buffer blue_noise { float noise_tile[NOISE_SIDE * NOISE_SIDE]; };

// Each channel looks at another place of the tile, so that their errors differ.
float tile_noise(ivec2 p, ivec2 shift) {
    uvec2 at = uvec2(p + shift) % NOISE_SIDE;
    return noise_tile[at.y * NOISE_SIDE + at.x];
}

vec3 to_8_bits(vec3 code, ivec2 p, bool dither) {
    vec3 noise = vec3(tile_noise(p, ivec2(0)), tile_noise(p, ivec2(23, 41)), tile_noise(p, ivec2(47, 11)));
    if (!dither) noise = vec3(0.5);
    return vec3(quantize(code.r, noise.r), quantize(code.g, noise.g), quantize(code.b, noise.b));
}
#endif
