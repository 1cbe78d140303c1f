// Reuse of the reservoirs of neighbours by sampler restir-di, without shadow rays. Extent: split frame.
#include "frame.glsl"
#include "reservoir.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { DirectPush push; };

bool visible_from(ivec2 p, LightContext c, Reservoir r) { return true; }

#include "restir_spatial.glsl"

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(im_restir_point)))) return;
    restir_spatial(p);
}
