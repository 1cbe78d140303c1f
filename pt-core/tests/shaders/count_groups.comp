// Two kernels in one: the first says how many workgroups the second has, which counts its own.
#include "test_records.glsl"

layout(local_size_x = 4) in;
layout(set = 2, binding = 0, scalar) buffer work { uvec4 groups; uint threads; };
layout(push_constant, scalar) uniform Push { TestPush push; };

void main() {
    if (push.offset > 0.0) groups = uvec4(7u, uint(push.offset), 2u, 1u);
    else atomicAdd(threads, 1u);
}
