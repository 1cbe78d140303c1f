// Runs clusters.glsl on positions from the host.
#include "clusters.glsl"

layout(local_size_x = 64) in;
layout(set = 2, binding = 0, scalar) readonly buffer positions { vec3 position[]; };
layout(set = 2, binding = 1, scalar) writeonly buffer clusters { uint cluster[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < uint(position.length())) cluster[i] = cluster_of(position[i]);
}
