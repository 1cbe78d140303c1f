// A vertex of a path: the surface there, seen from the side that the path comes from, and the media on both sides.
#include "bsdf_surface.glsl"

struct PathVertex {
    vec3 position;
    vec3 face_normal; // on the path's side
    float twice_area; // of the triangle, m^2
    bool front;       // met on the front side
    bool disperses;   // its index of refraction is that of one channel alone
    bool is_passed;   // a boundary inside of a stronger solid: not there for the path
    uint material;
    uint flags;       // MATERIAL_*
    MaterialSample sampled;
    Bsdf bsdf;
};

// After light has passed the surface.
void cross_interface(inout PathState path, PathVertex v) {
    if ((v.bsdf.flags & BSDF_SOLID) == 0u) return;
    path.interior = interior_cross(path.interior, medium_boundary(v.material), v.front);
}

// `channel`: the one that counts where colours part.
PathVertex load_vertex(PathState path, Hit hit, uint channel) {
    PathVertex v;
    Surface s = load_surface(hit.instance, hit.triangle, hit.barycentrics);
    v.material = s.material;
    v.flags = MaterialTable(scene.materials).at[s.material].flags;
    v.position = s.position;
    v.front = dot(s.face_normal, path.direction) < 0.0;
    v.face_normal = v.front ? s.face_normal : -s.face_normal;
    v.twice_area = length(cross(s.e1, s.e2));
    // What the pixel's own samples do not average is not averaged.
    Footprint footprint = NO_FOOTPRINT;
    if (ray_cones) footprint = cone_footprint(s, path.direction, path.cone.x, vec4(0.0));
    v.sampled = load_material(s, footprint, 1.0);
    v.is_passed = false;
    v.disperses = false;
    float eta = surface_eta(path.interior, v.sampled.ior);
    if (is_solid(MaterialTable(scene.materials).at[s.material])) {
        Crossing c = interior_crossing(path.interior, medium_boundary(s.material), v.front);
        v.is_passed = is_false_hit(c);
        eta = channel_ior(c.beyond, channel) / channel_ior(c.here, channel);
        v.disperses = !v.is_passed && channel_ior(c.beyond, 0u) / channel_ior(c.here, 0u) != channel_ior(c.beyond, 2u) / channel_ior(c.here, 2u);
    }
    uint flags = 0u;
    if (energy_compensation) flags = BSDF_ENERGY_COMPENSATION;
    v.bsdf = surface_bsdf(s, v.sampled, load_lobes(s, footprint, 1.0), -path.direction, eta, flags);
    return v;
}
