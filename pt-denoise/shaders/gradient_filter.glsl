// Included by gradient_filter.comp (INDIRECT 0) and gradient_filter_indirect.comp (INDIRECT 1: there are sums of indirect diffuse light).
//
// One pass of a filter over gradients and sums, without edge stopping: binomial taps, push.step strata apart; 3 x 3 of them (a-trous: Dammertz et al. 2010) or 5 x 5.
// The third and fourth component of sums are multiplied by push.variance: that of a weighted mean is smaller than the mean of the variances. At the border fewer taps
// make it less so. Extent: strata.
#include "denoise_records.glsl"

layout(local_size_x = 16, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { GradientPush push; };
layout(set = 2, binding = 0) uniform sampler2D source_pixels;
layout(set = 2, binding = 1) uniform sampler2D source_hf;
layout(set = 2, binding = 2) uniform sampler2D source_spec;
layout(set = 2, binding = 3, rgba32f) uniform writeonly image2D target_pixels;
layout(set = 2, binding = 4, rgba32f) uniform writeonly image2D target_hf;
layout(set = 2, binding = 5, rgba32f) uniform writeonly image2D target_spec;
#if INDIRECT
layout(set = 2, binding = 6) uniform sampler2D source_lf;
layout(set = 2, binding = 7, rgba32f) uniform writeonly image2D target_lf;
#endif
#include "stratum.glsl"
// Taps to each side.
layout(constant_id = 9) const int radius = 1;

float weight_at(int distance) {
    if (radius == 1) return distance == 0 ? 0.5 : 0.25;
    return distance == 0 ? 0.375 : distance == 1 ? 0.25 : 0.0625;
}

void main() {
    ivec2 stratum = ivec2(gl_GlobalInvocationID.xy), count = stratum_count();
    if (any(greaterThanEqual(stratum, count))) return;
    vec4 pixels = vec4(0.0), hf = vec4(0.0), spec = vec4(0.0), lf = vec4(0.0);
    float weights = 0.0, squares = 0.0;
    for (int y = -radius; y <= radius; ++y) {
        for (int x = -radius; x <= radius; ++x) {
            ivec2 tap = stratum + ivec2(x, y) * int(push.step);
            if (any(lessThan(tap, ivec2(0))) || any(greaterThanEqual(tap, count))) continue;
            float weight = weight_at(abs(x)) * weight_at(abs(y));
            pixels += weight * texelFetch(source_pixels, tap, 0);
            hf += weight * texelFetch(source_hf, tap, 0);
            spec += weight * texelFetch(source_spec, tap, 0);
#if INDIRECT
            lf += weight * texelFetch(source_lf, tap, 0);
#endif
            weights += weight;
            squares += weight * weight;
        }
    }
    // Of all taps: the square of the sum of squares along an axis.
    float all_squares = radius == 1 ? 0.140625 : 0.07476806640625;
    vec4 of_sum = vec4(vec2(1.0), vec2(min(push.variance * squares / (weights * weights * all_squares), 1.0))) / weights;
    imageStore(target_pixels, stratum, pixels / weights);
    imageStore(target_hf, stratum, hf * of_sum);
    imageStore(target_spec, stratum, spec * of_sum);
#if INDIRECT
    imageStore(target_lf, stratum, lf * of_sum);
#endif
}
