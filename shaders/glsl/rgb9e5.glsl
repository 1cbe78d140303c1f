// Three numbers of 0 or more in 32 bits: mantissas of 9 bits and a common exponent of 5 bits (VK_FORMAT_E5B9G9R9_UFLOAT_PACK32). Numbers up to
// 65408; the largest of the three has 9 bits from 2^-16 on. Rounding to the nearest loses the small components of saturated colours, always
// the same way. Here random numbers decide whether a mantissa is rounded up or down, so that the mean over many is the number itself; what
// is above the range is lost. Host twin: pt_lights::oracle::round_rgb9e5.
#include "packed_light.glsl"

const int RGB9E5_LEAST_UNIT = -24, RGB9E5_MOST_UNIT = 7;
const uint RGB9E5_MANTISSA_MASK = 511u;

// `xi`: in [0, 1), one for each number.
uint pack_rgb9e5(vec3 v, vec3 xi) {
    v = min(mix(vec3(0.0), v, greaterThan(v, vec3(0.0))), vec3(65408.0));
    int unit = clamp(int(floatBitsToUint(max(v.x, max(v.y, v.z))) >> 23u) - 127 - 8, RGB9E5_LEAST_UNIT, RGB9E5_MOST_UNIT);
    vec3 mantissas = floor(scale_by_power(v, -unit) + xi);
    // The largest was rounded up to a power of two: half of it in units twice as large, exactly.
    bool carry = max(mantissas.x, max(mantissas.y, mantissas.z)) > float(RGB9E5_MANTISSA_MASK);
    if (carry && unit < RGB9E5_MOST_UNIT) mantissas = floor(scale_by_power(v, -++unit) + xi);
    uvec3 m = min(uvec3(mantissas), RGB9E5_MANTISSA_MASK);
    return m.x | m.y << 9u | m.z << 18u | uint(unit - RGB9E5_LEAST_UNIT) << 27u;
}

vec3 unpack_rgb9e5(uint word) {
    uvec3 m = uvec3(word, word >> 9u, word >> 18u) & RGB9E5_MANTISSA_MASK;
    return vec3(m) * power_of_two(int(word >> 27u) + RGB9E5_LEAST_UNIT);
}
