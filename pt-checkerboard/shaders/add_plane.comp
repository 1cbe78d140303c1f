// Adds the flat frame of a plane (gbuffer.decomposition=planes) to the sum of those before it, on the flat extent. Each has light that no other one has.
//
// A pixel has one motion, along which temporal anti-aliasing finds its history: that of the plane that holds most of its light, since the others move
// through the picture at other speeds. Planes come one after the other: one that is brighter than the sum so far is brighter than each in it, and where
// none is the motion of plane 0 stays. Alpha is that of plane 0: what it says of the pixel holds for the camera ray, which all planes share.
#include "add_plane_push.glsl"
#include "channels.glsl"
#include "math.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 2, binding = 0, rgba32f) uniform readonly image2D plane_color;
layout(set = 2, binding = 1, rg32f) uniform readonly image2D plane_motion;
layout(push_constant, scalar) uniform Push { AddPlanePush push; };

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(uvec2(pixel), push.size))) return;
    vec3 added = imageLoad(plane_color, pixel).rgb;
    if (added == vec3(0.0)) return;
    vec4 sum = imageLoad(ch_flat_color, pixel);
    if (luminance(added) > luminance(sum.rgb)) imageStore(ch_flat_motion, pixel, imageLoad(plane_motion, pixel));
    imageStore(ch_flat_color, pixel, vec4(sum.rgb + added, sum.a));
}
