// Picks from the proxies of one tile, or (family 1) the probability of each light.
#include "lights/light_sampler.glsl"
#include "test_records.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { NeeAtPicksPush push; };
layout(set = 2, binding = 0, scalar) writeonly buffer samples { SampleRecord sample_at[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    LightContext c = LightContext(vec3(0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 1.0, 0.0), 0u, 1.0, 0.0, push.tile);
    uint light = i;
    float pmf = light_pmf(c, i);
    if (push.family == 0u) {
        uint by_power = pick_by_power(random4_bits(uvec2(i, 1u), 0u, 5u));
        light = pick_light(c, random4_bits(uvec2(i, 0u), 0u, 5u), by_power, pmf);
    }
    sample_at[i] = SampleRecord(vec3(0.0), pmf, vec3(0.0), light_pmf(c, light), vec3(0.0), light);
}
