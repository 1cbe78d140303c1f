// A surface that a bounce ray meets: its BSDF, seen from the side that the ray comes from, and the media there.
#include "bounce_path.glsl"
#include "bsdf_surface.glsl"

struct BounceVertex {
    vec3 position;
    float distance;   // from the ray's origin, metres
    float radius;     // of the ray's cone, metres
    float twice_area; // of the triangle, m^2
    bool front;       // met on the front side
    bool solid;       // bounds a medium
    uint material;
    uint flags;       // MATERIAL_*
    InteriorList medium; // what the ray came through
    MaterialSample sampled;
    Bsdf bsdf;
};

BounceVertex load_bounce_vertex(BouncePath path, Hit hit, vec4 texture_random) {
    BounceVertex v;
    vec3 direction = path.ray.direction;
    Surface s = load_surface(hit.instance, hit.triangle, hit.barycentrics);
    v.material = s.material;
    v.flags = MaterialTable(scene.materials).at[s.material].flags;
    v.position = s.position;
    v.distance = distance(s.position, path.ray.origin);
    v.radius = path.cone.x + v.distance * path.cone.y;
    v.front = dot(s.face_normal, direction) < 0.0;
    v.twice_area = length(cross(s.e1, s.e2));
    Footprint footprint = NO_FOOTPRINT;
    if (push.texture_spread > 0.0) footprint = cone_footprint(s, direction, v.radius, texture_random);
    v.sampled = load_material(s, footprint, push.lod_scale);
    v.solid = is_solid(MaterialTable(scene.materials).at[s.material]);
    v.medium = path.interior;
    float eta = surface_eta(path.interior, v.sampled.ior);
    if (v.solid) {
        Crossing c = interior_crossing(path.interior, medium_boundary(s.material), v.front);
        eta = medium_eta(c);
        v.medium = interior_before(path.interior, c);
    }
    v.bsdf = surface_bsdf(s, v.sampled, load_lobes(s, footprint, push.lod_scale), -direction, eta, 0u);
    return v;
}
