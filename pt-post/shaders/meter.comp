// Automatic exposure: mean log luminance between two percentiles of the histogram, one workgroup, one thread a bin.
//
// EV100 = log2(L * 100 / 12.5) (reflected-light meter, ISO 2720), saturating luminance = 1.2 * 2^EV100 (Lagarde and
// de Rousiers 2014, "Moving Frostbite to PBR", section 5.1). Empties the histogram for the next frame.
#include "post_records.glsl"

layout(local_size_x = HISTOGRAM_BINS) in;
layout(push_constant, scalar) uniform Push { MeterPush push; };
layout(set = 2, binding = 0, scalar) buffer histogram {
    uint counts[HISTOGRAM_BINS];
    uint steps[HISTOGRAM_BINS];
};
layout(set = 2, binding = 1, scalar) buffer exposure { ExposureRecord result; };

shared uint cumulative[HISTOGRAM_BINS];
shared vec2 sums[HISTOGRAM_BINS]; // x: pixels, y: pixels x log2 luminance

// Log2 luminance of the mean place of a bin's pixels.
float log_luminance(uint bin, uint count, uint step_sum) {
    float place = (float(step_sum) / float(count) + 0.5) / float(1u << STEP_BITS);
    uint bins_per_octave = 1u << BIN_BITS;
    float mantissa = 1.0 + (float(bin % bins_per_octave) + place) / float(bins_per_octave);
    return float(MIN_LOG_LUMINANCE) + float(bin / bins_per_octave) + log2(mantissa);
}

void main() {
    uint bin = gl_LocalInvocationIndex;
    uint count = counts[bin];
    cumulative[bin] = count;
    barrier();
    // Inclusive prefix sum (Hillis and Steele 1986).
    for (uint stride = 1u; stride < HISTOGRAM_BINS; stride *= 2u) {
        uint below = bin >= stride ? cumulative[bin - stride] : 0u;
        barrier();
        cumulative[bin] += below;
        barrier();
    }
    uint total = cumulative[HISTOGRAM_BINS - 1u];

    float end = float(cumulative[bin]);
    float begin = float(cumulative[bin] - count);
    float inside = max(min(end, push.high * float(total)) - max(begin, push.low * float(total)), 0.0);
    sums[bin] = inside > 0.0 ? inside * vec2(1.0, log_luminance(bin, count, steps[bin])) : vec2(0.0);
    barrier();
    for (uint stride = HISTOGRAM_BINS / 2u; stride > 0u; stride /= 2u) {
        if (bin < stride) sums[bin] += sums[bin + stride];
        barrier();
    }
    counts[bin] = 0u;
    steps[bin] = 0u;

    if (bin == 0u) {
        float ev100 = push.fallback_ev100;
        if (sums[0].x > 0.0) {
            float metered = sums[0].y / sums[0].x + log2(100.0 / 12.5);
            ev100 = clamp(metered - push.bias, push.min_ev100, push.max_ev100);
        }
        result = ExposureRecord(ev100, exp2(push.compensation - ev100) / 1.2, total);
    }
}
