// Rays that leave points of a surface beside it: offset_point() on the side that they go to.
#include "ray_offset.glsl"
#include "records.glsl"
#include "test_records.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { OffsetPush push; };
// A start on the surface, with the direction and the normal that it leaves along.
layout(set = 2, binding = 0, scalar) readonly buffer starts { OffsetStart start_at[]; };
layout(set = 2, binding = 1, scalar) writeonly buffer rays { Ray ray_at[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    OffsetStart s = start_at[i];
    ray_at[i] = Ray(offset_point(s.position, s.normal, 1.0 / 32.0), 0.0, s.direction, 1e30);
}
