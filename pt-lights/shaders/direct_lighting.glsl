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

// The candidates in order: one of each kind of light, and a direction that the surface reflects to the environment.
const uint CANDIDATE_SUN = 0u, CANDIDATE_POSITIONAL = 1u, CANDIDATE_EMISSIVE = 2u, CANDIDATE_ENVIRONMENT = 3u, CANDIDATE_REFLECTION = 4u;
const uint CANDIDATES = 5u;

// Dimension of a candidate's random numbers.
uint candidate_dimension(uint candidate) { return candidate == CANDIDATE_REFLECTION ? DIM_REFLECTION : DIM_SUN + candidate; }

LightSample candidate_light(ShadingPoint s, uint candidate, uvec2 key) {
    uvec4 bits = random_bits(key, candidate_dimension(candidate));
    LightSample light = NO_LIGHT_SAMPLE;
    switch (candidate) {
    case CANDIDATE_SUN: if ((push.kinds & KIND_SUN) != 0u) light = sample_sun(bits); break;
    case CANDIDATE_POSITIONAL: if ((push.kinds & KIND_POSITIONAL) != 0u) light = sample_positional(s.position, bits); break;
    case CANDIDATE_EMISSIVE: if ((push.kinds & KIND_EMISSIVE) != 0u) light = sample_emissive(s.position, bits); break;
    case CANDIDATE_ENVIRONMENT: if ((push.kinds & KIND_ENVIRONMENT) != 0u) light = sample_environment(bits); break;
    // Narrow lobes do not find the environment by chance: this ray goes where the surface reflects.
    case CANDIDATE_REFLECTION:
        light.direction = sample_reflected(s, unit_from_bits(bits));
        light.radiance = environment_radiance(light.direction);
        break;
    }
    return light;
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
    bool reflects = (push.kinds & KIND_ENVIRONMENT) != 0u && scene.environment_intensity > 0.0 && s.roughness <= push.reflection_roughness;
    // A loop, so that the kernel has the BRDF and the traversal once.
    for (uint candidate = 0u; candidate < (reflects ? CANDIDATES : CANDIDATES - 1u); candidate++) {
        LightSample light = candidate_light(s, candidate, key);
        float weight = 1.0;
        if (reflects && candidate >= CANDIDATE_ENVIRONMENT) {
            // Multiple importance sampling of the environment and of what the surface reflects.
            float pdf = reflected_pdf(s, light.direction);
            if (candidate == CANDIDATE_REFLECTION) {
                light.pdf = pdf;
                weight = power_weight(pdf, environment_pdf(light.direction));
            } else {
                weight = power_weight(light.pdf, pdf);
            }
        }
        add_light(s, light, weight, random_coverage(key, candidate_dimension(candidate)), sum);
    }
    vec4 base = imageLoad(ch_base_color, p);
    imageStore(ch_color_hf, p, vec4(sum.diffuse, 0.0));
    imageStore(ch_color_spec, p, vec4(sum.specular / demodulation(base, imageLoad(ch_metallic_roughness, p).x), 0.0));
}
