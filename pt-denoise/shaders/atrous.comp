// One level of the edge-avoiding a-trous filter for both light channels and their variances (alpha; -1 = missing light), on the flat extent:
// Dammertz et al. 2010, "Edge-Avoiding A-Trous Wavelet Transform", with the variance-guided weights of Schied et al. 2017, section 4.4.
//
// A group filters pixels that are `step` apart, so that its taps are neighbours in the tile at every level: the permutation of Dolp, Hanika
// and Dachsbacher 2024, "Fast SVGF". The first level mixes the two checkerboard fields (the kernel is zero at the checkerboard's frequency);
// the steps of all others are even and stay in the field by themselves.
//
// The geometric weights are normalised. What the luminance weight takes from a tap stays with the centre instead of going to the other taps:
// the matrix of those weights is symmetric, so bright noise loses no energy by being rejected.
#include "checkerboard.glsl"
#include "denoise_records.glsl"
#include "edge_stopping.glsl"

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
// rgb, and the smoothed variance; negative: missing.
shared vec4 tile_hf[TILE.x * TILE.y];
shared vec4 tile_spec[TILE.x * TILE.y];
shared vec4 tile_geometry[TILE.x * TILE.y];
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
        vec4 hf = vec4(0.0, 0.0, 0.0, -1.0), spec = hf;
        Guide guide = NO_GUIDE;
        if (inside(pixel)) {
            ivec2 at = flat_to_split(pixel, field_width());
            guide = load_guide(at);
            if (guide.normal != 0u) {
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
            tile_geometry[k] = vec4(guide.geometry.xyz, uintBitsToFloat(guide.normal));
        }
    }
}

// 3 x 3 binomial filter over the variances that are there (Schied et al. 2017, section 4.4).
void smooth_variances() {
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
        if (tile_hf[k].a >= 0.0) tile_hf[k].a = sum.x / weights.x;
        if (tile_spec[k].a >= 0.0) tile_spec[k].a = sum.y / weights.y;
    }
}

// The pair's larger variance decides, so that both agree on the weight.
float luminance_weight(vec4 p, vec4 q, float sigma) {
    return exp(-abs(luminance(p.rgb) - luminance(q.rgb)) / (sigma * sqrt(max(p.a, q.a)) + 1e-20));
}

struct Sum {
    vec3 change;     // weighted differences from the centre
    float taken;     // weights of the other pixels
    float geometric; // the same without the luminance
    float variance;
};

void add(inout Sum sum, vec4 p, vec4 q, float variance, float geometric, float sigma) {
    if (q.a < 0.0) return;
    float w = geometric;
    if (p.a >= 0.0) w *= luminance_weight(p, q, sigma);
    if (w == 0.0) { sum.geometric += geometric; return; }
    sum.change += w * (q.rgb - p.rgb);
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
    vec4 geometry = tile_geometry[centre];
    Guide p = Guide(geometry, floatBitsToUint(geometry.w));
    vec4 hf = tile_hf[centre], spec = tile_spec[centre];
    if (p.normal == 0u) {
        imageStore(target_hf, at, hf);
        imageStore(target_spec, at, spec);
        return;
    }
    float pixel_angle = imageLoad(ch_bounce_throughput, at).a;
    Sum sum_hf = Sum(vec3(0.0), 0.0, 0.0, 0.0), sum_spec = sum_hf;
    for (int y = -2; y <= 2; ++y) {
        for (int x = -2; x <= 2; ++x) {
            ivec2 offset = ivec2(x, y);
            int i = centre + y * TILE.x + x;
            vec4 other = tile_geometry[i];
            Guide q = Guide(other, floatBitsToUint(other.w));
            if (offset == ivec2(0) || q.normal == 0u) continue;
            if (!same_path(p, q, offset * int(push.step))) continue;
            float pixels = float(push.step) * length(vec2(offset));
            float cosine = normal_cosine(p, q);
            float w = KERNEL[abs(x)] * KERNEL[abs(y)] * depth_weight(p, q, pixels, push.depth);
            vec2 variance = tile_variance[(local.y + 3 + y) * OUTER.x + local.x + 3 + x];
            add(sum_hf, hf, tile_hf[i], variance.x, w * pow(cosine, push.normal), push.luminance_hf);

            // Specular light changes within the lobe: with the normal, and with the direction of view from pixel to pixel.
            float alpha = max(square(min(geometry.z, other.z)), 1e-4);
            float turn = pixels * pixel_angle / (push.lobe * alpha);
            float lobe = exp(-turn * turn) * max(0.0, 1.0 - 10.0 * abs(geometry.z - other.z));
            float power = clamp(8.0 / square(push.lobe * alpha), push.normal, 1e4);
            add(sum_spec, spec, tile_spec[i], variance.y, w * lobe * pow(cosine, power), push.luminance_spec);
        }
    }
    vec2 own = tile_variance[(local.y + 3) * OUTER.x + local.x + 3];
    imageStore(target_hf, at, finish(sum_hf, hf, own.x));
    imageStore(target_spec, at, finish(sum_spec, spec, own.y));
}
