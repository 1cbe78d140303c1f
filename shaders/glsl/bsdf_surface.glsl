// From a hit to a Bsdf:
//
//     Surface s = load_surface(...); MaterialSample m = load_material(...); LobesSample lobes = load_lobes(...);
//     Bsdf b = surface_bsdf(s, m, lobes, wo, eta, flags);
//
// `wo`: unit, away from the surface, to where the path comes from. `eta`: of media.glsl, as is what to do at false hits. `flags`:
// BSDF_ENERGY_COMPENSATION or 0; BSDF_SOLID is set here. A surface has the same lobes on both sides, double-sided or not, but for coat
// and sheen, which a solid has outside only; whether a single-sided one shows its back is the integrator's decision (glTF: culled).
// Light starts beside the triangle: ray_offset.glsl with b.face_normal, on the other side when the sample has SAMPLE_TRANSMISSION.
// KHR_materials_dispersion is in `eta`.
#include "bsdf.glsl"
#include "bsdf/shading_normal.glsl"
#include "media.glsl"
#include "surface.glsl"

Bsdf surface_bsdf(Surface s, MaterialSample m, LobesSample lobes, vec3 wo, float eta, uint flags) {
    Bsdf b;
    float side = dot(s.face_normal, wo) >= 0.0 ? 1.0 : -1.0;
    b.face_normal = side * s.face_normal;
    vec3 normal = bend_normal(side * m.normal, b.face_normal, wo);
    // The tangent of the lobe, in the plane of the bent normal.
    mat3 tangent = tangent_frame(s);
    vec3 along = tangent[0] * lobes.anisotropy_direction.x + tangent[1] * lobes.anisotropy_direction.y;
    along -= dot(along, normal) * normal;
    b.frame = basis_around(normal);
    if (lobes.anisotropy > 0.0 && dot(along, along) > 1e-6) {
        along = normalize(along);
        b.frame = mat3(along, cross(normal, along), normal);
    }
    b.base_color = m.base_color;
    b.metallic = m.metallic;
    b.alpha = ggx_alpha(m.roughness, lobes.anisotropy);
    b.eta = eta;
    b.specular = m.specular;
    b.specular_color = m.specular_color;
    b.transmission = m.transmission;
    bool solid = is_solid(MaterialTable(scene.materials).at[s.material]);
    bool outside = side > 0.0 || !solid;
    b.coat = outside ? lobes.clearcoat : 0.0;
    b.coat_alpha = ggx_alpha(lobes.clearcoat_roughness);
    b.coat_normal = b.coat > 0.0 ? bend_normal(side * lobes.clearcoat_normal, b.face_normal, wo) : normal;
    b.sheen_color = outside ? lobes.sheen_color : vec3(0.0);
    b.sheen_alpha = max(lobes.sheen_roughness * lobes.sheen_roughness, MIN_SHEEN_ALPHA);
    b.iridescence = lobes.iridescence;
    b.film_ior = lobes.iridescence_ior;
    b.film_thickness = lobes.iridescence_thickness;
    b.flags = flags | (solid ? BSDF_SOLID : 0u);
    return bsdf_towards(b, wo);
}
