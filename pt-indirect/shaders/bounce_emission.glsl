// Light that a bounce ray meets itself, and its weight against that of light samples, which may find the same.
#include "bounce_light.glsl"
#include "bounce_path.glsl"
#include "bounce_vertex.glsl"

struct Emission {
    vec3 radiance;
    bool is_sampled;  // light samples find it
    float light_pdf;  // emissive_pdf()
};

// Weight of light that the ray meets and that light samples find with density `light_pdf`.
float ray_weight(BouncePath path, float light_pdf) {
    if ((path.flags & PATH_COVERED) != 0u) return 0.0;
    if ((path.flags & PATH_DELTA) != 0u || light_pdf <= 0.0) return 1.0;
    return glass_is_ignored() ? 0.0 : power_weight(path.last_pdf, light_pdf);
}

// The environment, and the discs of directional lights that have a size.
vec3 radiance_from_afar(BouncePath path) {
    vec3 sum = vec3(0.0), direction = path.ray.direction;
    if (kind_on(KIND_ENVIRONMENT)) {
        sum += ray_weight(path, environment_pdf(direction) * kind_pmf()) * environment_radiance(direction);
    }
    if (!kind_on(KIND_SUN)) return sum;
    for (uint i = 0u; i < scene.light_tables.sun_count; i++) {
        SunDisc disc = sun_disc(i, direction);
        if (disc.pdf > 0.0) sum += ray_weight(path, disc.pdf * kind_pmf()) * disc.radiance;
    }
    return sum;
}

// Emission of a surface that the ray meets. `chord`: way since the last scattering, metres.
Emission met_emission(BouncePath path, BounceVertex v, Hit hit, float chord) {
    bool emits = v.front || (v.flags & MATERIAL_DOUBLE_SIDED) != 0u;
    if ((push.kinds & KIND_EMISSIVE) == 0u || !emits || max_component(v.sampled.emission) <= 0.0) return Emission(vec3(0.0), false, 0.0);
    uint index = emissive_index(hit.instance, hit.triangle);
    float light_pdf = emissive_pdf(index, v.twice_area, chord, dot(v.bsdf.face_normal, -path.ray.direction));
    return Emission(v.sampled.emission, index != NONE, light_pdf);
}
