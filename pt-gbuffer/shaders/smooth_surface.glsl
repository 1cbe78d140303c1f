// The lobes of a mirror or of glass: the direction and the throughput of each.
#include "bsdf/fresnel.glsl"
#include "bsdf/ggx.glsl"
#include "gbuffer_store.glsl"

struct InterfaceLobes {
    vec3 reflected;    // unit directions
    vec3 transmitted;
    vec3 reflection;   // weight of each lobe
    vec3 transmission;
    vec3 diffuse;      // without the base colour
};

// `solid`: light is bent on its way through. A thin sheet stands for its two interfaces at once: straight through,
// F + (1 - F) x base colour (KHR_materials_transmission). `rough`: draw a microfacet with xi instead of the smooth interface: Walter
// et al. 2007, "Microfacet Models for Refraction through Rough Surfaces".
InterfaceLobes interface_lobes(SeenSurface s, MaterialRecord m, vec3 direction, bool solid, bool rough, vec2 xi) {
    float alpha = square(s.material.roughness);
    mat3 world_from_local = basis_around(s.normal);
    vec3 v = -direction * world_from_local;
    vec3 facet = rough ? world_from_local * sample_ggx_vndf(v, alpha, xi) : s.normal;
    float eta = solid && !s.front ? 1.0 / m.ior : m.ior;

    InterfaceLobes w;
    w.reflected = reflect(direction, facet);
    w.transmitted = solid ? refract(direction, facet, 1.0 / eta) : direction;
    bool internal = w.transmitted == vec3(0.0);
    vec2 masking = vec2(1.0);
    if (rough) {
        if (!solid) w.transmitted = reflect(w.reflected, s.normal);
        masking.x = ggx_reflection_weight(v, w.reflected * world_from_local, vec2(alpha));
        masking.y = ggx_refraction_weight(w.transmitted * world_from_local, vec2(alpha));
        if (dot(w.reflected, s.face_normal) <= 0.0) masking.x = 0.0;
        if (dot(w.transmitted, s.face_normal) >= 0.0) masking.y = 0.0;
    } else {
        // A bent normal can lead to the wrong side of the triangle: the triangle's own does not.
        if (dot(w.reflected, s.face_normal) <= 0.0) w.reflected = reflect(direction, s.face_normal);
        if (!internal && dot(w.transmitted, s.face_normal) >= 0.0) {
            w.transmitted = refract(direction, s.face_normal, 1.0 / eta);
            internal = w.transmitted == vec3(0.0);
        }
    }

    float cos_theta = clamp(-dot(facet, direction), 0.0, 1.0);
    vec3 f = internal ? vec3(1.0)
                      : tint_specular(fresnel_dielectric(cos_theta, eta), m.ior, s.material.specular, m.specular_color);
    vec3 metal = fresnel_schlick(s.material.base_color, 1.0, cos_theta);
    vec3 base = (1.0 - s.material.metallic) * (1.0 - f);
    w.reflection = mix(f, metal, s.material.metallic) * masking.x;
    w.transmission = base * s.material.transmission * s.material.base_color * masking.y;
    w.diffuse = base * (1.0 - s.material.transmission);
    return w;
}
