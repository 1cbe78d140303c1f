// Running mean of the flat frames so far: mean += (x - mean) / n.
//
// In plain fp32 the correction vanishes beside the mean once n is large, so that small deviations are dropped and large
// ones kept: the mean drifts. What rounding drops is therefore kept in a second image (Knuth's two-sum; Neumaier 1974) and
// mean + residual is updated instead: about 48 bits. A frame's non-finite pixel is left out of that pixel's mean.
#include "channels.glsl"
#include "finite.glsl"
#include "post_images.glsl"
#include "post_records.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { AccumulatePush push; };

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(ch_accumulated)))) return;

    vec3 mean = vec3(0.0);
    vec3 rest = vec3(0.0);
    float count = 0.0;
    if (push.reset == 0u) {
        vec4 old = imageLoad(ch_accumulated, p);
        mean = old.rgb;
        count = old.a;
        rest = imageLoad(im_accumulate_residual, p).rgb;
    }
    vec3 x = imageLoad(ch_flat_color, p).rgb;
    if (is_finite(x)) {
        count += 1.0;
        // `precise`: the error terms below are zero in real arithmetic.
        precise vec3 change = ((x - mean) - rest) / count + rest;
        precise vec3 sum = mean + change;
        precise vec3 taken = sum - mean;
        precise vec3 error = (mean - (sum - taken)) + (change - taken);
        mean = sum;
        rest = error;
    }
    imageStore(ch_accumulated, p, vec4(mean, count));
    imageStore(im_accumulate_residual, p, vec4(rest, 0.0));
}
