// Three numbers of 0 or more in 64 bits: mantissas of 18 bits and a common exponent of 10 bits. The error of each number is at most 2^-18
// of the largest of the three, and rounding is to the nearest: the mean over many is kept. The whole range of normal fp32 numbers has a code.
// What is negative or not a number becomes 0; what is infinite becomes the largest code. Host twin: pt_lights::oracle::pack_light.

const uint LIGHT_MANTISSA_BITS = 18u;
const uint LIGHT_MANTISSA_MASK = (1u << LIGHT_MANTISSA_BITS) - 1u;
// Unit of the mantissas for the smallest normal number, 2^-126.
const int LEAST_LIGHT_UNIT = -126 - int(LIGHT_MANTISSA_BITS) + 1;
// (2^18 - 1) 2^110: the largest number of 18 bits in fp32.
const float LARGEST_LIGHT = 3.40281069e38;

float power_of_two(int exponent) { return uintBitsToFloat(uint(exponent + 127) << 23); }

// v 2^exponent, in two steps: neither factor leaves the range of fp32.
vec3 scale_by_power(vec3 v, int exponent) {
    int half_way = exponent >> 1;
    precise vec3 scaled = v * power_of_two(half_way);
    scaled = scaled * power_of_two(exponent - half_way);
    return scaled;
}

uvec2 pack_light(vec3 v) {
    v = min(mix(vec3(0.0), v, greaterThan(v, vec3(0.0))), vec3(LARGEST_LIGHT));
    int exponent = int(floatBitsToUint(max(v.x, max(v.y, v.z))) >> 23u) - 127;
    if (exponent < -126) return uvec2(0u);
    int unit = exponent - int(LIGHT_MANTISSA_BITS) + 1;
    vec3 mantissas = roundEven(scale_by_power(v, -unit));
    // The largest was rounded up to a power of two.
    if (max(mantissas.x, max(mantissas.y, mantissas.z)) > float(LIGHT_MANTISSA_MASK)) {
        unit++;
        mantissas = roundEven(scale_by_power(v, -unit));
    }
    uvec3 m = uvec3(mantissas);
    return uvec2(m.x | m.y << LIGHT_MANTISSA_BITS, m.y >> (32u - LIGHT_MANTISSA_BITS) | m.z << 4u | uint(unit - LEAST_LIGHT_UNIT) << 22u);
}

vec3 unpack_light(uvec2 words) {
    uvec3 m = uvec3(words.x, words.x >> LIGHT_MANTISSA_BITS | words.y << (32u - LIGHT_MANTISSA_BITS), words.y >> 4u) & LIGHT_MANTISSA_MASK;
    return scale_by_power(vec3(m), int(words.y >> 22u) + LEAST_LIGHT_UNIT);
}
