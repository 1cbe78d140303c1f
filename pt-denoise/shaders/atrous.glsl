// What the two schedules of the a-trous filter share: weights of a pair of pixels, and their sums. Included by atrous_*.comp, which define RADIUS: taps to each side; and
// ROOTS: the target holds roots of light in half floats (levels_hf, and history_hf with denoise.histories=half), else light (ping_hf, history_hf).
// The kernel declares `push` as AtrousPush.
//
// The geometric weights are normalised. What the luminance weight takes from a tap stays with the centre instead of going to the other taps:
// the matrix of those weights is symmetric, so bright noise loses no energy by being rejected.
//
// Every factor of a weight is a power of two, so that factors are sums of exponents. The larger range or variance of a pair is the smaller of two inverses, which each pixel
// computes once.
#include "channels.glsl"
#include "checkerboard.glsl"
#include "denoise_images.glsl"
#include "edge_stopping.glsl"
#include "history_code.glsl"
#include "packed_guide.glsl"

layout(set = 2, binding = 0) uniform sampler2D source_hf;
layout(set = 2, binding = 1) uniform sampler2D source_spec;
#if ROOTS
layout(set = 2, binding = 2, rgba16f) uniform writeonly image2D target_hf;
layout(set = 2, binding = 3, rgba16f) uniform writeonly image2D target_spec;
#else
layout(set = 2, binding = 2, rgba32f) uniform writeonly image2D target_hf;
layout(set = 2, binding = 3, rgba32f) uniform writeonly image2D target_spec;
#endif

#if RADIUS == 2
// B3 spline.
const float KERNEL[3] = float[3](0.375, 0.25, 0.0625);
const float LOG2_KERNEL[3] = float[3](-1.415037499, -2.0, -4.0);
#else
// Binomial.
const float KERNEL[2] = float[2](0.5, 0.25);
const float LOG2_KERNEL[2] = float[2](-1.0, -2.0);
#endif

int field_width() { return (int(push.size.x) + 1) / 2; }

bool inside(ivec2 pixel) { return all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, ivec2(push.size))); }

// Light as it is filtered: luminance, red, blue; differences of luminance then cost nothing.
vec3 from_rgb(vec3 c) { return vec3(luminance(c), c.r, c.b); }

vec3 to_rgb(vec3 c) { return vec3(c.y, (c.x - 0.2126 * c.y - 0.0722 * c.z) * (1.0 / 0.7152), c.z); }

// What a level knows of a surface.
struct Texel {
    float distance;
    // steepness() over a step, negative: the fields hold two paths, 0: no surface.
    float steep;
    vec3 normal;
    float roughness;
    // Angle between the rays of neighbouring pixels.
    float angle;
};

const vec4 NO_LIGHT = vec4(0.0, 0.0, 0.0, -1.0);
const Texel NO_TEXEL = Texel(0.0, 0.0, vec3(0.0), 0.0, 0.0);

// A texel of a source as it is filtered.
vec4 decode_light(vec4 light) {
    vec4 squared = light * light;
    if (push.roots != 0u) light = vec4(squared.rgb, light.a < 0.0 ? -1.0 : squared.a * squared.a);
    return vec4(from_rgb(light.rgb), light.a);
}

#if ROOTS
// To the nearest half float, the even one of two: devices may round towards zero when they store, which would lose energy in every level.
vec4 rounded(vec4 v) {
    uvec4 bits = floatBitsToUint(v);
    return uintBitsToFloat((bits + 0xfffu + ((bits >> 13u) & 1u)) & ~0x1fffu);
}
#endif

// `dimension`: of the history, if it is one.
vec4 encode_light(vec4 light, ivec2 pixel, uint dimension) {
#if ROOTS
    if (half_histories && push.to_history != 0u) return light_code(light, rounding_numbers(pixel, dimension, push.rounding));
    vec4 roots = sqrt(max(light, 0.0));
    roots.a = sqrt(roots.a);
    roots = min(rounded(roots), GREATEST_HALF);
    return light.a < 0.0 ? vec4(roots.rgb, -1.0) : roots;
#else
    return light;
#endif
}

// Place of a pixel in the images, or of the nearest one in the picture.
ivec2 place_of(ivec2 pixel) { return flat_to_split(clamp(pixel, ivec2(0), ivec2(push.size) - 1), field_width()); }

Texel load_texel(ivec2 pixel) {
    Guide guide = unpack_guide(imageLoad(im_guide, place_of(pixel)));
    if (!inside(pixel) || guide.normal == 0u) return NO_TEXEL;
    vec4 g = guide.geometry;
    return Texel(g.x, steepness(g.y, push.depth) / float(push.step), unpack_unit_vector(guide.normal), g.z, g.w);
}

// Inverse tolerance of missing light: the geometry decides alone.
const float MISSING = 0.0;

// What a difference of luminance is multiplied by. `smoothed`: variance around; `variance`: its own, which says whether there is light.
float inverse_tolerance(float sigma, float smoothed, float variance) {
    return variance < 0.0 ? MISSING : LOG2_E / (sigma * sqrt(smoothed) + 1e-20);
}

// Weights of a tap `offset` steps away without the luminance, of diffuse and of specular light.
vec2 geometric_weights(Texel p, Texel q, ivec2 offset) {
    float squared = float(offset.x * offset.x + offset.y * offset.y);
    // Dammertz et al. 2010 and Schied et al. 2017, eq. 3, with the slope of the steeper of the two.
    float both = LOG2_KERNEL[abs(offset.x)] + LOG2_KERNEL[abs(offset.y)]
        - depth_exponent(vec2(p.distance, p.steep), vec2(q.distance, q.steep), sqrt(squared));
    // Where the fields reflect and refract, pixels of one field alone. The steps of other levels stay in it.
    if (((offset.x ^ offset.y) & 1) != 0 && push.step == 1u && min(p.steep, q.steep) < 0.0) both = -1e30;
    float turned = turn(p.normal, q.normal);
    // Specular light changes within the lobe: with the normal, and with the direction of view from pixel to pixel. The narrower lobe decides.
    float reach = push.lobe * max(square(min(p.roughness, q.roughness)), 1e-4), narrow = 1.0 / square(reach);
    float power = clamp(8.0 * narrow, push.normal, 1e4);
    float view = squared * square(p.angle * float(push.step)) * narrow;
    float alike = clamp(1.0 - 10.0 * abs(p.roughness - q.roughness), 0.0, 1.0);
    return vec2(exp2(LOG2_E * push.normal * turned + both), alike * exp2(LOG2_E * (power * turned - view) + both));
}

struct Sum {
    vec3 light;      // weighted
    float taken;     // weights of the other pixels
    float geometric; // the same without the luminance
    float variance;
};

const Sum NO_SUM = Sum(vec3(0.0), 0.0, 0.0, 0.0);

// Alpha of the light of centre and tap: inverse_tolerance(). `geometric`: weight of a tap whose light is there.
void add(inout Sum sum, vec4 p, vec4 q, float variance, float geometric) {
    geometric = q.a == MISSING ? 0.0 : geometric;
    // The pair's larger variance decides, so that both agree on the weight.
    float w = geometric * exp2(-abs(p.x - q.x) * min(p.a, q.a));
    sum.light += w * q.xyz;
    sum.taken += w;
    sum.geometric += geometric;
    sum.variance += square(w) * variance;
}

// `variance`: of the centre; negative: its light is missing.
vec4 finish(Sum sum, vec4 p, float variance) {
    // Missing light is that of its neighbours; squares of weights below this would vanish.
    if (variance < 0.0 && !(sum.taken > 1e-12)) return NO_LIGHT;
    float scale = 1.0 / (variance < 0.0 ? sum.taken : sum.geometric + square(KERNEL[0]));
    float own = variance < 0.0 ? 0.0 : 1.0 - sum.taken * scale;
    vec3 light = to_rgb(own * p.xyz + sum.light * scale);
    return vec4(max(light, 0.0), sum.variance * square(scale) + square(own) * max(variance, 0.0));
}
