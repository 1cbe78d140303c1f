// Automatic exposure: mean log luminance between two percentiles of the histogram, and the eye's adaptation to it. One
// workgroup, one thread a bin.
//
// EV100 = log2(L * 100 / 12.5) (reflected-light meter, ISO 2720), saturating luminance = 1.2 * 2^EV100 (Lagarde and
// de Rousiers 2014, "Moving Frostbite to PBR", section 5.1). Empties the histogram for the next frame, and leaves the
// shares of the bins for the noise-aware curve.
#include "post_records.glsl"

layout(local_size_x = HISTOGRAM_BINS) in;
layout(push_constant, scalar) uniform Push { MeterPush push; };
layout(set = 2, binding = 0, scalar) buffer histogram {
    uint counts[2 * HISTOGRAM_BINS];
    uint steps[2 * HISTOGRAM_BINS];
};
layout(set = 2, binding = 1, scalar) buffer exposure { ExposureRecord result; };
layout(set = 2, binding = 2, scalar) buffer distribution { float shares[CURVE_BINS]; };

shared float cumulative[HISTOGRAM_BINS];
shared vec2 sums[HISTOGRAM_BINS]; // x: weight, y: weight x log2 luminance

float wide(uint low, uint high) { return float(high) * 4294967296.0 + float(low); }

// Log2 luminance of the mean place of a bin's pixels.
float log_luminance(uint bin, float count, float step_sum) {
    float place = (step_sum / count + 0.5) / float(1u << STEP_BITS);
    uint bins_per_octave = 1u << BIN_BITS;
    float mantissa = 1.0 + (float(bin % bins_per_octave) + place) / float(bins_per_octave);
    return float(MIN_LOG_LUMINANCE) + float(bin / bins_per_octave) + log2(mantissa);
}

void main() {
    uint bin = gl_LocalInvocationIndex;
    float count = wide(counts[bin], counts[HISTOGRAM_BINS + bin]);
    float step_sum = wide(steps[bin], steps[HISTOGRAM_BINS + bin]);
    cumulative[bin] = count;
    barrier();
    // Inclusive prefix sum (Hillis and Steele 1986).
    for (uint stride = 1u; stride < HISTOGRAM_BINS; stride *= 2u) {
        float below = bin >= stride ? cumulative[bin - stride] : 0.0;
        barrier();
        cumulative[bin] += below;
        barrier();
    }
    float total = cumulative[HISTOGRAM_BINS - 1u];

    float end = cumulative[bin];
    float begin = end - count;
    float inside = max(min(end, push.high * total) - max(begin, push.low * total), 0.0);
    sums[bin] = inside > 0.0 ? inside * vec2(1.0, log_luminance(bin, count, step_sum)) : vec2(0.0);
    barrier();
    for (uint stride = HISTOGRAM_BINS / 2u; stride > 0u; stride /= 2u) {
        if (bin < stride) sums[bin] += sums[bin + stride];
        barrier();
    }
    uint group = HISTOGRAM_BINS / CURVE_BINS;
    if (bin % group == 0u) {
        float pixels = cumulative[bin + group - 1u] - (bin == 0u ? 0.0 : cumulative[bin - 1u]);
        shares[bin / group] = total > 0.0 ? pixels / total : 0.0;
    }
    counts[bin] = 0u;
    steps[bin] = 0u;
    counts[HISTOGRAM_BINS + bin] = 0u;
    steps[HISTOGRAM_BINS + bin] = 0u;

    if (bin == 0u) {
        float target = push.fallback_ev100;
        if (sums[0].x > 0.0) {
            float metered = sums[0].y / sums[0].x + log2(100.0 / 12.5);
            target = clamp(metered - push.bias, push.min_ev100, push.max_ev100);
        }
        float ev100 = push.fallback_ev100;
        if (push.manual == 0u) {
            float share = target > result.ev100 ? push.adapt_up : push.adapt_down;
            // The whole way at once: what was there before may be anything.
            ev100 = share >= 1.0 ? target : mix(result.ev100, target, share);
        }
        result = ExposureRecord(ev100, exp2(push.compensation - ev100) / 1.2, target, total / float(FULL_WEIGHT));
    }
}
