// What the two schedules of the a-trous filter share: weights of a pair of pixels, and their sums. Included by atrous_*.comp, which define RADIUS: taps to each side; and
// ROOTS: the target holds roots of light in half floats (levels_hf), else light (history_hf).
// The kernel declares `push` as AtrousPush.
//
// The geometric weights are normalised. What the luminance weight takes from a tap stays with the centre instead of going to the other taps:
// the matrix of those weights is symmetric, so bright noise loses no energy by being rejected.
//
// Every factor of a weight is a power of two, so that factors are sums of exponents. What depends on one pixel alone is computed once for it, and the larger range or variance
// of a pair is the smaller of two inverses: a tap takes no division, no root and no power.
#include "channels.glsl"
#include "checkerboard.glsl"
#include "denoise_images.glsl"
#include "edge_stopping.glsl"
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

// What a level knows of a pixel.
struct Texel {
    // x: distance; y: what a difference of distances over a step is multiplied by at one pixel, negative: the fields hold two paths, 0: no surface; z: exponent of the
    // specular weight one step away, from the lobe; w: power of the specular weight by normals.
    vec4 surface;
    // Shading normal, and roughness.
    vec4 normal;
    // Light as it is filtered, and its variance; negative: missing. In a pair: inverse_tolerance().
    vec4 hf;
    vec4 spec;
};

const vec4 NO_LIGHT = vec4(0.0, 0.0, 0.0, -1.0);
const Texel NO_TEXEL = Texel(vec4(0.0), vec4(0.0), NO_LIGHT, NO_LIGHT);

// A texel of a source as it is filtered.
vec4 decode_light(vec4 light) {
    vec4 squared = light * light;
    if (push.roots != 0u) light = vec4(squared.rgb, light.a < 0.0 ? -1.0 : squared.a * squared.a);
    return vec4(from_rgb(light.rgb), light.a);
}

// Greatest half float.
const float MAX_HALF = 65504.0;

#if ROOTS
// To the nearest half float, the even one of two: devices may round towards zero when they store, which would lose energy in every level.
vec4 rounded(vec4 v) {
    uvec4 bits = floatBitsToUint(v);
    return uintBitsToFloat((bits + 0xfffu + ((bits >> 13u) & 1u)) & ~0x1fffu);
}
#endif

vec4 encode_light(vec4 light) {
#if ROOTS
    vec4 roots = sqrt(max(light, 0.0));
    roots.a = sqrt(roots.a);
    roots = min(rounded(roots), MAX_HALF);
    return light.a < 0.0 ? vec4(roots.rgb, -1.0) : roots;
#else
    return light;
#endif
}

// A pixel as the images have it.
struct Fetched { uvec4 guide; vec4 hf; vec4 spec; };

Fetched fetch(ivec2 pixel) {
    ivec2 at = flat_to_split(clamp(pixel, ivec2(0), ivec2(push.size) - 1), field_width());
    Fetched fetched = Fetched(imageLoad(im_guide, at), texelFetch(source_hf, at, 0), texelFetch(source_spec, at, 0));
    if (!inside(pixel)) fetched.guide = uvec4(0u);
    return fetched;
}

Texel decode(Fetched fetched) {
    Guide guide = unpack_guide(fetched.guide);
    if (guide.normal == 0u) return NO_TEXEL;
    vec4 g = guide.geometry;
    float steep = steepness(g.y, push.depth) / float(push.step);
    // Specular light changes within the lobe: with the direction of view from pixel to pixel, and with the normal.
    float narrow = 1.0 / (push.lobe * max(square(g.z), 1e-4));
    float view = LOG2_E * square(g.w * float(push.step) * narrow);
    float power = LOG2_E * clamp(8.0 * square(narrow), push.normal, 1e4);
    return Texel(vec4(g.x, steep, view, power), vec4(unpack_unit_vector(guide.normal), g.z), decode_light(fetched.hf), decode_light(fetched.spec));
}

// Inverse tolerance of missing light: the geometry decides alone.
const float MISSING = 0.0;

// What a difference of luminance is multiplied by, from the smoothed variance of each channel and from its own, which says whether there is light.
vec2 inverse_tolerance(vec2 smoothed, vec2 variance) {
    vec2 inverse = LOG2_E / (vec2(push.luminance_hf, push.luminance_spec) * sqrt(smoothed) + 1e-20);
    return mix(inverse, vec2(MISSING), lessThan(variance, vec2(0.0)));
}

// Weights of two pixels `offset` steps apart without the luminance, of diffuse and of specular light.
vec2 geometric_weights(Texel p, Texel q, ivec2 offset) {
    float squared = float(offset.x * offset.x + offset.y * offset.y);
    // Dammertz et al. 2010 and Schied et al. 2017, eq. 3, with the slope of the steeper of the two.
    float both = LOG2_KERNEL[abs(offset.x)] + LOG2_KERNEL[abs(offset.y)] - depth_exponent(p.surface.xy, q.surface.xy, sqrt(squared));
    // Where the fields reflect and refract, pixels of one field alone. The steps of other levels stay in it.
    if (((offset.x ^ offset.y) & 1) != 0 && push.step == 1u && min(p.surface.y, q.surface.y) < 0.0) both = -1e30;
    float turned = turn(p.normal.xyz, q.normal.xyz);
    float hf = LOG2_E * push.normal * turned + both;
    // The narrower of the two lobes decides.
    float spec = max(p.surface.w, q.surface.w) * turned + both - squared * max(p.surface.z, q.surface.z);
    float alike = clamp(1.0 - 10.0 * abs(p.normal.w - q.normal.w), 0.0, 1.0);
    return vec2(exp2(hf), alike * exp2(spec));
}

// Factor on a weight by the luminance. The pair's larger variance decides, so that both agree on the weight.
float luminance_weight(vec4 p, vec4 q) { return exp2(-abs(p.x - q.x) * min(p.a, q.a)); }

struct Sum {
    vec3 light;      // weighted
    float taken;     // weights of the other pixels
    float geometric; // the same without the luminance
    float variance;
};

const Sum NO_SUM = Sum(vec3(0.0), 0.0, 0.0, 0.0);

void add(inout Sum sum, vec4 q, float variance, float geometric, float by_luminance) {
    geometric = q.a == MISSING ? 0.0 : geometric;
    float w = geometric * by_luminance;
    sum.light += w * q.xyz;
    sum.taken += w;
    sum.geometric += geometric;
    sum.variance += square(w) * variance;
}

// Both channels of a pixel.
struct Sums { Sum hf; Sum spec; };

const Sums NO_SUMS = Sums(NO_SUM, NO_SUM);

// Adds a tap `offset` steps away. `variance`: of both channels of the tap.
void add_tap(inout Sums sums, Texel p, Texel q, vec2 variance, ivec2 offset) {
    vec2 geometric = geometric_weights(p, q, offset);
    add(sums.hf, q.hf, variance.x, geometric.x, luminance_weight(p.hf, q.hf));
    add(sums.spec, q.spec, variance.y, geometric.y, luminance_weight(p.spec, q.spec));
}

// Adds two pixels to the sums of each other.
void add_pair(inout Sums sums_p, inout Sums sums_q, Texel p, Texel q, vec2 variance_p, vec2 variance_q, ivec2 offset) {
    vec2 geometric = geometric_weights(p, q, offset);
    vec2 by_luminance = vec2(luminance_weight(p.hf, q.hf), luminance_weight(p.spec, q.spec));
    add(sums_p.hf, q.hf, variance_q.x, geometric.x, by_luminance.x);
    add(sums_p.spec, q.spec, variance_q.y, geometric.y, by_luminance.y);
    add(sums_q.hf, p.hf, variance_p.x, geometric.x, by_luminance.x);
    add(sums_q.spec, p.spec, variance_p.y, geometric.y, by_luminance.y);
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

void store(ivec2 pixel, Sums sums, Texel p, vec2 variance) {
    ivec2 at = flat_to_split(pixel, field_width());
    bool surface = p.surface.y != 0.0;
    imageStore(target_hf, at, surface ? encode_light(finish(sums.hf, p.hf, variance.x)) : NO_LIGHT);
    imageStore(target_spec, at, surface ? encode_light(finish(sums.spec, p.spec, variance.y)) : NO_LIGHT);
}
