// A ray of the G-buffer's path through the solids that it begins in: boundaries inside of a stronger solid are not there for it (media.glsl).
// Radiance is that of a path which ends in vacuum: where a ray goes straight on through what it ignores, the factor by which refraction at the
// boundary changes it counts all the same.
#include "media.glsl"
#include "ray_offset.glsl"
#include "surface.glsl"

// Boundaries that a ray passes at most; what is behind more of them is black.
const uint MAX_BOUNDARIES = 16u;

struct PathSegment {
    Hit hit;              // instance == NONE: the sky
    float reach;          // metres
    vec3 transmittance;   // of the media on the way
    InteriorList interior; // at its end, in front of the surface
};

// Behind the boundary that the ray has met; the ray goes on from there.
InteriorList pass_boundary(InteriorList interior, Surface s, inout Ray ray) {
    bool entering = dot(s.face_normal, ray.direction) < 0.0;
    ray.origin = offset_point(s.position, entering ? -s.face_normal : s.face_normal, scene.near_origin);
    if (!is_solid(MaterialTable(scene.materials).at[s.material])) return interior;
    return interior_cross(interior, medium_boundary(s.material), entering);
}

// Up to the next surface that is there.
PathSegment trace_segment(Ray ray, InteriorList interior, uint mask, uvec2 ray_coverage) {
    PathSegment s = PathSegment(MISS, 0.0, vec3(1.0), interior);
    for (uint i = 0u; i < MAX_BOUNDARIES; i++) {
        s.hit = trace_closest(ray, mask, ray_coverage);
        bool inside = is_inside(s.interior);
        float t = s.hit.instance == NONE ? SKY_DISTANCE : s.hit.t;
        if (inside) s.transmittance *= medium_transmittance(s.interior, t);
        s.reach += t;
        // Outside of all solids every boundary is there.
        if (!inside || s.hit.instance == NONE) return s;
        Surface at = load_surface(s.hit.instance, s.hit.triangle, s.hit.barycentrics);
        if (!is_solid(MaterialTable(scene.materials).at[at.material])) return s;
        bool entering = dot(at.face_normal, ray.direction) < 0.0;
        if (!is_false_hit(interior_crossing(s.interior, medium_boundary(at.material), entering))) return s;
        s.interior = pass_boundary(s.interior, at, ray);
    }
    s.hit = MISS;
    s.transmittance = vec3(0.0);
    return s;
}

// Up to the next surface that transmits nothing, straight on through all that does.
PathSegment trace_last_segment(Ray ray, InteriorList interior, uint mask, uvec2 ray_coverage) {
    PathSegment s = PathSegment(trace_closest(ray, mask, ray_coverage), 0.0, vec3(1.0), interior);
    s.reach = s.hit.instance == NONE ? SKY_DISTANCE : s.hit.t;
    if (!is_inside(interior)) return s;
    float left = s.reach;
    for (uint i = 0u; i < MAX_BOUNDARIES; i++) {
        ray.t_max = left;
        Hit wall = trace_closest(ray, MASK_TRANSMISSIVE, ray_coverage);
        if (wall.instance == NONE) break;
        s.transmittance *= medium_transmittance(s.interior, wall.t);
        left -= wall.t;
        s.interior = pass_boundary(s.interior, load_surface(wall.instance, wall.triangle, wall.barycentrics), ray);
    }
    float eta = interior_top(s.interior).ior / interior_top(interior).ior;
    s.transmittance *= medium_transmittance(s.interior, left) / square(eta);
    return s;
}
