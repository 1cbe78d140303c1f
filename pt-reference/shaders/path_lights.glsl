// Light of a path: one light sample at each vertex (next event estimation), and the light that the path's own rays hit.
#include "lights.glsl"

bool kind_on(uint kind) { return (light_kinds & kind) != 0u; }

// Probability with which next event estimation picks each kind of light: uniform over those that are on and present (the host
// clears the bits of absent kinds).
float kind_pmf() { return 1.0 / float(bitCount(light_kinds)); }

// One sample of one kind of light; its pdf includes the choice of the kind.
LightSample sample_light(vec3 position, float xi_kind, uvec4 bits) {
    if (light_kinds == 0u) return NO_LIGHT_SAMPLE;
    uint left = min(uint(xi_kind * float(bitCount(light_kinds))), uint(bitCount(light_kinds)) - 1u);
    uint kinds = light_kinds;
    for (; left > 0u; left--) kinds &= kinds - 1u;
    uint kind = kinds & -kinds;
    LightSample s = NO_LIGHT_SAMPLE;
    if (kind_on(KIND_SUN) && kind == KIND_SUN) s = sample_sun(bits);
    if (kind_on(KIND_POSITIONAL) && kind == KIND_POSITIONAL) s = sample_positional(position, bits);
    if (kind_on(KIND_EMISSIVE) && kind == KIND_EMISSIVE) s = sample_emissive(position, bits);
    if (kind_on(KIND_ENVIRONMENT) && kind == KIND_ENVIRONMENT) s = sample_environment(bits);
    s.pdf *= kind_pmf();
    return s;
}

// Radiance from infinitely far away along the path's ray, weighted for multiple importance sampling: the environment, and the
// discs of directional lights that have a size.
vec3 radiance_from_afar(PathState path) {
    vec3 sum = vec3(0.0);
    if (kind_on(KIND_ENVIRONMENT)) {
        float pdf = environment_pdf(path.direction) * kind_pmf();
        sum += bsdf_sample_weight(path, pdf) * environment_radiance(path.direction);
    }
    if (kind_on(KIND_SUN)) {
        for (uint i = 0u; i < scene.light_tables.sun_count; i++) {
            SunDisc disc = sun_disc(i, path.direction);
            if (disc.pdf > 0.0) sum += bsdf_sample_weight(path, disc.pdf * kind_pmf()) * disc.radiance;
        }
    }
    return sum;
}
