// Highlights of punctual lights on rough glass: rays that look for what is seen in it or through it cannot find lights without extent. One light
// sample (next event estimation), reflected and refracted as in the reference (bsdf/interface.glsl).
#include "bsdf_surface.glsl"
#include "lights.glsl"

// The kinds among `kinds` that the scene has.
uint punctual_kinds(uint kinds) {
    LightTablesRecord tables = scene.light_tables;
    uint sun = tables.sun_count > 0u ? KIND_SUN : 0u;
    uint positional = tables.light_count > tables.sun_count ? KIND_POSITIONAL : 0u;
    return kinds & (sun | positional);
}

// Light that the interface sends towards the viewer. `xi`: which kind of light; `bits`: which one, and a point of it.
vec3 highlight(SeenSurface s, vec3 direction, float eta, uint kinds, float xi, uvec4 bits, uvec2 ray_coverage) {
    kinds = punctual_kinds(kinds);
    if (kinds == 0u) return vec3(0.0);
    bool both = kinds == (KIND_SUN | KIND_POSITIONAL);
    bool sun = both ? xi < 0.5 : kinds == KIND_SUN;
    LightSample light;
    if (sun) light = sample_sun(bits);
    else light = sample_positional(s.geometry.position, bits);
    if (both) light.pdf *= 0.5;
    if (!(light.pdf > 0.0)) return vec3(0.0);

    LobesSample no_lobes = LobesSample(0.0, 0.0, s.geometry.vertex_normal, vec3(0.0), 0.0, 0.0, vec2(1.0, 0.0), 0.0, 1.3, 0.0, 0.0);
    Bsdf b = surface_bsdf(s.geometry, s.material, no_lobes, -direction, eta, 0u);
    vec3 l = light.direction * b.frame;
    bool beyond = dot(b.face_normal, light.direction) < 0.0;
    if (b.local_wo.z <= 0.0 || (l.z < 0.0) != beyond) return vec3(0.0);
    vec3 f_cos;
    if (beyond) {
        f_cos = interface_transmission(b, l).f_cos;
    } else {
        vec3 h = normalize(l + b.local_wo);
        f_cos = interface_reflection(b, l, h, interface_fresnel(b, dot(b.local_wo, h))).f_cos;
    }
    vec3 radiance = f_cos * light.radiance / light.pdf;
    if (!(max_component(radiance) > 0.0)) return vec3(0.0);
    // What other glass lets through on the way is left out.
    Ray ray = shadow_ray(s.geometry.position, beyond ? -b.face_normal : b.face_normal, light);
    return trace_occluded(ray, unseen_mask(MASK_OPAQUE | MASK_TRANSMISSIVE), ray_coverage) ? vec3(0.0) : radiance;
}
