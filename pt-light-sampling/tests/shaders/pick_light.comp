// Picks of a light sampler at one shading point, or (family 1) the probability of each light.
#include "lights/light_sampler.glsl"
#include "clusters.glsl"
#include "test_records.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { SamplerPush push; };
layout(set = 2, binding = 0, scalar) writeonly buffer samples { SampleRecord sample_at[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    vec3 normal = normalize(vec3(0.1, 1.0, 0.2)), view = normalize(vec3(-0.3, 0.9, 0.4));
    LightContext c = LightContext(push.vector, normal, view, cluster_of(push.vector), push.parameter, 0.5, 0ul);
    float pmf;
    if (push.family == 1u) {
        LightSample s = sample_local_light(c, i, vec2(0.3));
        float mass = light_mass(c, local_light(i));
        sample_at[i] = SampleRecord(s.direction, light_pmf(c, i), s.radiance, mass, s.target, i);
        return;
    }
    uint by_power = pick_by_power(random4_bits(uvec2(i, 1u), push.family, push.seed));
    uint light = pick_light(c, random4_bits(uvec2(i, 0u), push.family, push.seed), by_power, pmf);
    float again = light == NONE ? 0.0 : light_pmf(c, light);
    sample_at[i] = SampleRecord(vec3(0.0), pmf, vec3(0.0), again, vec3(0.0), light);
}
