// The same level of the a-trous filter as atrous.comp without the permutation: neighbouring threads filter neighbouring pixels, and each fetches its taps, `step` pixels
// apart, itself (Dammertz et al. 2010). For comparison: caches serve it worse with every level.
#include "denoise_records.glsl"

layout(local_size_x = 16, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { AtrousPush push; };
#include "atrous.glsl"

vec2 variance_at(ivec2 pixel) {
    if (!inside(pixel)) return vec2(-1.0);
    ivec2 at = flat_to_split(pixel, field_width());
    if (imageLoad(ch_normal, at).x == 0u) return vec2(-1.0);
    return vec2(texelFetch(source_hf, at, 0).a, texelFetch(source_spec, at, 0).a);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!inside(pixel)) return;
    int step = int(push.step);
    ivec2 at = flat_to_split(pixel, field_width());
    Texel own = load_texel(pixel);
    if (own.geometry.y == 0.0) {
        imageStore(target_hf, at, own.hf);
        imageStore(target_spec, at, own.spec);
        return;
    }
    // Variances of the taps and of what they are smoothed with.
    vec2 variances[49];
    for (int i = 0; i < 49; ++i) variances[i] = variance_at(pixel + (ivec2(i % 7, i / 7) - 3) * step);
    vec2 tolerances[25];
    for (int k = 0; k < 25; ++k) {
        int middle = (k / 5 + 1) * 7 + k % 5 + 1;
        vec2 sum = vec2(0.0), weights = vec2(0.0);
        for (int i = 0; i < 9; ++i) {
            ivec2 offset = ivec2(i % 3, i / 3) - 1;
            vec2 v = variances[middle + offset.y * 7 + offset.x];
            vec2 w = exp2(float(-abs(offset.x) - abs(offset.y))) * vec2(greaterThanEqual(v, vec2(0.0)));
            sum += w * max(v, 0.0);
            weights += w;
        }
        // Missing light stays marked.
        tolerances[k] = mix(inverse_tolerance(sum / max(weights, 1e-20)), vec2(-1.0), lessThan(variances[middle], vec2(0.0)));
    }
    vec4 hf = vec4(own.hf.rgb, tolerances[12].x), spec = vec4(own.spec.rgb, tolerances[12].y);
    Centre p = centre_at(at, own.geometry, own.normal, hf, spec);
    Sum sum_hf = NO_SUM, sum_spec = NO_SUM;
    for (int k = 0; k < 25; ++k) {
        ivec2 offset = ivec2(k % 5, k / 5) - 2;
        Texel q = load_texel(pixel + offset * step);
        vec2 variance = variances[(k / 5 + 1) * 7 + k % 5 + 1];
        add_tap(sum_hf, sum_spec, p, offset, q.geometry, q.normal, vec4(q.hf.rgb, tolerances[k].x), vec4(q.spec.rgb, tolerances[k].y), variance);
    }
    vec2 variance = variances[24];
    imageStore(target_hf, at, finish(sum_hf, hf, variance.x));
    imageStore(target_spec, at, finish(sum_spec, spec, variance.y));
}
