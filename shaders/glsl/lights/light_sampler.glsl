// The choice of a local light, by the sampler that the kernel is made for: every stage that samples lights calls
//
//     uint pick_light(LightContext c, uvec4 bits, uint by_power, out float pmf)   a light, NONE: none, and its probability
//     float light_pmf(LightContext c, uint light)                                 the probability of a light that something else found
//     uint pick_by_power(uvec4 bits)                                              for `by_power`, from random bits of its own
//     float listed_environment_pdf(LightContext c, vec3 direction)                density of a direction of the environment (MIS)
//
// and sample_local_light() for a point on it. ris.glsl, which has no closed form of the probability, builds on this.
#include "lights/cluster_lists.glsl"
#include "lights/nee_at.glsl"
#include "lights.glsl"

layout(constant_id = 3) const uint light_sampler = LIGHT_SAMPLER_POWER;
layout(constant_id = 5) const uint bvh_importance = BVH_IMPORTANCE_BOUNDS;

#define LIGHT_BVH_NODES choice_tables().light_bvh
#define LIGHT_BVH_TRAILS choice_tables().light_bvh_trails
#define LIGHT_BVH_GAUSSIAN (bvh_importance == BVH_IMPORTANCE_SPHERICAL_GAUSSIAN)
#include "lights/tree_and_quads.glsl"

uint pick_by_power(uvec4 bits) {
    if (choice_tables().local_light_count == 0u) return NONE;
    return alias_pick(choice_tables().local_alias, choice_tables().local_light_count, bits.x, unit_from_bits(bits).y);
}

uint pick_uniformly(uint bits) {
    if (choice_tables().local_light_count == 0u) return NONE;
    uint light, fraction;
    umulExtended(bits, choice_tables().local_light_count, light, fraction);
    return light;
}

float light_pmf(LightContext c, uint light) {
    switch (light_sampler) {
    case LIGHT_SAMPLER_UNIFORM: return 1.0 / float(choice_tables().local_light_count);
    case LIGHT_SAMPLER_CLUSTER_CDF: return cluster_pmf(c, light, false);
    case LIGHT_SAMPLER_CLUSTER_STATS: return cluster_pmf(c, light, true);
    case LIGHT_SAMPLER_LIGHT_BVH: return tree_or_quad_pmf(c, light);
    case LIGHT_SAMPLER_NEE_AT: return nee_at_pmf(c, light);
    default: return power_pmf(light);
    }
}

uint pick_light(LightContext c, uvec4 bits, uint by_power, out float pmf) {
    pmf = 0.0;
    if (choice_tables().local_light_count == 0u) return NONE;
    uint light;
    switch (light_sampler) {
    case LIGHT_SAMPLER_CLUSTER_CDF: return cluster_pick(c, unit_from_bits(bits).xy, by_power, false, pmf);
    case LIGHT_SAMPLER_CLUSTER_STATS: return cluster_pick(c, unit_from_bits(bits).xy, by_power, true, pmf);
    case LIGHT_SAMPLER_LIGHT_BVH: return tree_or_quad_pick(c, bits.xy, pmf);
    case LIGHT_SAMPLER_UNIFORM: light = pick_uniformly(bits.x); break;
    case LIGHT_SAMPLER_NEE_AT: light = nee_at_pick(c, bits, by_power); break;
    default: light = by_power; break;
    }
    pmf = light_pmf(c, light);
    return light;
}

// Density per solid angle with which samples of local lights find a direction of the environment that something else found: of the choice of
// its quad and of the direction in it. Of a sampler without a closed form it is that of a choice by power: weights of multiple importance
// sampling stay unbiased, as they are functions of the direction that sum to 1.
float listed_environment_pdf(LightContext c, vec3 direction) {
    if (choice_tables().local_light_count == 0u) return 0.0;
    uint light;
    float pdf = environment_quad_pdf(direction, light);
    return light == NONE ? 0.0 : pdf * light_pmf(c, light);
}
