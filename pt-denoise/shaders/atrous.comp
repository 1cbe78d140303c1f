// One level of the edge-avoiding a-trous filter for both light channels and their variances (alpha; -1 = missing light), on the flat extent:
// Dammertz et al. 2010, "Edge-Avoiding A-Trous Wavelet Transform", with the variance-guided weights of Schied et al. 2017, section 4.4.
//
// A group filters pixels that are `step` apart, so that its taps are neighbours in the tile at every level: the permutation of Dolp, Hanika
// and Dachsbacher 2024, "Fast SVGF". The first level mixes the two checkerboard fields (the kernel is zero at the checkerboard's frequency);
// the steps of all others are even and stay in the field by themselves.
//
// The geometric weights are normalised. What the luminance weight takes from a tap stays with the centre instead of going to the other taps:
// the matrix of those weights is symmetric, so bright noise loses no energy by being rejected.
//
// The larger range or variance of a pair is the smaller of two inverses: what a tap needs is computed once when the tile is loaded, and a tap takes one division
// and no root. Every factor is a power of two, so that factors are sums of exponents.
#include "channels.glsl"
#include "checkerboard.glsl"
#include "denoise_images.glsl"
#include "denoise_records.glsl"
#include "math.glsl"
#include "pack.glsl"

layout(local_size_x = 16, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { AtrousPush push; };
layout(set = 2, binding = 0) uniform sampler2D source_hf;
layout(set = 2, binding = 1) uniform sampler2D source_spec;
layout(set = 2, binding = 2, rgba32f) uniform writeonly image2D target_hf;
layout(set = 2, binding = 3, rgba32f) uniform writeonly image2D target_spec;

// B3 spline.
const float KERNEL[3] = float[3](0.375, 0.25, 0.0625);
const ivec2 GROUP = ivec2(16, 8);
// Taps reach two pixels beyond the group, and the variances of these are smoothed with one more.
const ivec2 TILE = GROUP + 4;
const ivec2 OUTER = GROUP + 6;
const float LOG2_E = 1.442695041;
// rgb, and what a difference of luminance is multiplied by; negative: missing.
shared vec4 tile_hf[TILE.x * TILE.y];
shared vec4 tile_spec[TILE.x * TILE.y];
// x: distance; y: what a difference of distances is multiplied by at one pixel, negative: the fields hold two paths; z: roughness; w: x of the normal.
shared vec4 tile_geometry[TILE.x * TILE.y];
// y and z of the normal. With these the tile fits into the 16384 bytes that every device has.
shared vec2 tile_normal[TILE.x * TILE.y];
// Of both channels, as they are.
shared vec2 tile_variance[OUTER.x * OUTER.y];

int field_width() { return (int(push.size.x) + 1) / 2; }

// First pixel of the group's lattice. Groups beside each other take the pixels between.
ivec2 group_origin() {
    ivec2 group = ivec2(gl_WorkGroupID.xy), s = ivec2(int(push.step));
    return group % s + group / s * GROUP * s;
}

bool inside(ivec2 pixel) { return all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, ivec2(push.size))); }

void load_tile() {
    ivec2 origin = group_origin();
    for (int i = int(gl_LocalInvocationIndex); i < OUTER.x * OUTER.y; i += 128) {
        ivec2 place = ivec2(i % OUTER.x, i / OUTER.x);
        ivec2 pixel = origin + (place - 3) * int(push.step);
        vec4 hf = vec4(0.0, 0.0, 0.0, -1.0), spec = hf, geometry = vec4(0.0);
        vec3 normal = vec3(0.0);
        if (inside(pixel)) {
            ivec2 at = flat_to_split(pixel, field_width());
            uint packed_normal = imageLoad(ch_normal, at).x;
            if (packed_normal != 0u) {
                normal = unpack_unit_vector(packed_normal);
                vec4 g = imageLoad(im_geometry, at);
                float steep = clamp(LOG2_E / (push.depth * g.y), -1e30, 1e30);
                geometry = vec4(g.x, steep, g.z, normal.x);
                hf = texelFetch(source_hf, at, 0);
                spec = texelFetch(source_spec, at, 0);
            }
        }
        tile_variance[i] = vec2(hf.a, spec.a);
        ivec2 inner = place - 1;
        if (all(greaterThanEqual(inner, ivec2(0))) && all(lessThan(inner, TILE))) {
            int k = inner.y * TILE.x + inner.x;
            tile_hf[k] = hf;
            tile_spec[k] = spec;
            tile_geometry[k] = geometry;
            tile_normal[k] = normal.yz;
        }
    }
}

// 3 x 3 binomial filter over the variances that are there (Schied et al. 2017, section 4.4), and the tolerance of the luminance that follows.
void smooth_variances() {
    vec2 sigma = vec2(push.luminance_hf, push.luminance_spec);
    for (int k = int(gl_LocalInvocationIndex); k < TILE.x * TILE.y; k += 128) {
        ivec2 centre = ivec2(k % TILE.x, k / TILE.x) + 1;
        vec2 sum = vec2(0.0), weights = vec2(0.0);
        for (int i = 0; i < 9; ++i) {
            ivec2 offset = ivec2(i % 3, i / 3) - 1;
            vec2 v = tile_variance[(centre.y + offset.y) * OUTER.x + centre.x + offset.x];
            vec2 w = exp2(float(-abs(offset.x) - abs(offset.y))) * vec2(greaterThanEqual(v, vec2(0.0)));
            sum += w * max(v, 0.0);
            weights += w;
        }
        vec2 inverse = LOG2_E / (sigma * sqrt(sum / max(weights, 1e-20)) + 1e-20);
        if (tile_hf[k].a >= 0.0) tile_hf[k].a = inverse.x;
        if (tile_spec[k].a >= 0.0) tile_spec[k].a = inverse.y;
    }
}

struct Sum {
    vec3 change;     // weighted differences from the centre
    float taken;     // weights of the other pixels
    float geometric; // the same without the luminance
    float variance;
};

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

void main() {
    load_tile();
    barrier();
    smooth_variances();
    barrier();
    ivec2 local = ivec2(gl_LocalInvocationID.xy);
    ivec2 pixel = group_origin() + local * int(push.step);
    if (!inside(pixel)) return;
    ivec2 at = flat_to_split(pixel, field_width());
    int centre = (local.y + 2) * TILE.x + local.x + 2;
    vec4 p = tile_geometry[centre], hf = tile_hf[centre], spec = tile_spec[centre];
    vec3 normal = vec3(p.w, tile_normal[centre]);
    if (p.y == 0.0) {
        imageStore(target_hf, at, hf);
        imageStore(target_spec, at, spec);
        return;
    }
    float inverse_step = 1.0 / float(push.step), inverse_lobe = 1.0 / push.lobe, angle = imageLoad(im_geometry, at).w * float(push.step);
    Sum sum_hf = Sum(vec3(0.0), 0.0, 0.0, 0.0), sum_spec = sum_hf;
    for (int y = -2; y <= 2; ++y) {
        for (int x = -2; x <= 2; ++x) {
            int i = centre + y * TILE.x + x;
            vec4 q = tile_geometry[i];
            // Where the fields reflect and refract, pixels of one field alone. The steps of other levels stay in it.
            bool other_path = push.step == 1u && ((x ^ y) & 1) != 0 && (p.y < 0.0 || q.y < 0.0);
            if (x == 0 && y == 0 || q.y == 0.0 || other_path) continue;
            float distance = length(vec2(x, y)), spline = KERNEL[abs(x)] * KERNEL[abs(y)];
            // Dammertz et al. 2010 and Schied et al. 2017, eq. 3, with the slope of the steeper of the two.
            float depth = abs(p.x - q.x) * min(abs(p.y), abs(q.y)) * inverse_step * (1.0 / distance);
            float cosine = log2(clamp(dot(normal, vec3(q.w, tile_normal[i])), 1e-30, 1.0));
            vec2 variance = tile_variance[(local.y + 3 + y) * OUTER.x + local.x + 3 + x];
            add(sum_hf, hf, tile_hf[i], variance.x, spline * exp2(push.normal * cosine - depth));

            // Specular light changes within the lobe: with the normal, and with the direction of view from pixel to pixel.
            float narrow = inverse_lobe / max(square(min(p.z, q.z)), 1e-4), turn = distance * angle * narrow;
            float power = clamp(8.0 * square(narrow), push.normal, 1e4);
            float alike = max(0.0, 1.0 - 10.0 * abs(p.z - q.z));
            float w = spline * alike * exp2(power * cosine - depth - LOG2_E * square(turn));
            add(sum_spec, spec, tile_spec[i], variance.y, w);
        }
    }
    vec2 own = tile_variance[(local.y + 3) * OUTER.x + local.x + 3];
    imageStore(target_hf, at, finish(sum_hf, hf, own.x));
    imageStore(target_spec, at, finish(sum_spec, spec, own.y));
}
