// Luminance histogram of the flat frame. A group counts HISTOGRAM_SPAN x HISTOGRAM_SPAN times as many pixels as
// it has threads.
//
// The bins are the leading bits of the luminance's float representation: exponent and BIN_BITS of the mantissa, which is
// log2 made of straight pieces; the next STEP_BITS place the pixel within its bin. All integers, so that the order of the
// atomics can't show; 64 bits a sum, as low and high words, so that 16384 x 16384 pixels fit. Pixels that are not finite
// or have no luminance are not counted.
#include "math.glsl"
#include "post_records.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { HistogramPush push; };
layout(set = 2, binding = 0) uniform sampler2D radiance;
layout(set = 2, binding = 1, scalar) buffer histogram {
    uint counts[2 * HISTOGRAM_BINS]; // low words, then high words
    uint steps[2 * HISTOGRAM_BINS];
};

const uint STEPS = 1u << STEP_BITS;
const int SPAN = int(HISTOGRAM_SPAN);
// Weight in each step of each bin: a pixel is one addition, and pixels that are nearly alike rarely meet in one.
shared uint weights[STEPS * HISTOGRAM_BINS];

// The steps of a bin lie in different banks, as do the bins at one step.
uint slot(uint bin, uint step) { return step * HISTOGRAM_BINS + (bin + 2u * step) % HISTOGRAM_BINS; }

// Centre weighting: falls off linearly with the distance from the middle of the frame.
uint weight_of(ivec2 p, ivec2 size) {
    if (push.centre_weight == 0.0) return FULL_WEIGHT;
    vec2 uv = (vec2(p) + 0.5) / vec2(size);
    float centred = clamp(1.0 - 1.5 * length(uv - 0.5), 0.01, 1.0);
    return max(uint(mix(1.0, centred, push.centre_weight) * float(FULL_WEIGHT) + 0.5), 1u);
}

void count(vec3 c, ivec2 p, ivec2 size) {
    float y = luminance(c);
    // What is not finite in a channel is not in the sum; those and 0 and negative numbers lie beyond as bits.
    if (any(greaterThanEqual(p, size)) || floatBitsToUint(y) - 1u >= 0x7f7fffffu) return;
    int first = (127 + MIN_LOG_LUMINANCE) << (BIN_BITS + STEP_BITS);
    int last = int(HISTOGRAM_BINS << STEP_BITS) - 1;
    uint place = uint(clamp(int(floatBitsToUint(y) >> (23u - BIN_BITS - STEP_BITS)) - first, 0, last));
    atomicAdd(weights[slot(place >> STEP_BITS, place % STEPS)], weight_of(p, size));
}

vec3 fetch(ivec2 p, ivec2 size) { return texelFetch(radiance, min(p, size - 1), 0).rgb; }

void main() {
    // One thread a bin too: 16 * 16 = HISTOGRAM_BINS.
    uint bin = gl_LocalInvocationIndex;
    for (uint step = 0u; step < STEPS; ++step) weights[slot(bin, step)] = 0u;
    barrier();

    ivec2 size = textureSize(radiance, 0);
    ivec2 first = ivec2(gl_WorkGroupID.xy) * 16 * SPAN + ivec2(gl_LocalInvocationID.xy);
    // A row is on its way while the one before is counted.
    vec3 next[SPAN];
    for (int x = 0; x < SPAN; ++x) next[x] = fetch(first + 16 * ivec2(x, 0), size);
    for (int y = 0; y < SPAN; ++y) {
        vec3 c[SPAN] = next;
        if (y + 1 < SPAN) {
            for (int x = 0; x < SPAN; ++x) next[x] = fetch(first + 16 * ivec2(x, y + 1), size);
        }
        for (int x = 0; x < SPAN; ++x) count(c[x], first + 16 * ivec2(x, y), size);
    }
    barrier();

    uint weight = 0u;
    uint step_sum = 0u;
    for (uint step = 0u; step < STEPS; ++step) {
        uint w = weights[slot(bin, step)];
        weight += w;
        step_sum += w * step;
    }
    if (weight == 0u) return;
    // A sum that wrapped round is smaller than what it was.
    uint before = atomicAdd(counts[bin], weight);
    if (before + weight < before) atomicAdd(counts[HISTOGRAM_BINS + bin], 1u);
    before = atomicAdd(steps[bin], step_sum);
    if (before + step_sum < before) atomicAdd(steps[HISTOGRAM_BINS + bin], 1u);
}
