// Included by atrous_dilated_3x3*.comp (RADIUS 1) and atrous_dilated_5x5*.comp (RADIUS 2).
//
// The same level of the a-trous filter as atrous_permuted.glsl without the permutation: neighbouring threads filter neighbouring pixels, and each fetches its taps, `step` pixels
// apart, itself (Dammertz et al. 2010). For comparison: caches serve it worse with every level.
#include "denoise_records.glsl"

layout(local_size_x = 16, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { AtrousPush push; };
#include "atrous.glsl"

// Along a side: taps, and the variances that they are smoothed with.
const int TAPS = 2 * RADIUS + 1, AROUND = TAPS + 2;

vec2 variance_at(ivec2 pixel) {
    if (!inside(pixel)) return vec2(-1.0);
    ivec2 at = flat_to_split(pixel, field_width());
    if (imageLoad(im_guide, at).z == 0u) return vec2(-1.0);
    return vec2(decode_light(texelFetch(source_hf, at, 0)).a, decode_light(texelFetch(source_spec, at, 0)).a);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!inside(pixel)) return;
    int step = int(push.step);
    ivec2 at = place_of(pixel);
    Texel p = load_texel(pixel);
    if (p.steep == 0.0) {
        imageStore(target_hf, at, NO_LIGHT);
        imageStore(target_spec, at, NO_LIGHT);
        return;
    }
    vec2 variances[AROUND * AROUND];
    for (int i = 0; i < AROUND * AROUND; ++i) variances[i] = variance_at(pixel + (ivec2(i % AROUND, i / AROUND) - AROUND / 2) * step);
    vec2 tolerances[TAPS * TAPS];
    for (int k = 0; k < TAPS * TAPS; ++k) {
        int middle = (k / TAPS + 1) * AROUND + k % TAPS + 1;
        vec2 sum = vec2(0.0), weights = vec2(0.0);
        for (int i = 0; i < 9; ++i) {
            ivec2 offset = ivec2(i % 3, i / 3) - 1;
            vec2 v = variances[middle + offset.y * AROUND + offset.x];
            vec2 w = exp2(float(-abs(offset.x) - abs(offset.y))) * vec2(greaterThanEqual(v, vec2(0.0)));
            sum += w * v;
            weights += w;
        }
        vec2 smoothed = sum / max(weights, 1e-20), own = variances[middle];
        tolerances[k] = vec2(inverse_tolerance(push.luminance_hf, smoothed.x, own.x), inverse_tolerance(push.luminance_spec, smoothed.y, own.y));
    }
    const int MIDDLE = TAPS * TAPS / 2;
    vec4 hf = decode_light(texelFetch(source_hf, at, 0)), spec = decode_light(texelFetch(source_spec, at, 0));
    vec4 p_hf = vec4(hf.xyz, tolerances[MIDDLE].x), p_spec = vec4(spec.xyz, tolerances[MIDDLE].y);
    Sum sum_hf = NO_SUM, sum_spec = NO_SUM;
    [[unroll]] for (int y = -RADIUS; y <= RADIUS; ++y) {
        [[unroll]] for (int x = -RADIUS; x <= RADIUS; ++x) {
            ivec2 tap = pixel + ivec2(x, y) * step, from = place_of(tap);
            Texel q = load_texel(tap);
            if (x == 0 && y == 0 || q.steep == 0.0) continue;
            vec4 q_hf = decode_light(texelFetch(source_hf, from, 0)), q_spec = decode_light(texelFetch(source_spec, from, 0));
            vec2 geometric = geometric_weights(p, q, ivec2(x, y)), tolerance = tolerances[MIDDLE + y * TAPS + x];
            add(sum_hf, p_hf, vec4(q_hf.xyz, tolerance.x), q_hf.a, geometric.x);
            add(sum_spec, p_spec, vec4(q_spec.xyz, tolerance.y), q_spec.a, geometric.y);
        }
    }
    imageStore(target_hf, at, encode_light(finish(sum_hf, p_hf, hf.a), pixel, DIM_HISTORIES + 5u));
    imageStore(target_spec, at, encode_light(finish(sum_spec, p_spec, spec.a), pixel, DIM_HISTORIES + 6u));
}
