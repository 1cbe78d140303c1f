// One pixel of the direct lighting pass. For a candidate at direction l with density pdf, of unshadowed radiance L, the estimate of
// the reflected light is f(l) L cos / pdf (one-sample Monte Carlo), with the BRDF's parts kept apart: color_hf gets the diffuse
// part without the albedo, color_spec the rest divided by demodulation(). A kernel that includes this includes trace.glsl before.
#include "channels.glsl"
#include "lights_records.glsl"

layout(push_constant, scalar) uniform Push { DirectPush push; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer RayCountsOut { RayCounts rays; };
layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer ChoiceTable { uvec2 at[]; };
// Whether local lights have one candidate together.
layout(constant_id = 8) const bool merged_rays = true;

#include "lights/ris.glsl"
#include "pack.glsl"
#include "glass_shadow.glsl"
#include "shading_point.glsl"

void add(inout BrdfValue sum, BrdfValue f, vec3 light) {
    sum.diffuse += f.diffuse * light;
    sum.specular += f.specular * light;
}

// Adds a candidate's light; whether a shadow ray was traced and arrived. `weight`: of multiple importance sampling.
bool add_light(ShadingPoint s, LightSample light, float weight, uvec2 ray_coverage, inout BrdfValue sum, out bool traced) {
    traced = false;
    if (light.pdf <= 0.0 || weight <= 0.0 || max_component(light.radiance) <= 0.0) return false;
    BrdfValue f = reflected(s, light.direction);
    if (max_component(f.diffuse + f.specular) <= 0.0) return false;
    traced = true;
    Ray ray = shadow_ray(s.position, s.vertex_normal, light);
    if (trace_occluded(ray, unseen_mask(push.mask), ray_coverage)) return false;
    vec3 passed = vec3(1.0);
    if (scene_has(FEATURE_TRANSMISSION) && push.tinted_glass != 0u) passed = glass_shadow(ray, ray_coverage);
    add(sum, f, passed * light.radiance * (weight / light.pdf));
    return true;
}

// Power heuristic, Veach 1997, section 9.2.2.
float power_weight(float pdf, float other) { return pdf > 0.0 ? 1.0 / (1.0 + square(other / pdf)) : 0.0; }

// The candidates in order: one of each kind of light, and a direction that the surface reflects to the environment. Local lights are those
// of the two kinds before, as one.
const uint CANDIDATE_SUN = 0u, CANDIDATE_POSITIONAL = 1u, CANDIDATE_EMISSIVE = 2u, CANDIDATE_LOCAL = 3u, CANDIDATE_ENVIRONMENT = 4u,
           CANDIDATE_REFLECTION = 5u;
const uint CANDIDATES = 6u;
const uint CANDIDATE_KINDS[CANDIDATES] =
    uint[](KIND_SUN, KIND_POSITIONAL, KIND_EMISSIVE, KIND_LOCAL, KIND_ENVIRONMENT, KIND_ENVIRONMENT);
const uint CANDIDATE_DIMENSIONS[CANDIDATES] =
    uint[](DIM_SUN, DIM_POSITIONAL, DIM_EMISSIVE, DIM_LIGHT, DIM_ENVIRONMENT, DIM_REFLECTION);

// A sample of one local light, `light`, by the kernel's sampler.
#ifdef RESTIR
// What restir_spatial has kept; it stands for all light samples of the pixel, and is given to the first.
LightSample local_candidate(LightContext c, ivec2 p, uint light_sample, uvec2 key, uvec4 bits, out uint light) {
    light = NONE;
    if (light_sample > 0u) return NO_LIGHT_SAMPLE;
    Reservoir r = make_reservoir(imageLoad(im_restir_point, p).xy, imageLoad(im_restir_weight, p).xy);
    if (r.weight <= 0.0 || !is_local_light(r.light, push.kinds)) return NO_LIGHT_SAMPLE;
    light = r.light;
    LightSample s = sample_local_light(c, light, unit_numbers(r.numbers));
    s.pdf /= r.weight * float(push.samples);
    return s;
}

// A hidden sample is worth nothing to the next frame.
void drop_hidden(ivec2 p) {
    uint count = imageLoad(im_restir_history_weight, p).y;
    imageStore(im_restir_history_weight, p, uvec4(0u, count, 0u, 0u));
}
#else
LightSample local_candidate(LightContext c, ivec2 p, uint light_sample, uvec2 key, uvec4 bits, out uint light) {
    vec4 xi = unit_from_bits(bits);
    LightSample s = NO_LIGHT_SAMPLE;
    if (light_sampler == LIGHT_SAMPLER_RIS) {
        s = ris_sample(c, key, xi.x, push.ris_source, push.ris_candidates, push.ris_stratified != 0u, light);
    } else if (light_sampler == LIGHT_SAMPLER_NEE_AT && push.nee_at_candidates > 1u) {
        s = ris_sample(c, key, xi.x, RIS_SOURCE_POWER, push.nee_at_candidates, true, light);
    } else {
        float pmf;
        light = pick_light(c, bits, pick_by_power(random_bits(key, DIM_LIGHT_BY_POWER)), pmf);
        if (light != NONE) s = sample_local_light(c, light, xi.zw);
        s.pdf *= pmf;
    }
    bool on = light != NONE && (push.kinds & (light < scene.emissive_count ? KIND_EMISSIVE : KIND_POSITIONAL)) != 0u;
    return on ? s : NO_LIGHT_SAMPLE;
}
#endif

LightSample candidate_light(ShadingPoint s, LightContext c, ivec2 p, uint light_sample, uint candidate, uvec2 key, out uint local) {
    uvec4 bits = random_bits(key, CANDIDATE_DIMENSIONS[candidate]);
    LightSample light = NO_LIGHT_SAMPLE;
    local = NONE;
    switch (candidate) {
    case CANDIDATE_SUN: light = sample_sun(bits); break;
    case CANDIDATE_POSITIONAL: if (!merged_rays) light = sample_positional(s.position, bits); break;
    case CANDIDATE_EMISSIVE: if (!merged_rays) light = sample_emissive(s.position, bits); break;
    case CANDIDATE_LOCAL: if (merged_rays) light = local_candidate(c, p, light_sample, key, bits, local); break;
    case CANDIDATE_ENVIRONMENT: light = sample_environment(bits); break;
    // Narrow lobes do not find the environment by chance: this ray goes where the surface reflects.
    case CANDIDATE_REFLECTION:
        light.direction = sample_reflected(s, unit_from_bits(bits));
        light.radiance = environment_radiance(light.direction);
        break;
    }
    return light;
}

LightContext light_context(ShadingPoint s, ivec2 p) {
    float f0 = luminance(s.brdf.f0);
    float specular = clamp(f0 / max(f0 + luminance(s.brdf.albedo), 1e-6), 0.0, 0.9);
    return LightContext(s.position, s.world_from_local[2], s.world_from_local * s.view, imageLoad(ch_cluster, p).x, s.roughness, specular,
                        nee_at_tile(push.nee_at_tiles, p, imageSize(ch_color_hf)));
}

void direct_lighting(ivec2 p) {
    BrdfValue sum = BrdfValue(vec3(0.0), vec3(0.0));
    vec4 position = imageLoad(ch_shading_position, p);
    if (floatBitsToUint(position.w) == 0u) {
        imageStore(ch_color_hf, p, vec4(0.0));
        imageStore(ch_color_spec, p, vec4(0.0));
        if (light_sampler == LIGHT_SAMPLER_NEE_AT) keep_feedback(push.nee_at_feedback, p, imageSize(ch_color_hf), NO_FEEDBACK);
        return;
    }
    ShadingPoint s = load_shading_point(p, position);
    LightContext context = light_context(s, p);
    uvec2 seed = imageLoad(ch_rng_seed, p).xy;
    begin_choices(seed, frame.frame_index);
    bool reflects = (push.kinds & KIND_ENVIRONMENT) != 0u && scene.environment_intensity > 0.0 && s.roughness <= push.reflection_roughness;
    uint candidates = reflects ? CANDIDATES : CANDIDATES - 1u;
    uvec2 rays = uvec2(0u), choice = uvec2(NONE, 0u);
    LightFeedback feedback = NO_FEEDBACK;
    // One loop over samples and candidates, so that the kernel has the BRDF and the traversal once.
    for (uint i = 0u; i < push.samples * candidates; i++) {
        uint candidate = i % candidates;
        bool merged = merged_rays && (candidate == CANDIDATE_POSITIONAL || candidate == CANDIDATE_EMISSIVE);
        if ((push.kinds & CANDIDATE_KINDS[candidate]) == 0u || merged) continue;
        uvec2 key = uvec2(seed.x, seed.y * push.samples + i / candidates);
        uint local;
        LightSample light = candidate_light(s, context, p, i / candidates, candidate, key, local);
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
        BrdfValue before = sum;
        bool traced;
        bool arrived = add_light(s, light, weight, random_coverage(key, CANDIDATE_DIMENSIONS[candidate]), sum, traced);
        if (light_sampler == LIGHT_SAMPLER_CLUSTER_STATS && traced && local != NONE) {
            count_shadow_ray(context.cluster, local, context.normal, arrived);
        }
        if (light_sampler == LIGHT_SAMPLER_NEE_AT && arrived && local != NONE) {
            vec3 arrival = (sum.diffuse - before.diffuse) * s.brdf.albedo + (sum.specular - before.specular);
            insert_feedback(feedback, local, luminance(arrival), random_numbers(key, DIM_NEE_AT_FEEDBACK).x);
        }
        if (traced) rays += uvec2(1u, arrived ? 1u : 0u);
        if (local != NONE) choice = uvec2(local, pcg4d(uvec4(floatBitsToUint(light.target), local)).x);
#ifdef RESTIR
        if (push.restir_visibility == RESTIR_VISIBILITY_FINAL && traced && !arrived && local != NONE) drop_hidden(p);
#endif
    }
    if (light_sampler == LIGHT_SAMPLER_NEE_AT) keep_feedback(push.nee_at_feedback, p, imageSize(ch_color_hf), feedback);
    if (push.counts != 0ul) {
        atomicAdd(RayCountsOut(push.counts).rays.traced, rays.x);
        atomicAdd(RayCountsOut(push.counts).rays.arrived, rays.y);
    }
    if (push.choices != 0ul) ChoiceTable(push.choices).at[p.y * imageSize(ch_color_hf).x + p.x] = choice;
    float share = 1.0 / float(push.samples);
    vec4 base = imageLoad(ch_base_color, p);
    imageStore(ch_color_hf, p, vec4(sum.diffuse * share, 0.0));
    vec3 specular = sum.specular * (share / demodulation(base, imageLoad(ch_metallic_roughness, p).x));
    imageStore(ch_color_spec, p, vec4(specular, 0.0));
}
