// Picks of a light sampler at one shading point, or (family 1) the probability of each light; or (family 2) the weights of lights, by turns, from
// points about push.vector or near the plane of the light: from the candidate, and from the full record.
#include "lights/light_sampler.glsl"
#include "clusters.glsl"
#include "test_records.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { SamplerPush push; };
layout(set = 2, binding = 0, scalar) writeonly buffer samples { SampleRecord sample_at[]; };

void weigh(uint i) {
    uint light = i % scene.light_tables.local_light_count;
    vec4 a = unit_from_bits(random4_bits(uvec2(i, 2u), 2u, push.seed)), b = unit_from_bits(random4_bits(uvec2(i, 3u), 2u, push.seed));
    LocalLightRecord l = local_light(light);
    vec3 position = push.vector + (2.0 * a.xyz - 1.0) * 3.0;
    if ((l.kind & LOCAL_KIND) == LOCAL_TRIANGLE && (i / scene.light_tables.local_light_count & 1u) != 0u) {
        vec2 at = (2.0 * a.xy - 1.0) * pow(100.0, a.z);
        vec3 aside = at.x * l.edge1 + at.y * l.edge2;
        position = l.position + aside + (2.0 * a.w - 1.0) * 0.02 * length(aside) * normalize(cross(l.edge1, l.edge2));
    }
    vec3 normal = normalize(2.0 * b.xyz - 1.0);
    LightContext c = LightContext(position, normal, normal, 0u, push.parameter, 0.0, 0ul);
    sample_at[i] = SampleRecord(position, candidate_mass(c, light), normal, light_mass(c, l), vec3(0.0), light);
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    if (push.family == 2u) {
        weigh(i);
        return;
    }
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
