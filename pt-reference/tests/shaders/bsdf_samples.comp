// Histogram of many samples of one surface over the chart, further bins for what is no direction of a density (see the end), and the
// sum of the weights of each thread.
#include "bsdf_case.glsl"
#include "rng.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { HistogramPush push; };
layout(set = 2, binding = 1, scalar) buffer histogram { uint count_at[]; };
layout(set = 2, binding = 2, scalar) writeonly buffer sums { vec4 sum_at[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    BsdfCase c = case_at[push.index];
    Bsdf b = test_bsdf(c);
    vec3 sum = vec3(0.0);
    float worst = 0.0; // relative difference of weight and f cos / pdf
    for (uint k = 0u; k < push.per_thread; k++) {
        BsdfSample s = bsdf_sample(b, random4(uvec2(i, k), 0u, push.seed));
        uint bin = push.bins * push.bins;
        if (s.pdf > 0.0 && (s.flags & SAMPLE_DELTA) == 0u) {
            uvec2 cell = min(uvec2(chart(push.axis, push.width, s.direction) * float(push.bins)), uvec2(push.bins - 1u));
            bin = cell.y * push.bins + cell.x;
            vec3 f_cos = bsdf_eval(b, s.direction);
            vec3 again = f_cos / max(bsdf_pdf(b, s.direction), 1e-20);
            worst = max(worst, max_component(abs(again - s.weight)) / max(max_component(s.weight), 1e-3));
        } else if (s.pdf > 0.0) {
            bin += (s.flags & SAMPLE_TRANSMISSION) != 0u ? 2u : 1u;
        }
        atomicAdd(count_at[bin], 1u);
        sum += s.weight;
    }
    sum_at[i] = vec4(sum, worst);
}
