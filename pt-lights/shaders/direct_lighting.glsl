// One texel of "direct lighting": adds up what its shadow rays bring. color_hf gets the diffuse part without the albedo, color_spec the rest
// divided by demodulation(). Their alpha is the mean distance of the light that has arrived, weighted by its luminance w:
//
//     distance = sum w / sum (w / d)
//
// a mean of inverse distances, so that it stays meaningful where part of the light comes from infinitely far (d = SKY_DISTANCE); 0 where no light
// has arrived. What the samplers learn from visibility is noted here.
#include "shadow_ray_slots.glsl"
#include "lights/light_sampler.glsl"
#include "lights/statistics.glsl"
#include "gbuffer_format.glsl"
#include "glass_shadow.glsl"
#include "rgb9e5.glsl"

layout(constant_id = 9) const uint light_storage = LIGHT_STORAGE_FP32;
// Brings usual light into the range of RGB9E5: with all bits from 5e-4 to 1e6. Host twin: pt_lights::oracle::RGBE_SCALE.
const float RGBE_SCALE = 1.0 / 16.0;

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer RayCountsOut { RayCounts rays; };

struct LightSums {
    vec4 diffuse;  // w: sum of luminance over distance
    vec4 specular;
};

void add_light(inout vec4 sum, vec3 light, float distance) { sum += vec4(light, luminance(light) / distance); }

float mean_distance(vec4 sum) {
    float distance = luminance(sum.rgb) / sum.a;
    // False for what is not a number, too.
    return distance > 0.0 ? min(distance, SKY_DISTANCE) : 0.0;
}

#ifdef DROP_HIDDEN
// A hidden sample is worth nothing to the next frame.
void drop_hidden(ivec2 p) {
    uint count = imageLoad(im_restir_history_weight, p).y;
    imageStore(im_restir_history_weight, p, uvec4(0u, count, 0u, 0u));
}
#endif

// Photons carry what smooth glass bends.
uint slot_stopping_glass(uint slot) {
    uint stopping = stopping_glass(push.glass_shadows);
    if (!is_caustic_slot(slot)) return stopping;
    return push.glass_shadows == GLASS_SHADOWS_STOPPED ? STOPS_SMOOTH | STOPS_ROUGH : stopping | STOPS_SMOOTH;
}

// Where the ray of a slot met glass: whether it arrives all the same, and how much of the light passes. `through_glass`: false where what
// it met has holes that it went through.
bool passes_glass(ivec2 p, uint slot, uint place, out bool through_glass, out vec3 passed) {
    Ray ray = slot_ray(p, SlotTable(shadow_ray_tables().ends).at[place]);
    uvec2 ray_coverage = slot_coverage(p, slot);
    passed = vec3(0.0);
    through_glass = true;
    if (trace_occluded(ray, unseen_mask(slot_mask(slot)), ray_coverage)) return false;
    through_glass = glass_shadow(ray, ray_coverage, slot_stopping_glass(slot), passed);
    return true;
}

void add_slots(ivec2 p, uint texel, uint state, vec4 base, float metallic, inout LightSums sums, inout LightFeedback feedback) {
    ShadowRayTables tables = shadow_ray_tables();
    vec3 position = vec3(0.0);
    if (state >> STATE_NEAR != 0u) position = imageLoad(ch_shading_position, p).xyz;
    uvec2 rays = uvec2(0u);
    // Shadow rays of gradient pixels do not count for the statistics.
    begin_choices(imageLoad(ch_rng_seed, p).xy, frame.frame_index);
    [[dont_unroll]] for (uint slot = 0u; slot < slot_count(); slot++) {
        if (!has_state(state, STATE_TRACED, slot)) continue;
        uint place = slot_place(slot, texel);
        uvec4 end = FAR_END;
        if (has_state(state, STATE_NEAR, slot)) end = SlotTable(tables.ends).at[place];
        vec3 passed = vec3(1.0);
        bool arrived = !has_state(state, STATE_HIDDEN, slot), through_glass = false;
        if (scene_has(FEATURE_TRANSMISSION) && has_state(state, STATE_GLASS, slot)) arrived = passes_glass(p, slot, place, through_glass, passed);
        vec3 diffuse = vec3(0.0), specular = vec3(0.0);
        if (arrived) {
            uvec4 light = SlotTable(tables.lights).at[place];
            diffuse = passed * unpack_light(light.xy);
            specular = passed * unpack_light(light.zw);
            bool shared_late = shares_are_late() && is_emissive_slot(slot) && !through_glass;
            if (shared_late) specular *= 1.0 - ShareTable(tables.shares).at[texel];
            float distance = (end.w & END_FINITE) != 0u ? length(uintBitsToFloat(end.xyz) - position) : SKY_DISTANCE;
            add_light(sums.diffuse, diffuse, distance);
            add_light(sums.specular, specular, distance);
        }
        rays += uvec2(1u, arrived ? 1u : 0u);
        uint local = end_light(end.w);
        if (local == NONE) continue;
        if (light_sampler == LIGHT_SAMPLER_CLUSTER_STATS) {
            count_shadow_ray(imageLoad(ch_cluster, p).x, local, unpack_unit_vector(imageLoad(ch_normal, p).x), arrived);
        }
        if (light_sampler == LIGHT_SAMPLER_NEE_AT && arrived) {
            vec3 arrival = diffuse * diffuse_albedo(base.rgb, metallic) + specular;
            insert_feedback(feedback, local, luminance(arrival), random_numbers(sample_key(p), DIM_NEE_AT_FEEDBACK).x);
        }
#ifdef DROP_HIDDEN
        if (!arrived) drop_hidden(p);
#endif
    }
    if (push.counts != 0ul) {
        atomicAdd(RayCountsOut(push.counts).rays.traced, rays.x);
        atomicAdd(RayCountsOut(push.counts).rays.arrived, rays.y);
    }
}

// The light as it is after storage. `dimension`: of the numbers that round.
vec3 stored_light(vec3 light, ivec2 p, uint dimension) {
    if (light_storage == LIGHT_STORAGE_FP32) return light;
    vec3 xi = random_numbers(imageLoad(ch_rng_seed, p).xy, dimension).xyz;
    return unpack_rgb9e5(pack_rgb9e5(light * RGBE_SCALE, xi)) / RGBE_SCALE;
}

void main() {
    ivec2 p = ivec2(launch_id());
    if (any(greaterThanEqual(p, split_size()))) return;
    ShadowRayTables tables = shadow_ray_tables();
    // The rays have been traced: the next frame, or light sample, begins a new list.
    if (p == ivec2(0)) RayListCount(tables.head).head = empty_list(push.ray_columns);
    uint texel = texel_index(p), state = StateTable(tables.states).at[texel];
    LightSums sums = LightSums(vec4(0.0), vec4(0.0));
    LightFeedback feedback = NO_FEEDBACK;
    if (push.light_sample > 0u) {
        sums = LightSums(SumTable(tables.sums).at[2u * texel], SumTable(tables.sums).at[2u * texel + 1u]);
        if (light_sampler == LIGHT_SAMPLER_NEE_AT) feedback = kept_feedback(push.nee_at_feedback, p, split_size());
    }
    // Pixels without light, such as the sky, need no material.
    vec4 base = vec4(0.0);
    float metallic = 0.0;
    if (state != 0u || push.light_sample > 0u) {
        base = base_color_of(imageLoad(ch_base_color, p));
        metallic = imageLoad(ch_metallic_roughness, p).x;
    }
    if (state != 0u) add_slots(p, texel, state, base, metallic, sums, feedback);
    if (light_sampler == LIGHT_SAMPLER_NEE_AT) keep_feedback(push.nee_at_feedback, p, split_size(), feedback);
    if (push.light_sample + 1u < push.samples) {
        SumTable(tables.sums).at[2u * texel] = sums.diffuse;
        SumTable(tables.sums).at[2u * texel + 1u] = sums.specular;
        return;
    }
    float share = 1.0 / float(push.samples);
    vec3 diffuse = stored_light(sums.diffuse.rgb * share, p, DIM_LIGHT_STORAGE);
    imageStore(ch_color_hf, p, vec4(diffuse, mean_distance(sums.diffuse)));
    vec3 specular = stored_light(sums.specular.rgb * (share / demodulation(base, metallic)), p, DIM_LIGHT_STORAGE + 1u);
    imageStore(ch_color_spec, p, vec4(specular, mean_distance(sums.specular)));
}
