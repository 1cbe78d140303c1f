// triangle_sampling.glsl from shading points in a cube of side push.parameter round push.vector: a sample, its density by triangle_point_pdf,
// and the solid angle by the corners alone.
#include "lights/triangle_sampling.glsl"
#include "rng.glsl"
#include "test_records.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 8) const uint method = AREA_SAMPLING_UNIFORM;
layout(push_constant, scalar) uniform Push { SamplerPush push; };
// Normal of the receiver, first corner, edges.
layout(set = 2, binding = 0, scalar) readonly buffer triangle { vec3 triangle_at[]; };
layout(set = 2, binding = 1, scalar) writeonly buffer samples { SampleRecord sample_at[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    vec2 xi = random4(uvec2(i, 0u), 0u, push.seed).xy;
    vec3 position = push.vector + push.parameter * (random4(uvec2(i, 1u), 0u, push.seed).xyz - 0.5);
    vec3 normal = triangle_at[0], v0 = triangle_at[1], e1 = triangle_at[2], e2 = triangle_at[3];
    TrianglePoint p = sample_triangle_point(method, position, normal, v0, e1, e2, xi);
    vec3 point = v0 + p.barycentrics.x * e1 + p.barycentrics.y * e2;
    float pdf_again = triangle_point_pdf(method, position, normal, v0, e1, e2, point);
    float solid_angle = triangle_solid_angle(v0 - position, v0 + e1 - position, v0 + e2 - position);
    vec3 place = vec3(p.barycentrics, p.distance);
    sample_at[i] = SampleRecord(p.direction, p.pdf, place, pdf_again, position, floatBitsToUint(solid_angle));
}
