// A vertex of a path: the surface there, seen from the side that the path comes from, and the media on both sides.
#include "surface.glsl"
#include "bsdf.glsl"
#include "media.glsl"

struct PathVertex {
    vec3 position;
    vec3 position_prev;
    vec3 flat_normal; // on the path's side
    vec3 normal;      // shading normal, likewise
    float twice_area; // of the triangle, m^2
    bool front;       // met on the front side
    bool is_passed;   // a boundary inside of a solid of higher priority: not there for the path
    uint material;
    uint flags;       // MATERIAL_*
    uint nesting;     // MaterialRecord::nesting
    MaterialSample sampled;
    Bsdf bsdf;
};

const Footprint NO_FOOTPRINT = Footprint(vec2(0.0), vec2(0.0), 0.0);

bool bounds_solid(MaterialSample m, float thickness) { return m.transmission > 0.0 && thickness > 0.0; }

uint nesting_priority(uint nesting) { return nesting & 0xffu; }
// Material on the front side of an interface of two solids, NONE: whatever is there.
uint nesting_exterior(uint nesting) { return (nesting >> 8u) - 1u; }

Crossing vertex_crossing(InteriorList list, PathVertex v) {
    uint exterior = nesting_exterior(v.nesting);
    if (exterior != NONE) return v.front ? Crossing(exterior, v.material) : Crossing(v.material, exterior);
    return interior_crossing(list, v.material, nesting_priority(v.nesting), v.front);
}

// After light has passed the surface.
void cross_interface(inout PathState path, PathVertex v) {
    if ((v.bsdf.flags & BSDF_SOLID) == 0u) return;
    uint exterior = nesting_exterior(v.nesting);
    uint around = exterior == NONE ? 0u : nesting_priority(MaterialTable(scene.materials).at[exterior].nesting);
    if (exterior != NONE && v.front) path.interior = interior_cross(path.interior, exterior, around, false);
    path.interior = interior_cross(path.interior, v.material, nesting_priority(v.nesting), v.front);
    if (exterior != NONE && !v.front) path.interior = interior_cross(path.interior, exterior, around, true);
}

// Tangent frame of the BSDF round the shading normal `n`, turned to the direction of anisotropy.
mat3 bsdf_frame(Surface s, vec3 n, LobesSample lobes) {
    if (lobes.anisotropy == 0.0) return basis_around(n);
    mat3 frame = tangent_frame(s);
    vec3 t = frame[0] * lobes.anisotropy_direction.x + frame[1] * lobes.anisotropy_direction.y;
    t -= dot(t, n) * n;
    if (dot(t, t) < 1e-12) return basis_around(n);
    t = normalize(t);
    return mat3(t, cross(n, t), n);
}

PathVertex load_vertex(PathState path, Hit hit) {
    PathVertex v;
    Surface s = load_surface(hit.instance, hit.triangle, hit.barycentrics);
    MaterialTable materials = MaterialTable(scene.materials);
    v.material = s.material;
    v.flags = materials.at[s.material].flags;
    v.nesting = materials.at[s.material].nesting;
    v.position = s.position;
    v.position_prev = s.position_prev;
    v.front = dot(s.flat_normal, path.direction) < 0.0;
    v.flat_normal = v.front ? s.flat_normal : -s.flat_normal;
    v.twice_area = length(cross(s.e1, s.e2));
    v.sampled = load_material(s, NO_FOOTPRINT, 0.0);
    LobesSample lobes = load_lobes(s, NO_FOOTPRINT, 0.0);

    float side = v.front ? 1.0 : -1.0;
    vec3 wo = -path.direction;
    v.normal = bend_normal(side * v.sampled.normal, v.flat_normal, wo);
    v.is_passed = false;
    Bsdf b;
    b.flags = push.energy_compensation != 0u ? BSDF_ENERGY_COMPENSATION : 0u;
    b.eta = v.sampled.ior;
    if (bounds_solid(v.sampled, materials.at[s.material].thickness)) {
        b.flags |= BSDF_SOLID;
        Crossing c = vertex_crossing(path.interior, v);
        v.is_passed = c.front == c.behind;
        b.eta = medium_eta(c);
    }
    b.frame = bsdf_frame(s, v.normal, lobes);
    b.geo_normal = v.flat_normal;
    b.coat_normal = bend_normal(side * lobes.clearcoat_normal, v.flat_normal, wo);
    b.base_color = v.sampled.base_color;
    b.metallic = v.sampled.metallic;
    b.alpha = ggx_alpha(v.sampled.roughness, lobes.anisotropy);
    b.specular = v.sampled.specular;
    b.specular_color = v.sampled.specular_color;
    b.transmission = v.sampled.transmission;
    b.coat = lobes.clearcoat;
    b.coat_alpha = ggx_alpha(lobes.clearcoat_roughness);
    b.sheen_color = lobes.sheen_color;
    b.sheen_alpha = lobes.sheen_roughness * lobes.sheen_roughness;
    v.bsdf = b;
    return v;
}
