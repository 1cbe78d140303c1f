// view_depth = last frame's view_depth + an image sampled at the corner that a texel shares with its right lower neighbours.
#include "channels.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 2, binding = 0) uniform sampler2D sampled;

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(ch_view_depth);
    if (any(greaterThanEqual(p, size))) return;
    float s = textureLod(sampled, vec2(p + 1) / vec2(size), 0.0).x;
    imageStore(ch_view_depth, p, vec4(imageLoad(ch_view_depth_prev, p).x + s));
}
