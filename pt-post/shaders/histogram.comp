// Luminance histogram of the flat frame, one thread a pixel.
//
// The bins are the leading bits of the luminance's float representation: exponent and BIN_BITS of the mantissa, which is
// log2 made of straight pieces; the next STEP_BITS place the pixel within its bin. All integers, so that the order of the
// atomics can't show. Pixels that are not finite or have no luminance are not counted.
#include "finite.glsl"
#include "math.glsl"
#include "post_records.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 2, binding = 0, rgba32f) uniform readonly image2D radiance;
layout(set = 2, binding = 1, scalar) buffer histogram {
    uint counts[HISTOGRAM_BINS];
    uint steps[HISTOGRAM_BINS];
};

shared uint group_counts[HISTOGRAM_BINS];
shared uint group_steps[HISTOGRAM_BINS];

void main() {
    // One thread a bin too: 16 * 16 = HISTOGRAM_BINS.
    uint bin = gl_LocalInvocationIndex;
    group_counts[bin] = 0u;
    group_steps[bin] = 0u;
    barrier();

    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(p, imageSize(radiance)))) {
        vec3 c = imageLoad(radiance, p).rgb;
        float y = luminance(c);
        if (is_finite(c) && is_finite(y) && y > 0.0) {
            int first = (127 + MIN_LOG_LUMINANCE) << (BIN_BITS + STEP_BITS);
            int last = int(HISTOGRAM_BINS << STEP_BITS) - 1;
            uint place = uint(clamp(int(floatBitsToUint(y) >> (23u - BIN_BITS - STEP_BITS)) - first, 0, last));
            atomicAdd(group_counts[place >> STEP_BITS], 1u);
            atomicAdd(group_steps[place >> STEP_BITS], place & ((1u << STEP_BITS) - 1u));
        }
    }
    barrier();
    if (group_counts[bin] != 0u) {
        atomicAdd(counts[bin], group_counts[bin]);
        atomicAdd(steps[bin], group_steps[bin]);
    }
}
