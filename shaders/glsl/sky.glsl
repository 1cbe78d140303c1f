// Radiance from infinitely far away: the environment, and the discs of directional lights that have a size.
#include "environment.glsl"
#include "sampling.glsl"

// A directional light with an angular radius, as seen along `direction`: radiance, and density of sample_sun for the direction.
// The chord to the axis is compared, because the cosine has no digits left at the sun's size.
struct SunDisc {
    vec3 radiance;
    float pdf;
};

SunDisc sun_disc(uint index, vec3 direction) {
    LightRecord light = LightTable(scene.light_tables.lights).at[index];
    vec3 chord = direction + light.direction;
    float one_minus_cos = 2.0 * square(sin(0.5 * light.radius));
    if (light.radius <= 0.0 || dot(chord, chord) > 2.0 * one_minus_cos) return SunDisc(vec3(0.0), 0.0);
    return SunDisc(light.intensity * (INV_PI / square(sin(light.radius))), light.pmf * cone_pdf(one_minus_cos));
}

// All discs together.
vec3 disc_radiance(vec3 direction) {
    vec3 sum = vec3(0.0);
    if (!scene_has(FEATURE_SUN_DISC)) return sum;
    for (uint i = 0u; i < scene.light_tables.sun_count; i++) sum += sun_disc(i, direction).radiance;
    return sum;
}
