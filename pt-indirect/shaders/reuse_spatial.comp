// Reuse of the bounces of neighbours without rays: BIASED. Extent: split frame.
layout(local_size_x = 8, local_size_y = 8) in;
#include "bounce_path.glsl"
#include "reused_bounce.glsl"

bool sees_in_weight(ivec2 p, ReuseSurface s, Reservoir r) { return true; }
bool sees_at_last(ivec2 p, ReuseSurface s, Reservoir r) { return true; }

#include "reuse_spatial.glsl"

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(im_reuse_point)))) return;
    reuse_of_neighbours(p);
}
