// Three backends trace rays behind this interface. A kernel that traces rays (`*.trace`) includes this header and is compiled once for
// each backend. It can call
//
//     Hit trace_closest(Ray ray, uint mask, uvec2 ray_coverage)     nearest hit in [t_min, t_max]; instance == NONE: nothing
//     bool trace_occluded(Ray ray, uint mask, uvec2 ray_coverage)   whether there is any
//     uint trace_blocker(Ray ray, uint mask, uvec2 ray_coverage)    the instance of any hit, not the same in all backends; NONE: no hit
//     uvec2 launch_id()   position in the launch; compute launches round up to whole workgroups, so main() returns when it
//                         lies outside of the extent
//
// Instances take part when (mask & InstanceRecord.mask) != 0. Both sides of a triangle are hit, unless the mask has CULL_BACK_FACES.
// Whichever backend found the triangle, t and the barycentrics come from triangle_intersection().
//
// Rays to infinity (t_max = SKY_DISTANCE) that meet a surface with MATERIAL_SKY have left the scene: no hit. Other rays are stopped by it.
//
// Triangles from first_masked on are there with the probability of their coverage(): MASK materials for all rays or none, BLEND
// materials for a share of them (stochastic transparency: Enderton et al. 2010), so that the mean over rays is the
// "over" operator, in whatever order the surfaces stand. The number that decides is a function of `ray_coverage`, instance and
// triangle alone: it does not depend on the order of traversal, which differs between backends, nor on how often a triangle is met. Rays
// that are to be independent of each other need values of their own: random_coverage() of random.glsl, white_coverage(). A kernel that defines TRACE_OPAQUE
// before takes every triangle for covered.
#include "scene.glsl"
#include "blue_noise.glsl"
#include "opacity.glsl"

// Which rays go through the back faces of single-sided materials (CULLING_*); CULLING_NONE: none, whatever their mask.
layout(constant_id = 2) const uint culling = CULLING_NONE;

bool culls(uint mask) { return culling != CULLING_NONE && (mask & CULL_BACK_FACES) != 0u; }

// Mask of rays that the camera does not see along.
uint unseen_mask(uint mask) { return culling == CULLING_ALL ? mask | CULL_BACK_FACES : mask; }

// Sums and products in a fixed order, so that every backend's kernel computes the same bits.
vec3 fixed_cross(vec3 a, vec3 b) {
    precise vec3 c = fma(a.yzx, b.zxy, -(a.zxy * b.yzx));
    return c;
}

float fixed_dot(vec3 a, vec3 b) {
    precise float d = fma(a.z, b.z, fma(a.y, b.y, a.x * b.x));
    return d;
}

// The ray in an instance's space. The direction keeps its image's length, so that t is the same in both spaces.
Ray object_space_ray(Ray ray, vec4 rows[3]) {
    precise vec3 origin = vec3(fixed_dot(rows[0].xyz, ray.origin) + rows[0].w, fixed_dot(rows[1].xyz, ray.origin) + rows[1].w,
                               fixed_dot(rows[2].xyz, ray.origin) + rows[2].w);
    vec3 direction = vec3(fixed_dot(rows[0].xyz, ray.direction), fixed_dot(rows[1].xyz, ray.direction),
                          fixed_dot(rows[2].xyz, ray.direction));
    return Ray(origin, ray.t_min, direction, ray.t_max);
}

// (u, v, t) where the line of the ray meets the triangle's plane: Moller and Trumbore 1997. The ray's origin is taken relative
// to a vertex and the edges are exact differences, so that the error grows with the distance to the triangle and not with
// the distance of both from the origin of space. Not finite when they are parallel.
vec3 triangle_intersection(Ray ray, vec3 v0, vec3 e1, vec3 e2) {
    vec3 p = fixed_cross(ray.direction, e2);
    precise vec3 s = ray.origin - v0;
    vec3 q = fixed_cross(s, e1);
    precise float inverse = 1.0 / fixed_dot(e1, p);
    precise vec3 uvt = vec3(fixed_dot(s, p), fixed_dot(ray.direction, q), fixed_dot(e2, q)) * inverse;
    return uvt;
}

// A triangle in its object's space: a vertex and two edges.
struct ObjectTriangle { vec3 v0, e1, e2; };

ObjectTriangle object_triangle(MeshRecord mesh, uint triangle) {
    uvec3 index = IndexTable(mesh.indices).at[triangle];
    PositionTable position = PositionTable(mesh.positions);
    vec3 v0 = position.at[index.x];
    return ObjectTriangle(v0, position.at[index.y] - v0, position.at[index.z] - v0);
}

// The hit of a world-space ray on a triangle that a driver's traversal named.
Hit triangle_hit(Ray ray, uint instance, uint triangle) {
    InstanceRecord placed = scene_instance(instance);
    ObjectTriangle t = object_triangle(scene_mesh(placed.mesh), triangle);
    vec3 uvt = triangle_intersection(object_space_ray(ray, placed.object_from_world), t.v0, t.e1, t.e2);
    return Hit(instance, triangle, uvt.xy, uvt.z);
}

// Whether a ray of that direction, in the triangle's space, meets its back. The same products as triangle_intersection has.
bool is_back_face(vec3 direction, vec3 e1, vec3 e2) { return fixed_dot(e1, fixed_cross(direction, e2)) < 0.0; }

bool is_single_sided(InstanceRecord instance, MeshRecord mesh, uint triangle) {
    if ((instance.mask & (MASK_SINGLE_SIDED | MASK_MIXED_SIDES)) != MASK_MIXED_SIDES) return (instance.mask & MASK_SINGLE_SIDED) != 0u;
    MaterialRecord m = MaterialTable(scene.materials).at[material_of(instance, mesh, triangle)];
    return (m.flags & MATERIAL_DOUBLE_SIDED) == 0u && !(m.transmission > 0.0 && m.thickness > 0.0);
}

// Whether a ray of that direction meets the back face of a single-sided triangle.
bool is_culled(uint instance, uint triangle, vec3 direction) {
    InstanceRecord placed = scene_instance(instance);
    MeshRecord mesh = scene_mesh(placed.mesh);
    ObjectTriangle t = object_triangle(mesh, triangle);
    Ray local = object_space_ray(Ray(vec3(0.0), 0.0, direction, 0.0), placed.object_from_world);
    bool back = is_back_face(local.direction, t.e1, t.e2);
    return back && is_single_sided(placed, mesh, triangle);
}

// Whether a ray stops at the point `bary` of a masked triangle.
bool is_covered(MeshRecord mesh, uint instance, uint triangle, vec2 bary, uvec2 ray_coverage) {
    if (scene_has(FEATURE_OPACITY_TABLE) && mesh.opacity != 0ul) {
        uint state = opacity_state(mesh, triangle, bary);
        if (state != OPACITY_UNKNOWN) return state == OPACITY_OPAQUE;
    }
    return coverage_number(ray_coverage, instance, triangle) < coverage(mesh, triangle, bary);
}

// The same for a ray that a driver's traversal is on; the driver's own barycentrics may have other bits.
bool is_hit_covered(Ray ray, uint instance, uint triangle, uvec2 ray_coverage) {
    vec2 bary = triangle_hit(ray, instance, triangle).barycentrics;
    return is_covered(scene_mesh(scene_instance(instance).mesh), instance, triangle, bary, ray_coverage);
}

// Whether a triangle that a driver's traversal has met stops the ray.
bool stops_ray(Ray ray, uint instance, uint triangle, uvec2 ray_coverage, bool cull) {
    if (cull && is_culled(instance, triangle, ray.direction)) return false;
    if (triangle < scene_mesh(scene_instance(instance).mesh).first_masked) return true;
    return is_hit_covered(ray, instance, triangle, ray_coverage);
}

// Drivers number the primitives of each geometry from 0: geometry 0 is [0, first_masked), geometry 1 the masked rest.
uint mesh_triangle(uint instance, uint geometry, uint primitive) {
    if (geometry == 0u) return primitive;
    return primitive + scene_mesh(scene_instance(instance).mesh).first_masked;
}

const Hit MISS = Hit(NONE, NONE, vec2(0.0), 0.0);

#if defined(TRACE_RAY_QUERY) || defined(TRACE_RT_PIPELINE)
// Flags of rays that cull: every triangle comes to a shader.
const uint CULLING_FLAGS = gl_RayFlagsNoOpaqueEXT;
#endif
#ifdef TRACE_COMPUTE
#include "trace/compute.glsl"
#endif
#ifdef TRACE_RAY_QUERY
#include "trace/ray_query.glsl"
#endif
#ifdef TRACE_RT_PIPELINE
#include "trace/rt_pipeline.glsl"
#endif
#if defined(TRACE_RAY_QUERY) || defined(TRACE_RT_PIPELINE)
#include "trace/driver_culling.glsl"
#endif

#if defined(TRACE_COMPUTE) || defined(TRACE_RAY_QUERY) || defined(TRACE_RT_PIPELINE)
// Whether a ray to infinity ends in the environment where it has met a triangle.
bool ends_in_sky(Ray ray, Hit hit) {
    if (hit.instance == NONE || ray.t_max < SKY_DISTANCE) return false;
    InstanceRecord instance = scene_instance(hit.instance);
    uint material = material_of(instance, scene_mesh(instance.mesh), hit.triangle);
    return (MaterialTable(scene.materials).at[material].flags & MATERIAL_SKY) != 0u;
}

Hit trace_closest(Ray ray, uint mask, uvec2 ray_coverage) {
    Hit hit = find_closest(ray, mask, ray_coverage);
    if (scene_has(FEATURE_SKY) && ends_in_sky(ray, hit)) return MISS;
    return hit;
}

// What is behind the sky stops no ray to infinity: such rays need the nearest hit.
bool needs_nearest(Ray ray) { return scene_has(FEATURE_SKY) && ray.t_max >= SKY_DISTANCE; }

uint trace_blocker(Ray ray, uint mask, uvec2 ray_coverage) {
    if (needs_nearest(ray)) return trace_closest(ray, mask, ray_coverage).instance;
    return find_blocker(ray, mask, ray_coverage);
}

bool trace_occluded(Ray ray, uint mask, uvec2 ray_coverage) {
    if (needs_nearest(ray)) return trace_closest(ray, mask, ray_coverage).instance != NONE;
    return find_any(ray, mask, ray_coverage);
}
#endif
