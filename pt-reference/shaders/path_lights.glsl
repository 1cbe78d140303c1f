// Light of a path: one light sample at each vertex (next event estimation), and the light that the path's own rays hit.
#include "lights/light_sampler.glsl"
#include "clusters.glsl"
#include "path_vertex.glsl"

bool kind_on(uint kind) { return (light_kinds & kind) != 0u; }

// The kinds that next event estimation tells apart: local lights are one with merged_lights.
uint sampled_kinds() { return merged_lights ? light_kinds & ~(KIND_EMISSIVE | KIND_POSITIONAL) : light_kinds & ~KIND_LOCAL; }

// Probability with which next event estimation picks each kind of light: uniform over those that are on and present (the host
// clears the bits of absent kinds).
float kind_pmf() { return 1.0 / float(bitCount(sampled_kinds())); }

// What the sampler of local lights knows of a vertex. It looks at the half space of the normal; surfaces that get light from elsewhere
// too (transmission, a coat with a normal of its own) have a negative roughness: their lights are picked by power.
LightContext light_context(PathVertex v) {
    Bsdf b = v.bsdf;
    float f0 = mix(0.04 * b.specular, luminance(b.base_color), b.metallic);
    float albedo = (1.0 - b.metallic) * luminance(b.base_color);
    float roughness = b.transmission > 0.0 || b.coat > 0.0 ? -1.0 : sqrt(max(b.alpha.x, b.alpha.y));
    return LightContext(v.position, unpack_unit_vector(pack_unit_vector(b.frame[2])), unpack_unit_vector(pack_unit_vector(b.wo)),
                        cluster_of(v.position), roughness, clamp(f0 / max(f0 + albedo, 1e-6), 0.0, 0.9), 0ul);
}

// What light sampling knew of the vertex of the last scattering, if merged_lights: position and normal; direction to the viewer, cluster,
// roughness and specular share. It stays in memory, since few rays find a light.
void keep_light_context(uint slot, LightContext c) {
    light_table().at[2u * slot] = vec4(c.position, uintBitsToFloat(pack_unit_vector(c.normal)));
    light_table().at[2u * slot + 1u] = vec4(uintBitsToFloat(uvec2(pack_unit_vector(c.view), c.cluster)), c.roughness, c.specular);
}

LightContext kept_light_context(uint slot) {
    vec4 place = light_table().at[2u * slot], surface = light_table().at[2u * slot + 1u];
    return LightContext(place.xyz, unpack_unit_vector(floatBitsToUint(place.w)), unpack_unit_vector(floatBitsToUint(surface.x)),
                        floatBitsToUint(surface.y), surface.z, surface.w, 0ul);
}

float local_pmf(LightContext c, uint light) { return c.roughness < 0.0 ? power_pmf(light) : light_pmf(c, light); }

LightSample sample_local(LightContext c, uvec4 bits) {
    // The samplers that use both keep the numbers apart.
    uint by_power = pick_by_power(light_sampler == LIGHT_SAMPLER_POWER || c.roughness < 0.0 ? bits : pcg4d(bits));
    float pmf = 0.0;
    uint light = by_power;
    if (c.roughness >= 0.0) light = pick_light(c, bits, by_power, pmf);
    else if (light != NONE) pmf = power_pmf(light);
    if (light == NONE || !kind_on(light < scene.emissive_count ? KIND_EMISSIVE : KIND_POSITIONAL)) return NO_LIGHT_SAMPLE;
    LightSample s = sample_local_light(c, light, unit_from_bits(bits).zw);
    s.pdf *= pmf;
    return s;
}

// Density of light sampling for a point of emissive triangle `index` that the path's ray has found, seen under `cos_light`.
float emissive_light_pdf(PathState path, uint slot, uint index, float twice_area, float cos_light) {
    if (!merged_lights) return kind_pmf() * emissive_pdf(index, twice_area, path.chord, cos_light);
    if (index == NONE || cos_light <= 0.0 || (path.flags & PATH_DELTA) != 0u) return 0.0;
    return kind_pmf() * local_pmf(kept_light_context(slot), index) * triangle_area_pdf(twice_area, path.chord, cos_light);
}

// One sample of one kind of light; its pdf includes the choice of the kind.
LightSample sample_light(LightContext c, float xi_kind, uvec4 bits) {
    uint kinds = sampled_kinds();
    if (kinds == 0u) return NO_LIGHT_SAMPLE;
    uint left = min(uint(xi_kind * float(bitCount(kinds))), uint(bitCount(kinds)) - 1u);
    for (; left > 0u; left--) kinds &= kinds - 1u;
    uint kind = kinds & -kinds;
    LightSample s = NO_LIGHT_SAMPLE;
    if (kind_on(KIND_SUN) && kind == KIND_SUN) s = sample_sun(bits);
    if (kind_on(KIND_POSITIONAL) && kind == KIND_POSITIONAL) s = sample_positional(c.position, bits);
    if (kind_on(KIND_EMISSIVE) && kind == KIND_EMISSIVE) s = sample_emissive(c.position, bits);
    if (merged_lights && kind == KIND_LOCAL) s = sample_local(c, bits);
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
