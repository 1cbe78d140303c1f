// One texel of "choose lights": the candidates of a light sample. For a candidate at direction l with density pdf, of unshadowed radiance L, the
// estimate of the reflected light is f(l) L cos / pdf (one-sample Monte Carlo), with the BRDF's parts kept apart. Candidates that can
// give light go into the slots of shadow_ray_slots.glsl.
#include "shadow_ray_slots.glsl"
#include "lights/emission_share.glsl"
#include "lights/portals.glsl"
#include "lights/ris.glsl"
#include "shading_point.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer ChoiceTable { uvec2 at[]; };
layout(constant_id = 10) const uint nee_at_pdf = NEE_AT_PDF_EXACT;

const uint CANDIDATE_KINDS[CANDIDATES] =
    uint[](KIND_SUN, KIND_POSITIONAL, KIND_EMISSIVE, KIND_LOCAL, KIND_ENVIRONMENT, KIND_ENVIRONMENT);

// A sample of one local light, `light`, by the kernel's sampler.
#ifdef RESTIR
// What restir_spatial has kept; it stands for all light samples of the pixel, and is given to the first.
LightSample local_candidate(LightContext c, ivec2 p, uvec2 key, uvec4 bits, out uint light) {
    light = NONE;
    if (push.light_sample > 0u) return NO_LIGHT_SAMPLE;
    Reservoir r = make_reservoir(imageLoad(im_restir_point, p).xy, imageLoad(im_restir_weight, p).xy);
    if (r.weight <= 0.0 || !is_local_light(r.light, push.kinds)) return NO_LIGHT_SAMPLE;
    light = r.light;
    LightSample s = sample_local_light(c, light, unit_numbers(r.numbers));
    s.pdf /= r.weight * float(push.samples);
    return s;
}
#else
LightSample local_candidate(LightContext c, ivec2 p, uvec2 key, uvec4 bits, out uint light) {
    vec4 xi = unit_from_bits(bits);
    LightSample s = NO_LIGHT_SAMPLE;
    if (light_sampler == LIGHT_SAMPLER_RIS) {
        s = ris_sample(c, key, xi.x, push.ris_candidates, push.ris_stratified != 0u, light);
    } else if (light_sampler == LIGHT_SAMPLER_NEE_AT && push.nee_at_candidates > 1u) {
        s = ris_sample(c, key, xi.x, push.nee_at_candidates, true, light);
    } else {
        float pmf;
        light = pick_light(c, bits, pick_by_power(random_bits(key, DIM_LIGHT_BY_POWER)), pmf);
        if (light != NONE) s = sample_local_light(c, light, xi.zw);
        s.pdf *= pmf;
    }
    bool on = light != NONE && (push.kinds & kind_of_light(light)) != 0u;
    return on ? s : NO_LIGHT_SAMPLE;
}
#endif

// Samples of the environment with a ray of its own are drawn by radiance, or through portals, and with the probability `cosine_share` by the
// cosine of the surface. Their density is that of both together (one-sample balance heuristic, Veach 1997, section 9.2).
float cosine_share() { return unpackUnorm2x16(push.environment_shares).x; }
float portal_share() { return unpackUnorm2x16(push.environment_shares).y; }

float with_cosine(ShadingPoint s, vec3 direction, float pdf) {
    return mix(pdf, cosine_hemisphere_pdf(dot(s.world_from_local[2], direction)), cosine_share());
}

float apart_environment_pdf(ShadingPoint s, vec3 direction) {
    float pdf;
    if (scene_has(FEATURE_PORTALS)) pdf = environment_through_pdf(s.position, portal_share(), direction);
    else pdf = environment_pdf(direction);
    return with_cosine(s, direction, pdf);
}

LightSample sample_environment_apart(ShadingPoint s, uvec2 key, uvec4 bits) {
    vec4 xi = unit_from_bits(random_bits(key, DIM_COSINE));
    LightSample light;
    if (xi.x < cosine_share()) {
        light = NO_LIGHT_SAMPLE;
        light.direction = s.world_from_local * sample_cosine_hemisphere(xi.yz);
        light.radiance = environment_radiance(light.direction);
        light.pdf = apart_environment_pdf(s, light.direction);
        return light;
    }
    if (scene_has(FEATURE_PORTALS)) light = sample_environment_through(s.position, portal_share(), bits, random_bits(key, DIM_PORTAL));
    else light = sample_environment(bits);
    light.pdf = with_cosine(s, light.direction, light.pdf);
    return light;
}

LightSample candidate_light(ShadingPoint s, LightContext c, ivec2 p, uint candidate, uvec2 key, out uint local) {
    uvec4 bits = random_bits(key, CANDIDATE_DIMENSIONS[candidate]);
    LightSample light = NO_LIGHT_SAMPLE;
    local = NONE;
    switch (candidate) {
    case CANDIDATE_SUN: light = sample_sun(bits); break;
    case CANDIDATE_POSITIONAL: if (!merged_rays) light = sample_positional(s.position, bits); break;
    case CANDIDATE_EMISSIVE: if (!merged_rays) light = sample_emissive(s.position, bits); break;
    case CANDIDATE_LOCAL: if (merged_rays) light = local_candidate(c, p, key, bits, local); break;
    case CANDIDATE_ENVIRONMENT: light = sample_environment_apart(s, key, bits); break;
    // Narrow lobes do not find the environment by chance: this ray goes where the surface reflects.
    case CANDIDATE_REFLECTION:
        light.direction = sample_reflected(s, unit_from_bits(bits));
        light.radiance = environment_radiance(light.direction);
        break;
    }
    return light;
}

// Density of a direction of the listed environment in the weights of multiple importance sampling, on both sides.
float weighing_environment_pdf(LightContext c, vec3 direction) {
    if (light_sampler != LIGHT_SAMPLER_NEE_AT || nee_at_pdf == NEE_AT_PDF_EXACT) return listed_environment_pdf(c, direction);
    uint light;
    float pdf = environment_quad_pdf(direction, light);
    return light == NONE || scene.light_tables.local_light_count == 0u ? 0.0 : pdf * nee_at_averaged_pmf(c, light);
}

LightContext light_context(ShadingPoint s, ivec2 p) {
    float f0 = luminance(s.brdf.f0);
    float specular = clamp(f0 / max(f0 + luminance(s.brdf.albedo), 1e-6), 0.0, 0.9);
    return LightContext(s.position, s.world_from_local[2], s.world_from_local * s.view, imageLoad(ch_cluster, p).x, s.roughness, specular,
                        nee_at_tile(push.nee_at_tiles, p, split_size()));
}

// Part of the specular light of a candidate that bounce rays find. `local`: the light, if its index is known.
float bounced_share(ShadingPoint s, LightSample light, uint candidate, uint local) {
    bool emissive = candidate == CANDIDATE_EMISSIVE || candidate == CANDIDATE_LOCAL && local < scene.emissive_count;
    if (push.emission_share == EMISSION_SHARE_LIGHT_SAMPLES || !emissive || light.pdf <= 0.0) return 0.0;
    // Without an index the light was picked by power.
    float light_pdf = local == NONE ? light.pdf : emissive_sample_pdf(light, local, s.position);
    return emission_bounce_share(push.emission_share, s.world_from_local, s.view, light.direction, s.roughness, light_pdf);
}

// Puts a candidate into its slot; whether it can give light. `weight`: of multiple importance sampling; `bounced`: bounced_share(), 0 where
// it is not known yet whether the ray passes glass.
bool keep_candidate(ShadingPoint s, LightSample light, float weight, float bounced, uint local, uint place) {
    if (light.pdf <= 0.0 || weight <= 0.0 || max_component(light.radiance) <= 0.0) return false;
    BrdfValue f = reflected(s, light.direction);
    f.specular *= 1.0 - bounced;
    if (max_component(f.diffuse + f.specular) <= 0.0) return false;
    vec3 scaled = light.radiance * (weight / light.pdf);
    ShadowRayTables tables = shadow_ray_tables();
    vec3 end = light.finite ? light.target : light.direction;
    SlotTable(tables.ends).at[place] = uvec4(floatBitsToUint(end), end_word(light.finite, local));
    SlotTable(tables.lights).at[place] = uvec4(pack_light(f.diffuse * scaled), pack_light(f.specular * scaled));
    return true;
}

// The bits of the slots that have a ray.
uint choose_lights(ivec2 p) {
    vec4 position = imageLoad(ch_shading_position, p);
    uint kept = 0u, near = 0u;
    uvec2 choice = uvec2(NONE, 0u);
    if (floatBitsToUint(position.w) != 0u) {
        ShadingPoint s = load_shading_point(p, position);
        LightContext context = light_context(s, p);
        begin_choices(imageLoad(ch_rng_seed, p).xy, frame.frame_index);
        uvec2 key = sample_key(p);
        bool reflects = (push.kinds & KIND_ENVIRONMENT) != 0u && scene.environment_intensity > 0.0 && s.roughness <= push.reflection_roughness;
        bool listed = merged_rays && environment_is_listed();
        // A loop, so that the kernel has the BRDF once.
        [[dont_unroll]] for (uint slot = 0u; slot < slot_count(); slot++) {
            uint candidate = slot_candidate(slot);
            if ((push.kinds & CANDIDATE_KINDS[candidate]) == 0u || candidate == CANDIDATE_REFLECTION && !reflects) continue;
            if (listed && candidate == CANDIDATE_ENVIRONMENT) continue;
            uint local;
            LightSample light = candidate_light(s, context, p, candidate, key, local);
            float weight = 1.0;
            bool distant = candidate >= CANDIDATE_ENVIRONMENT || (local != NONE && kind_of_light(local) == KIND_ENVIRONMENT);
            if (reflects && distant) {
                // Multiple importance sampling of the environment and of what the surface reflects. Both densities are functions of the direction.
                float pdf = reflected_pdf(s, light.direction);
                bool reflection = candidate == CANDIDATE_REFLECTION;
                float light_pdf = light.pdf;
                if (listed) light_pdf = weighing_environment_pdf(context, light.direction);
                else if (reflection) light_pdf = apart_environment_pdf(s, light.direction);
                if (reflection) light.pdf = pdf;
                weight = reflection ? power_weight(pdf, light_pdf) : power_weight(light_pdf, pdf);
            }
            if (local != NONE) choice = uvec2(local, pcg4d(uvec4(floatBitsToUint(light.target), local)).x);
            // What tiles learn about is the light that a ray's end names.
            bool teaches = listed && light_sampler == LIGHT_SAMPLER_NEE_AT && push.nee_at_bsdf_feedback != 0u;
            if (candidate == CANDIDATE_REFLECTION && teaches) local = light_of_direction(light.direction);
            float bounced = bounced_share(s, light, candidate, local);
            if (shares_are_late() && is_emissive_slot(slot)) {
                ShareTable(shadow_ray_tables().shares).at[texel_index(p)] = bounced;
                bounced = 0.0;
            }
            if (keep_candidate(s, light, weight, bounced, local, slot_place(slot, texel_index(p)))) {
                kept |= 1u << slot;
                if (light.finite || local != NONE) near |= 1u << slot;
            }
        }
    }
    StateTable(shadow_ray_tables().states).at[texel_index(p)] = kept << STATE_TRACED | near << STATE_NEAR;
    if (push.choices != 0ul && (push.light_sample == 0u || choice.x != NONE)) ChoiceTable(push.choices).at[texel_index(p)] = choice;
    return kept;
}

// The list is written by whole workgroups, slot by slot, so that rays of one kind from neighbouring texels stand side by side and its length is
// one atomic for many.
shared uint group_counts[MAX_SLOTS];
shared uint group_first;

// Called by all threads of the workgroup.
void list_rays(uint kept, uint texel) {
    if (gl_LocalInvocationIndex < MAX_SLOTS) group_counts[gl_LocalInvocationIndex] = 0u;
    barrier();
    uint places[MAX_SLOTS];
    [[unroll]] for (uint slot = 0u; slot < MAX_SLOTS; slot++) {
        places[slot] = (kept >> slot & 1u) != 0u ? atomicAdd(group_counts[slot], 1u) : 0u;
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        uint count = 0u;
        for (uint slot = 0u; slot < MAX_SLOTS; slot++) count += group_counts[slot];
        group_first = count > 0u ? grow_list(RayListCount(shadow_ray_tables().head), push.ray_columns, count) : 0u;
    }
    barrier();
    uint first = group_first;
    [[unroll]] for (uint slot = 0u; slot < MAX_SLOTS; slot++) {
        if ((kept >> slot & 1u) != 0u) RayList(shadow_ray_tables().list).at[first + places[slot]] = slot << TEXEL_BITS | texel;
        first += group_counts[slot];
    }
}

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    // No thread returns before the barriers.
    bool inside = all(lessThan(p, split_size()));
    uint kept = inside ? choose_lights(p) : 0u;
    list_rays(kept, inside ? texel_index(p) : 0u);
}
