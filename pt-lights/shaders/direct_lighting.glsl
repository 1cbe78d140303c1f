// One pixel of the direct lighting pass. For a candidate at direction l with density pdf, of unshadowed radiance L, the estimate of
// the reflected light is f(l) L cos / pdf (one-sample Monte Carlo), with the BRDF's parts kept apart: color_hf gets the diffuse
// part without the albedo, color_spec the rest divided by demodulation(). A kernel that includes this includes trace.glsl before.
#include "channels.glsl"
#include "lights_records.glsl"

layout(push_constant, scalar) uniform Push { DirectPush push; };

#include "lights.glsl"
#include "pack.glsl"
#include "random.glsl"
#include "glass_shadow.glsl"
#include "shading_point.glsl"

void add(inout BrdfValue sum, BrdfValue f, vec3 light) {
    sum.diffuse += f.diffuse * light;
    sum.specular += f.specular * light;
}

// Adds a candidate's light. `weight`: of multiple importance sampling.
void add_light(ShadingPoint s, LightSample light, float weight, uvec2 ray_coverage, inout BrdfValue sum) {
    if (light.pdf <= 0.0 || weight <= 0.0 || max_component(light.radiance) <= 0.0) return;
    BrdfValue f = reflected(s, light.direction);
    if (max_component(f.diffuse + f.specular) <= 0.0) return;
    Ray ray = shadow_ray(s.position, s.vertex_normal, light);
    if (trace_occluded(ray, unseen_mask(push.mask), ray_coverage)) return;
    vec3 passed = vec3(1.0);
    if (scene_has(FEATURE_TRANSMISSION) && push.tinted_glass != 0u) passed = glass_shadow(ray, ray_coverage);
    add(sum, f, passed * light.radiance * (weight / light.pdf));
}

// Power heuristic, Veach 1997, section 9.2.2.
float power_weight(float pdf, float other) { return pdf > 0.0 ? 1.0 / (1.0 + square(other / pdf)) : 0.0; }

// Narrow lobes do not find the environment by chance: a second ray goes where the BRDF reflects.
void add_environment(ShadingPoint s, uvec2 key, inout BrdfValue sum) {
    LightSample light = sample_environment(random_bits(key, DIM_ENVIRONMENT));
    bool second = s.roughness <= push.reflection_roughness && scene.environment_intensity > 0.0;
    float weight = second ? power_weight(light.pdf, reflected_pdf(s, light.direction)) : 1.0;
    add_light(s, light, weight, random_coverage(key, DIM_ENVIRONMENT), sum);
    if (!second) return;
    vec3 direction = sample_reflected(s, random_numbers(key, DIM_REFLECTION));
    float pdf = reflected_pdf(s, direction);
    if (pdf <= 0.0) return;
    light = NO_LIGHT_SAMPLE;
    light.direction = direction;
    light.radiance = environment_radiance(direction);
    light.pdf = pdf;
    add_light(s, light, power_weight(pdf, environment_pdf(direction)), random_coverage(key, DIM_REFLECTION), sum);
}

void direct_lighting(ivec2 p) {
    BrdfValue sum = BrdfValue(vec3(0.0), vec3(0.0));
    vec4 position = imageLoad(ch_shading_position, p);
    if (floatBitsToUint(position.w) == 0u) {
        imageStore(ch_color_hf, p, vec4(0.0));
        imageStore(ch_color_spec, p, vec4(0.0));
        return;
    }
    ShadingPoint s = load_shading_point(p, position);
    uvec2 key = imageLoad(ch_rng_seed, p).xy;
    if ((push.kinds & KIND_SUN) != 0u) {
        add_light(s, sample_sun(random_bits(key, DIM_SUN)), 1.0, random_coverage(key, DIM_SUN), sum);
    }
    if ((push.kinds & KIND_POSITIONAL) != 0u) {
        LightSample light = sample_positional(s.position, random_bits(key, DIM_POSITIONAL));
        add_light(s, light, 1.0, random_coverage(key, DIM_POSITIONAL), sum);
    }
    if ((push.kinds & KIND_EMISSIVE) != 0u) {
        LightSample light = sample_emissive(s.position, random_bits(key, DIM_EMISSIVE));
        add_light(s, light, 1.0, random_coverage(key, DIM_EMISSIVE), sum);
    }
    if ((push.kinds & KIND_ENVIRONMENT) != 0u) add_environment(s, key, sum);
    vec4 base = imageLoad(ch_base_color, p);
    imageStore(ch_color_hf, p, vec4(sum.diffuse, 0.0));
    imageStore(ch_color_spec, p, vec4(sum.specular / demodulation(base, imageLoad(ch_metallic_roughness, p).x), 0.0));
}
