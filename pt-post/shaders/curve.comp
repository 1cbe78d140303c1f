// Noise-aware tone curve of the frame: Eilertsen, Mantiuk and Unger 2015, "Real-time noise-aware tone mapping", section 5.
// One workgroup, one thread a bin of log2 luminance.
//
// Slopes s of least contrast distortion, sum of p (1 - s)^2, under the display's range: sum of s * delta = range, s >= 0
// (eq. 9-12): s = 1 - (|W| - range / delta) / (p * sum of 1/p over W) on the set W where that is not negative; W is found
// by fixed-point iteration. Then blurred, so that the curve has no kinks, and summed up. Where noise is expected the curve
// goes on as a straight line. In log2 display luminance, 0 = white, at the lower edges of the bins.
#include "post_records.glsl"

layout(local_size_x = CURVE_BINS) in;
layout(push_constant, scalar) uniform Push { CurvePush push; };
layout(set = 2, binding = 0, scalar) readonly buffer distribution { float shares[CURVE_BINS]; };
layout(set = 2, binding = 1, scalar) readonly buffer exposure { ExposureRecord exposed; };
layout(set = 2, binding = 2, scalar) buffer curve { float values[CURVE_BINS + 1]; };

const uint ITERATIONS = 16u;
const int BLUR_RADIUS = 13;
// Share that an empty bin counts for: keeps 1/p finite and hands it the range that is left over.
const float EMPTY_SHARE = 1e-6;
// Bins above the noise at least, so that the display's range (up to 16 stops) is not stretched.
const uint MIN_BINS = 66u;

shared vec2 sums[CURVE_BINS]; // x: bins in W, y: sum of 1/p
shared float slopes[CURVE_BINS];

vec2 sum_of(vec2 term) {
    uint bin = gl_LocalInvocationIndex;
    barrier();
    sums[bin] = term;
    barrier();
    for (uint stride = CURVE_BINS / 2u; stride > 0u; stride /= 2u) {
        if (bin < stride) sums[bin] += sums[bin + stride];
        barrier();
    }
    return sums[0];
}

void main() {
    uint bin = gl_LocalInvocationIndex;
    float bins_of_range = push.range * float(CURVE_BINS_PER_OCTAVE);
    // Log2 of the luminance that the exposure takes for the average.
    float adapted = exposed.ev100 - log2(100.0 / 12.5);
    float noise_at = (adapted - push.noise_stops - float(MIN_LOG_LUMINANCE)) * float(CURVE_BINS_PER_OCTAVE);
    uint noise_bin = uint(clamp(noise_at + 0.5, 0.0, float(CURVE_BINS - MIN_BINS)));

    float p = (shares[bin] + EMPTY_SHARE) / (1.0 + EMPTY_SHARE * float(CURVE_BINS));
    bool candidate = bin >= noise_bin;
    bool inside = candidate;
    vec2 set = vec2(0.0);
    for (uint i = 0u; i < ITERATIONS; ++i) {
        set = sum_of(inside ? vec2(1.0, 1.0 / p) : vec2(0.0));
        inside = candidate && p * set.y >= set.x - bins_of_range;
    }
    set = sum_of(inside ? vec2(1.0, 1.0 / p) : vec2(0.0));
    slopes[bin] = inside ? max(1.0 - (set.x - bins_of_range) / (p * set.y), 0.0) : 0.0;
    barrier();

    float slope = slopes[bin];
    if (push.blur > 0.0) {
        vec2 blurred = vec2(0.0);
        for (int i = -BLUR_RADIUS; i <= BLUR_RADIUS; ++i) {
            float weight = exp(-0.5 * float(i * i) / (push.blur * push.blur));
            int at = int(bin) + i;
            // Outside of the bins that count the nearest one goes on.
            blurred += weight * vec2(slopes[clamp(at, int(noise_bin), int(CURVE_BINS) - 1)], 1.0);
        }
        slope = candidate ? blurred.x / blurred.y : 0.0;
    }
    float used = sum_of(vec2(slope, 0.0)).x;
    slopes[bin] = used > 0.0 ? slope / used * push.range : 0.0;
    barrier();
    // Inclusive prefix sum: the curve at the upper edge of the bin, above black.
    for (uint stride = 1u; stride < CURVE_BINS; stride *= 2u) {
        float below = bin >= stride ? slopes[bin - stride] : 0.0;
        barrier();
        slopes[bin] += below;
        barrier();
    }

    // The upper edge of this bin; the first thread does the lower edge of the first one too.
    float step = push.noise_slope / float(CURVE_BINS_PER_OCTAVE);
    float share = exposed.metered_ev100 > exposed.ev100 ? push.adapt_up : push.adapt_down;
    float value = bin >= noise_bin ? slopes[bin] - push.range : -push.range - step * float(noise_bin - bin - 1u);
    values[bin + 1u] = share >= 1.0 ? value : mix(values[bin + 1u], value, share);
    if (bin == 0u) {
        float first = -push.range - step * float(noise_bin);
        values[0] = share >= 1.0 ? first : mix(values[0], first, share);
    }
}
