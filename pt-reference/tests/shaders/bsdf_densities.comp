// Integral of the density over each bin of the chart by midpoints, one thread a row of midpoints of a bin; and of the value.
#include "bsdf_case.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { HistogramPush push; };
layout(set = 2, binding = 1, scalar) writeonly buffer integrals { vec4 integral_at[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    BsdfCase c = case_at[push.index];
    Bsdf b = test_bsdf(c);
    uint bin = i / push.per_thread, row = i % push.per_thread;
    uvec2 cell = uvec2(bin % push.bins, bin / push.bins);
    float step = 1.0 / float(push.bins * push.per_thread);
    vec4 sum = vec4(0.0);
    for (uint k = 0u; k < push.per_thread; k++) {
        vec2 p = (vec2(cell * push.per_thread + uvec2(k, row)) + 0.5) * step;
        vec4 direction = chart_direction(push.axis, push.width, p);
        BsdfValue value = bsdf_evaluate(b, direction.xyz);
        sum += vec4(value.f_cos, value.pdf) * direction.w;
    }
    integral_at[i] = sum * (step * step);
}
