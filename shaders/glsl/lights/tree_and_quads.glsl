// The choice of a local light by the light tree where the environment is listed: its quads have no place and are not in the tree. Tree or quads
// are chosen in proportion to the importance of the tree's root and the sum of the masses of all quads (light_mass()), then a quad in proportion to its
// mass. The first choice is a branch of the tree like any other, so the pmf is as exact.
#include "lights/light_bvh.glsl"
#include "lights/local_lights.glsl"

float quads_mass(LightContext c) {
    float sum = 0.0;
    for (uint i = 0u; i < scene.environment_quad_count; i++) sum += light_mass(c, choice_light(first_environment_light() + i));
    return sum;
}

// How many of LIGHT_BVH_STEPS go to the tree; `mass`: of all quads. NONE: no light contributes.
uint steps_of_tree(LightContext c, LightBvhPoint p, out float mass) {
    mass = 0.0;
    // Whether the tree contributes its first branch says: the root is asked only where it stands against quads.
    if (!environment_is_listed()) return LIGHT_BVH_STEPS;
    mass = quads_mass(c);
    float tree = light_bvh_root_importance(p);
    if (mass <= 0.0) return tree > 0.0 ? LIGHT_BVH_STEPS : NONE;
    if (tree <= 0.0) return 0u;
    // The tree knows shares of its power, and radiance that is reflected: 1 / pi of the irradiance.
    tree = min(PI * tree * choice_tables().light_bvh_power, 1e30);
    precise float share = tree / (tree + min(mass, 1e30)) * float(LIGHT_BVH_STEPS);
    return clamp(uint(share), 1u, LIGHT_BVH_STEPS - 1u);
}

// A quad in proportion to its mass; `pmf` among the quads.
uint pick_quad(LightContext c, float mass, float xi, out float pmf) {
    uint picked = NONE;
    float sum = 0.0, own = 0.0;
    for (uint i = 0u; i < scene.environment_quad_count; i++) {
        uint light = first_environment_light() + i;
        float m = light_mass(c, choice_light(light));
        if (m <= 0.0) continue;
        picked = light;
        own = m;
        sum += m;
        if (sum > xi * mass) break;
    }
    pmf = own / mass;
    return picked;
}

uint tree_or_quad_pick(LightContext c, uvec2 bits, out float pmf) {
    pmf = 0.0;
    LightBvhPoint p = light_bvh_point(c.position, c.normal, c.view, c.roughness);
    float mass;
    uint steps = steps_of_tree(c, p, mass), place = bits.x >> 1;
    if (steps == NONE) return NONE;
    if (place < steps) return light_bvh_descend(p, steps, place, bits.y, pmf);
    uint rest = LIGHT_BVH_STEPS - steps;
    uint light = pick_quad(c, mass, float(place - steps) / float(rest), pmf);
    pmf *= float(rest) / float(LIGHT_BVH_STEPS);
    return light;
}

float tree_or_quad_pmf(LightContext c, uint light) {
    if (light == NONE) return 0.0;
    LightBvhPoint p = light_bvh_point(c.position, c.normal, c.view, c.roughness);
    float mass;
    uint steps = steps_of_tree(c, p, mass);
    if (steps == NONE) return 0.0;
    if (kind_of_light(light) != KIND_ENVIRONMENT) return steps > 0u ? light_bvh_descend_pmf(p, steps, light) : 0.0;
    if (mass <= 0.0) return 0.0;
    return light_mass(c, choice_light(light)) / mass * (float(LIGHT_BVH_STEPS - steps) / float(LIGHT_BVH_STEPS));
}
