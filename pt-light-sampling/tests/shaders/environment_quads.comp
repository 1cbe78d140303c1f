// Quads of the environment as local lights. Families: 0, directions of quad i modulo their number; 1, the middle of each cell, its light and
// its density; 2, picks of the light sampler with a sample each; 3, the records of the quads.
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
    uvec4 bits = random4_bits(uvec2(i, 0u), push.family, push.seed);
    LightSample s = NO_LIGHT_SAMPLE;
    float again = 0.0;
    uint light = NONE;
    switch (push.family) {
    case 0u:
        s = sample_local_light(c, first_environment_light() + i % scene.environment_quad_count, unit_from_bits(bits).zw);
        again = environment_quad_pdf(s.direction, light);
        break;
    case 1u:
        uvec2 grid = scene.environment_grid;
        s.direction = environment_cell_direction(grid, uvec2(i % grid.x, i / grid.x), scene.environment_rotation, vec2(0.5));
        s.radiance = environment_radiance(s.direction);
        s.pdf = listed_environment_pdf(c, s.direction);
        light = light_of_direction(s.direction);
        again = light == NONE ? 0.0 : light_pmf(c, light);
        break;
    case 2u:
        float pmf;
        light = pick_light(c, bits, pick_by_power(random4_bits(uvec2(i, 1u), push.family, push.seed)), pmf);
        if (light == NONE) break;
        s = sample_local_light(c, light, unit_from_bits(bits).zw);
        s.pdf *= pmf;
        again = listed_environment_pdf(c, s.direction);
        break;
    case 3u:
        LocalLightRecord l = local_light(first_environment_light() + i);
        s.direction = l.position;
        s.pdf = l.luminance;
        s.radiance = l.edge1;
        s.target = l.edge2;
        light = l.kind;
        break;
    }
    sample_at[i] = SampleRecord(s.direction, s.pdf, s.radiance, again, s.target, light);
}
