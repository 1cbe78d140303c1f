// Light through glass on its straight way to a surface. A thin sheet does not bend light: what it lets through is exact. Through a solid it is
// the light of its middle, without the caustics that refraction makes.
#include "absorption.glsl"
#include "bsdf/model.glsl"
#include "bsdf/refraction.glsl"
#include "media.glsl"
#include "ray_offset.glsl"
#include "reflectance.glsl"
#include "surface.glsl"

// Surfaces that a shadow ray passes at most; what is behind more of them is dark.
const int MAX_GLASS_SURFACES = 8;

// Part of the light that passes the surface. `cos_theta`: to its normal.
vec3 passed_glass(MaterialSample m, float cos_theta, float eta) {
    vec3 f = tint_specular(fresnel_dielectric(cos_theta, eta), m.ior, m.specular, m.specular_color);
    return m.base_color * ((1.0 - m.metallic) * m.transmission * (1.0 - max_component(f)));
}

// Which glass stops light, bits: what bends it, and what scatters it.
const uint STOPS_SMOOTH = 1u, STOPS_ROUGH = 2u;
uint stopping_glass(uint glass_shadows) { return glass_shadows == GLASS_SHADOWS_STRAIGHT ? STOPS_SMOOTH | STOPS_ROUGH : 0u; }

// Whether the surface neither bends nor scatters what it lets through; as interface_transmits_straight() of the BSDF.
bool passes_straight(MaterialSample m, bool solid) { return solid ? is_index_matched(m.ior) : m.roughness < MIRROR_ROUGHNESS; }

// Part of the light along the ray that transmissive surfaces let through. False: the ray has met none. `stopping`: STOPS_*.
bool glass_shadow(Ray ray, uvec2 ray_coverage, uint stopping, out vec3 passed) {
    passed = vec3(1.0);
    for (int i = 0; i < MAX_GLASS_SURFACES; i++) {
        Hit hit = trace_closest(ray, unseen_mask(MASK_TRANSMISSIVE), ray_coverage);
        if (hit.instance == NONE) return i > 0;
        Surface s = load_surface(hit.instance, hit.triangle, hit.barycentrics);
        MaterialSample m = load_material(s, NO_FOOTPRINT, 1.0);
        MaterialRecord record = MaterialTable(scene.materials).at[s.material];
        float cos_theta = -dot(s.face_normal, ray.direction);
        bool solid = is_solid(record), leaves = solid && cos_theta < 0.0;
        if ((stopping & (m.roughness < MIRROR_ROUGHNESS ? STOPS_SMOOTH : STOPS_ROUGH)) != 0u && !passes_straight(m, solid)) break;
        if (leaves) passed *= absorption(record.attenuation_color, record.attenuation_distance, hit.t);
        passed *= passed_glass(m, abs(cos_theta), leaves ? 1.0 / m.ior : m.ior);
        if (max_component(passed) <= 0.0) break;
        ray.origin = offset_point(s.position, cos_theta > 0.0 ? -s.face_normal : s.face_normal, scene.near_origin);
        ray.t_max -= hit.t;
    }
    passed = vec3(0.0);
    return true;
}
