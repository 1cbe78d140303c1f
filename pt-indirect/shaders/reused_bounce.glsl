// Reservoirs of `reuse=restir-gi` (Ouyang et al. 2021, "ReSTIR GI: Path Resampling for Real-Time Path Tracing"). A sample is the point that the first
// ray of a path has met, and the light that leaves it; a surface of the G-buffer reconnects to it in a straight line.
//
// Everything has the measure of area at that point: a sample is the same for all surfaces, and what papers call the Jacobian of the reconnection
// (Lin et al. 2022, eq. 14) is the quotient of two area_to_solid_angle().
//
// The target of a sample x with light L at the surface p is
//
//     target_p(x) = cos_p dw/dA luminance(L)      where p sees x, and 0 elsewhere
//
// L is random, and its distribution depends on the surface that has drawn it, but not its mean. That is enough: weights of multiple importance sampling are
// quotients of targets, L cancels out, and so they are functions of the point alone.
#include "channels.glsl"
#include "checkerboard.glsl"
#include "indirect_images.glsl"
#include "math.glsl"
#include "pack.glsl"
#include "packed_light.glsl"
#include "sampling.glsl"

struct Reservoir {
    vec3 position;
    vec3 normal;     // of the triangle, on the side that the light leaves
    float least_cosine; // from where on the point is seen as reusable_light.glsl wants it
    vec3 light;      // radiance
    float weight;    // estimate of 1 / density of the sample, m^2
    uint count;      // candidates that it stands for; 0: no reservoir
};

const Reservoir NO_RESERVOIR = Reservoir(vec3(0.0), vec3(0.0), 1.0, vec3(0.0), 0.0, 0u);

uvec4 reservoir_point(Reservoir r) { return uvec4(floatBitsToUint(r.position), pack_unit_vector(r.normal)); }

uvec4 reservoir_light(Reservoir r) {
    uint least = uint(ceil(clamp(r.least_cosine, 0.0, 1.0) * 65535.0));
    return uvec4(pack_light(r.light), floatBitsToUint(r.weight), r.count | least << 16u);
}

Reservoir make_reservoir(uvec4 point, uvec4 light) {
    return Reservoir(uintBitsToFloat(point.xyz), unpack_unit_vector(point.w), float(light.w >> 16u) / 65535.0, unpack_light(light.xy),
                     uintBitsToFloat(light.z), light.w & 0xffffu);
}

// A surface of the G-buffer, as its images say, so that whoever looks at a pixel sees the same.
struct ReuseSurface {
    vec3 position;
    float depth;      // from the camera, metres; as channel view_depth, negative for what mirrors show
    vec3 face_normal;
    vec3 normal;      // shading normal
};

ReuseSurface make_surface(vec3 position, float depth, uvec2 normals) {
    return ReuseSurface(position, depth, unpack_unit_vector(normals.x), unpack_unit_vector(normals.y));
}

ReuseSurface load_surface_at(ivec2 p) {
    return make_surface(imageLoad(ch_shading_position, p).xyz, imageLoad(ch_view_depth, p).x, imageLoad(im_reuse_surface, p).xy);
}

// Solid angle at a distance that an area stands for, per m^2.
float area_to_solid_angle(float cosine, float squared_distance) { return cosine / squared_distance; }

// Target of a sample at a surface without the luminance of its light; 0 where the surface does not draw it or does not reconnect to it: below
// its horizon, at the back of the point or too flat there, or too near, where the quotients of solid angles have no bounds (Lin et al. 2022, section 7.2).
float geometric_target(ReuseSurface s, Reservoir r) {
    vec3 way = r.position - s.position;
    float squared = dot(way, way);
    if (!(squared > square(push.restir_distance * s.depth))) return 0.0;
    vec3 direction = way * inversesqrt(squared);
    float cosine = dot(s.normal, direction), other = -dot(r.normal, direction);
    if (cosine <= 0.0 || dot(s.face_normal, direction) <= 0.0 || other <= r.least_cosine) return 0.0;
    return cosine * area_to_solid_angle(other, squared);
}

// The ray that tells whether the surface sees the point.
Ray reconnection_ray(ReuseSurface s, Reservoir r) {
    vec3 origin = offset_point(s.position, s.face_normal, scene.near_origin);
    vec3 way = offset_point(r.position, r.normal, scene.near_origin) - origin;
    float distance = length(way);
    return Ray(origin, 0.0, way / distance, distance);
}

// How far reuse reaches, as of direct lighting: surfaces must face about the same way (cosine), and their distances from the camera must be near each
// other. The choice does not look at samples, so it brings no bias.
const float REUSE_COSINE = 0.9;
const float REUSE_DEPTH = 0.1;

// `depth`: of the surface for which another one's reservoir is taken.
bool reusable(ReuseSurface s, float depth, ReuseSurface other) {
    return dot(s.normal, other.normal) >= REUSE_COSINE && abs(depth - other.depth) <= REUSE_DEPTH * abs(depth);
}
