// view_depth *= 2, and their sum over the image in 16 partial sums.
#include "channels.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 2, binding = 0, scalar) buffer sums { uint sum[]; };

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(ch_view_depth)))) return;
    float doubled = 2.0 * imageLoad(ch_view_depth, p).x;
    imageStore(ch_view_depth, p, vec4(doubled));
    atomicAdd(sum[p.x & 15], uint(doubled));
}
