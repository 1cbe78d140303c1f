// What the two schedules of the a-trous filter share: weights of a pair of pixels, and their sums. The kernel declares `push` as AtrousPush.
//
// The geometric weights are normalised. What the luminance weight takes from a tap stays with the centre instead of going to the other taps:
// the matrix of those weights is symmetric, so bright noise loses no energy by being rejected.
//
// The larger range or variance of a pair is the smaller of two inverses: what a tap needs is computed once for it, and a tap takes one division
// and no root. Every factor is a power of two, so that factors are sums of exponents.
#include "channels.glsl"
#include "checkerboard.glsl"
#include "denoise_images.glsl"
#include "math.glsl"
#include "pack.glsl"

layout(set = 2, binding = 0) uniform sampler2D source_hf;
layout(set = 2, binding = 1) uniform sampler2D source_spec;
layout(set = 2, binding = 2, rgba32f) uniform writeonly image2D target_hf;
layout(set = 2, binding = 3, rgba32f) uniform writeonly image2D target_spec;

// B3 spline.
const float KERNEL[3] = float[3](0.375, 0.25, 0.0625);
const ivec2 GROUP = ivec2(16, 8);
const float LOG2_E = 1.442695041;

int field_width() { return (int(push.size.x) + 1) / 2; }

bool inside(ivec2 pixel) { return all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, ivec2(push.size))); }

// What a level knows of a pixel. geometry: x: distance; y: what a difference of distances is multiplied by at one pixel, negative: the fields hold two paths, 0: no
// surface; z: roughness. Light: rgb, alpha as it is stored.
struct Texel { vec3 geometry; vec3 normal; vec4 hf; vec4 spec; };

const Texel NO_TEXEL = Texel(vec3(0.0), vec3(0.0), vec4(0.0, 0.0, 0.0, -1.0), vec4(0.0, 0.0, 0.0, -1.0));

Texel load_texel(ivec2 pixel) {
    if (!inside(pixel)) return NO_TEXEL;
    ivec2 at = flat_to_split(pixel, field_width());
    uint packed_normal = imageLoad(ch_normal, at).x;
    if (packed_normal == 0u) return NO_TEXEL;
    vec4 g = imageLoad(im_geometry, at);
    float steep = clamp(LOG2_E / (push.depth * g.y), -1e30, 1e30);
    return Texel(vec3(g.x, steep, g.z), unpack_unit_vector(packed_normal), texelFetch(source_hf, at, 0), texelFetch(source_spec, at, 0));
}

// What a difference of luminance is multiplied by, from a smoothed variance of each channel.
vec2 inverse_tolerance(vec2 variance) {
    return LOG2_E / (vec2(push.luminance_hf, push.luminance_spec) * sqrt(variance) + 1e-20);
}

struct Sum {
    vec3 change;     // weighted differences from the centre
    float taken;     // weights of the other pixels
    float geometric; // the same without the luminance
    float variance;
};

const Sum NO_SUM = Sum(vec3(0.0), 0.0, 0.0, 0.0);

void add(inout Sum sum, vec4 p, vec4 q, float variance, float geometric) {
    if (q.a < 0.0) return;
    vec3 change = q.rgb - p.rgb;
    // The pair's larger variance decides, so that both agree on the weight.
    float w = p.a < 0.0 ? geometric : geometric * exp2(-abs(luminance(change)) * min(p.a, q.a));
    sum.change += w * change;
    sum.taken += w;
    sum.geometric += geometric;
    sum.variance += w * w * variance;
}

vec4 finish(Sum sum, vec4 p, float variance) {
    // Missing light is that of its neighbours; squares of weights below this would vanish.
    if (p.a < 0.0) return sum.taken > 1e-12 ? vec4(p.rgb + sum.change / sum.taken, sum.variance / square(sum.taken)) : p;
    float scale = 1.0 / (sum.geometric + square(KERNEL[0]));
    float own = 1.0 - sum.taken * scale;
    return vec4(max(p.rgb + sum.change * scale, 0.0), sum.variance * square(scale) + square(own) * variance);
}

// What a pixel filters with: the same for all its taps.
struct Centre { vec3 geometry; vec3 normal; vec4 hf; vec4 spec; float angle; float inverse_step; float inverse_lobe; };

// Adds a tap `offset` steps away. Alpha of the light: inverse_tolerance(), negative: missing. `variance`: of both channels of the tap.
void add_tap(inout Sum sum_hf, inout Sum sum_spec, Centre p, ivec2 offset, vec3 geometry, vec3 normal, vec4 hf, vec4 spec, vec2 variance) {
    // Where the fields reflect and refract, pixels of one field alone. The steps of other levels stay in it.
    bool other_path = push.step == 1u && ((offset.x ^ offset.y) & 1) != 0 && (p.geometry.y < 0.0 || geometry.y < 0.0);
    if (offset == ivec2(0) || geometry.y == 0.0 || other_path) return;
    float distance = length(vec2(offset)), spline = KERNEL[abs(offset.x)] * KERNEL[abs(offset.y)];
    // Dammertz et al. 2010 and Schied et al. 2017, eq. 3, with the slope of the steeper of the two.
    float depth = abs(p.geometry.x - geometry.x) * min(abs(p.geometry.y), abs(geometry.y)) * p.inverse_step * (1.0 / distance);
    float cosine = log2(clamp(dot(p.normal, normal), 1e-30, 1.0));
    add(sum_hf, p.hf, hf, variance.x, spline * exp2(push.normal * cosine - depth));

    // Specular light changes within the lobe: with the normal, and with the direction of view from pixel to pixel.
    float narrow = p.inverse_lobe / max(square(min(p.geometry.z, geometry.z)), 1e-4), turn = distance * p.angle * narrow;
    float power = clamp(8.0 * square(narrow), push.normal, 1e4);
    float alike = max(0.0, 1.0 - 10.0 * abs(p.geometry.z - geometry.z));
    float w = spline * alike * exp2(power * cosine - depth - LOG2_E * square(turn));
    add(sum_spec, p.spec, spec, variance.y, w);
}

Centre centre_at(ivec2 at, vec3 geometry, vec3 normal, vec4 hf, vec4 spec) {
    float angle = imageLoad(im_geometry, at).w * float(push.step);
    return Centre(geometry, normal, hf, spec, angle, 1.0 / float(push.step), 1.0 / push.lobe);
}
