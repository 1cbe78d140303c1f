// A list of rays in, a list of hits out, one thread a ray.
#include "trace.glsl"
#include "ray_list_push.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer RayTable { Ray at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer HitTable { Hit at[]; };
layout(push_constant, scalar) uniform Push { RayListPush push; };

uvec2 list_coverage(uint index) { return white_coverage(coverage_seed(uvec2(index, 0u), 0u, push.seed)); }

// False outside of the list.
bool list_index(out uint index) {
    uvec2 id = launch_id();
    index = id.y * push.width + id.x;
    return id.x < push.width && index < push.count;
}
