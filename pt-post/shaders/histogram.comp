// Luminance histogram of the flat frame, one thread a pixel.
//
// The bins are the leading bits of the luminance's float representation: exponent and BIN_BITS of the mantissa, which is
// log2 made of straight pieces; the next STEP_BITS place the pixel within its bin. All integers, so that the order of the
// atomics can't show; 64 bits a sum, as low and high words, so that 16384 x 16384 pixels fit. Pixels that are not finite
// or have no luminance are not counted.
#include "finite.glsl"
#include "math.glsl"
#include "post_records.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { HistogramPush push; };
layout(set = 2, binding = 0) uniform sampler2D radiance;
layout(set = 2, binding = 1, scalar) buffer histogram {
    uint counts[2 * HISTOGRAM_BINS]; // low words, then high words
    uint steps[2 * HISTOGRAM_BINS];
};

shared uint group_counts[HISTOGRAM_BINS];
shared uint group_steps[HISTOGRAM_BINS];

// Centre weighting: falls off linearly with the distance from the middle of the frame.
uint weight_of(ivec2 p, ivec2 size) {
    vec2 uv = (vec2(p) + 0.5) / vec2(size);
    float centred = clamp(1.0 - 1.5 * length(uv - 0.5), 0.01, 1.0);
    return max(uint(mix(1.0, centred, push.centre_weight) * float(FULL_WEIGHT) + 0.5), 1u);
}

void main() {
    // One thread a bin too: 16 * 16 = HISTOGRAM_BINS.
    uint bin = gl_LocalInvocationIndex;
    group_counts[bin] = 0u;
    group_steps[bin] = 0u;
    barrier();

    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = textureSize(radiance, 0);
    if (all(lessThan(p, size))) {
        vec3 c = texelFetch(radiance, p, 0).rgb;
        float y = luminance(c);
        if (is_finite(c) && is_finite(y) && y > 0.0) {
            int first = (127 + MIN_LOG_LUMINANCE) << (BIN_BITS + STEP_BITS);
            int last = int(HISTOGRAM_BINS << STEP_BITS) - 1;
            uint place = uint(clamp(int(floatBitsToUint(y) >> (23u - BIN_BITS - STEP_BITS)) - first, 0, last));
            uint weight = weight_of(p, size);
            atomicAdd(group_counts[place >> STEP_BITS], weight);
            atomicAdd(group_steps[place >> STEP_BITS], weight * (place & ((1u << STEP_BITS) - 1u)));
        }
    }
    barrier();
    if (group_counts[bin] != 0u) {
        // A sum that wrapped round is smaller than what it was.
        uint before = atomicAdd(counts[bin], group_counts[bin]);
        if (before + group_counts[bin] < before) atomicAdd(counts[HISTOGRAM_BINS + bin], 1u);
        before = atomicAdd(steps[bin], group_steps[bin]);
        if (before + group_steps[bin] < before) atomicAdd(steps[HISTOGRAM_BINS + bin], 1u);
    }
}
