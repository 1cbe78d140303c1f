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
    Texel own = decode(fetch(pixel));
    if (own.surface.y == 0.0) {
        store(pixel, NO_SUMS, own, vec2(-1.0));
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
        tolerances[k] = inverse_tolerance(sum / max(weights, 1e-20), variances[middle]);
    }
    const int MIDDLE = TAPS * TAPS / 2;
    Texel p = Texel(own.surface, own.normal, vec4(own.hf.xyz, tolerances[MIDDLE].x), vec4(own.spec.xyz, tolerances[MIDDLE].y));
    Sums sums = NO_SUMS;
    [[unroll]] for (int y = -RADIUS; y <= RADIUS; ++y) {
        [[unroll]] for (int x = -RADIUS; x <= RADIUS; ++x) {
            if (x == 0 && y == 0) continue;
            Texel q = decode(fetch(pixel + ivec2(x, y) * step));
            vec2 variance = vec2(q.hf.a, q.spec.a);
            int k = MIDDLE + y * TAPS + x;
            q.hf.a = tolerances[k].x;
            q.spec.a = tolerances[k].y;
            add_tap(sums, p, q, variance, ivec2(x, y));
        }
    }
    store(pixel, sums, p, vec2(own.hf.a, own.spec.a));
}
