// A vertex of a path: the surface there, seen from the side that the path comes from.
#include "surface.glsl"
#include "bsdf.glsl"

struct PathVertex {
    vec3 position;
    vec3 position_prev;
    vec3 flat_normal; // on the path's side
    vec3 normal;      // shading normal, likewise
    float twice_area; // of the triangle, m^2
    bool front;       // met on the front side
    bool is_passed;   // an interface inside a medium of higher priority: not there for the path
    uint flags;       // MATERIAL_*
    MaterialSample material;
    Bsdf bsdf;
};

const Footprint NO_FOOTPRINT = Footprint(vec2(0.0), vec2(0.0), 0.0);

PathVertex load_vertex(PathState path, Hit hit) {
    PathVertex v;
    Surface s = load_surface(hit.instance, hit.triangle, hit.barycentrics);
    v.position = s.position;
    v.position_prev = s.position_prev;
    v.front = dot(s.flat_normal, path.direction) < 0.0;
    v.flat_normal = v.front ? s.flat_normal : -s.flat_normal;
    v.twice_area = length(cross(s.e1, s.e2));
    v.flags = MaterialTable(scene.materials).at[s.material].flags;
    v.is_passed = false;
    v.material = load_material(s, NO_FOOTPRINT, 0.0);
    v.normal = v.front ? v.material.normal : -v.material.normal;
    v.bsdf = Bsdf(v.material.base_color, basis_around(v.normal), -path.direction, v.flat_normal);
    return v;
}

void cross_interface(inout PathState path, PathVertex v) {}

vec4 random_bsdf(PathState path) { return random4(path.random.key, 8u * path.vertex + 1u, frame.seed); }
uvec4 random_light(PathState path) { return random4_bits(path.random.key, 8u * path.vertex + 2u, frame.seed); }
float random_kind(PathState path) { return random4(path.random.key, 8u * path.vertex + 3u, frame.seed).x; }
float random_roulette(PathState path) { return random4(path.random.key, 8u * path.vertex + 3u, frame.seed).y; }
uint path_coverage_seed(PathState path, uint ray) { return coverage_seed(path.random.key, 1024u + 2u * path.segment + ray, frame.seed); }
