// The lobes of a mirror or of glass: the direction and the throughput of each.
#include "bsdf/fresnel.glsl"
#include "bsdf/ggx.glsl"
#include "bsdf/refraction.glsl"
#include "gbuffer_store.glsl"

struct InterfaceLobes {
    vec3 reflected;    // unit directions
    vec3 transmitted;
    vec3 reflection;   // weight of each lobe
    vec3 transmission;
    vec3 diffuse;      // without the base colour
    float spread;      // more factor on transmitted radiance; lobes are chosen without it, which would be noise
};

// `eta`: index of refraction behind the surface over that in front, seen along the path. `solid`: light is bent on its way through, and radiance
// changes by 1 / eta^2 (Veach 1997, section 5.2). A thin sheet stands for its two interfaces at once: straight through, F + (1 - F) x base
// colour (KHR_materials_transmission). `twice`: refracted at the shading normal on its way into a thin sheet and at the triangle's on its way
// out, as if the sheet had a relief on one side; where both normals agree that is straight on. `rough`: draw a microfacet with xi instead of
// the smooth interface: Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces".
InterfaceLobes interface_lobes(SeenSurface s, MaterialRecord m, vec3 direction, float eta, bool solid, bool rough, bool twice,
                               vec2 xi) {
    float alpha = square(s.material.roughness);
    mat3 world_from_local = basis_around(s.normal);
    vec3 v = -direction * world_from_local;
    vec3 facet = rough ? world_from_local * sample_ggx_vndf(v, alpha, xi) : s.normal;

    InterfaceLobes w;
    w.reflected = reflect(direction, facet);
    bool bends = solid && !is_index_matched(eta);
    w.transmitted = bends ? refract(direction, facet, 1.0 / eta) : direction;
    if (twice && !solid && !rough) w.transmitted = refract(refract(direction, s.normal, 1.0 / eta), s.face_normal, eta);
    bool internal = w.transmitted == vec3(0.0);
    vec2 masking = vec2(1.0);
    if (rough) {
        if (!solid) w.transmitted = reflect(w.reflected, s.normal);
        masking.x = ggx_reflection_weight(v, w.reflected * world_from_local, vec2(alpha));
        if (bends || !solid) masking.y = ggx_refraction_weight(w.transmitted * world_from_local, vec2(alpha));
        if (dot(w.reflected, s.face_normal) <= 0.0) masking.x = 0.0;
        if (dot(w.transmitted, s.face_normal) >= 0.0) masking.y = 0.0;
    } else {
        // A bent normal can lead to the wrong side of the triangle: the triangle's own does not.
        if (dot(w.reflected, s.face_normal) <= 0.0) w.reflected = reflect(direction, s.face_normal);
        if (!internal && dot(w.transmitted, s.face_normal) >= 0.0) {
            w.transmitted = bends ? refract(direction, s.face_normal, 1.0 / eta) : direction;
            internal = w.transmitted == vec3(0.0);
        }
    }

    float cos_theta = clamp(-dot(facet, direction), 0.0, 1.0);
    vec3 f = internal ? vec3(1.0)
                      : tint_specular(fresnel_dielectric(cos_theta, eta), eta, s.material.specular, s.material.specular_color);
    vec3 metal = fresnel_schlick(s.material.base_color, 1.0, cos_theta);
    float base = (1.0 - s.material.metallic) * (1.0 - max_component(f));
    w.reflection = mix(f, metal, s.material.metallic) * masking.x;
    w.transmission = base * s.material.transmission * s.material.base_color * masking.y;
    w.spread = bends ? 1.0 / square(eta) : 1.0;
    // A black base carries nothing, and so is never chosen.
    bool is_black = max_component(s.material.base_color) <= 0.0;
    w.diffuse = vec3(is_black ? 0.0 : base * (1.0 - s.material.transmission));
    return w;
}
