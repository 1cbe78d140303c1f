// One level of an a-trous filter over gradients, without edge stopping: 3 x 3 binomial taps, push.step strata apart. The third and fourth component are
// multiplied by push.variance: that of a weighted mean is smaller than the mean of the variances. At the border fewer taps make it less so. Extent:
// strata.
#include "denoise_records.glsl"

layout(local_size_x = 16, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { GradientPush push; };
layout(set = 2, binding = 0) uniform sampler2D source;
layout(set = 2, binding = 1, rgba32f) uniform writeonly image2D target;

const float KERNEL[2] = float[2](0.5, 0.25);

void main() {
    ivec2 stratum = ivec2(gl_GlobalInvocationID.xy), count = (ivec2(push.size) + 2) / 3;
    if (any(greaterThanEqual(stratum, count))) return;
    vec4 sum = vec4(0.0);
    float weights = 0.0, squares = 0.0;
    for (int i = 0; i < 9; ++i) {
        ivec2 offset = ivec2(i % 3, i / 3) - 1, tap = stratum + offset * int(push.step);
        if (any(lessThan(tap, ivec2(0))) || any(greaterThanEqual(tap, count))) continue;
        float weight = KERNEL[abs(offset.x)] * KERNEL[abs(offset.y)];
        sum += weight * texelFetch(source, tap, 0);
        weights += weight;
        squares += weight * weight;
    }
    sum /= weights;
    const float all_squares = 0.140625;
    if (push.variance < 1.0) sum.zw *= min(push.variance * squares / (weights * weights * all_squares), 1.0);
    imageStore(target, stratum, sum);
}
