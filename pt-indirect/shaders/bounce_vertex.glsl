// A surface that a bounce ray meets: its BSDF, seen from the side that the ray comes from, and the media there.
#include "bsdf_surface.glsl"
#include "indirect_push.glsl"

struct BounceVertex {
    vec3 position;
    float twice_area; // of the triangle, m^2
    bool front;       // met on the front side
    bool solid;       // bounds a medium
    bool is_passed;   // a boundary inside of a stronger solid: not there for the path
    uint material;
    uint flags;       // MATERIAL_*
    InteriorList medium; // what the ray came through
    MaterialSample sampled;
    Bsdf bsdf;
};

// `radius`: of the ray's cone, metres.
BounceVertex load_bounce_vertex(InteriorList interior, vec3 direction, Hit hit, float radius) {
    BounceVertex v;
    Surface s = load_surface(hit.instance, hit.triangle, hit.barycentrics);
    v.material = s.material;
    v.flags = MaterialTable(scene.materials).at[s.material].flags;
    v.position = s.position;
    v.front = dot(s.face_normal, direction) < 0.0;
    v.twice_area = length(cross(s.e1, s.e2));
    Footprint footprint = NO_FOOTPRINT;
    if (push.texture_spread > 0.0) footprint = cone_footprint(s, direction, radius);
    v.sampled = load_material(s, footprint, push.lod_scale);
    v.solid = is_solid(MaterialTable(scene.materials).at[s.material]);
    v.is_passed = false;
    v.medium = interior;
    float eta = surface_eta(interior, v.sampled.ior);
    if (v.solid) {
        Crossing c = interior_crossing(interior, medium_boundary(s.material), v.front);
        v.is_passed = is_false_hit(c);
        eta = medium_eta(c);
        // The path may have begun inside of a solid, which the G-buffer does not tell: its back says so.
        if (c.here.word != interior_top(interior).word) v.medium = interior_add(EMPTY_INTERIOR, c.here);
    }
    v.bsdf = surface_bsdf(s, v.sampled, load_lobes(s, footprint, push.lod_scale), -direction, eta, 0u);
    return v;
}
