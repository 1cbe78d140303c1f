// Writes view_depth = x + 1000 y + offset.
#include "channels.glsl"
#include "test_records.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { TestPush push; };

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(ch_view_depth)))) return;
    imageStore(ch_view_depth, p, vec4(float(p.x) + 1000.0 * float(p.y) + push.offset));
}
