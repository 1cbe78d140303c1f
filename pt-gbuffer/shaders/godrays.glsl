// What the two passes of the god rays share: which way of a camera ray is in the medium, and which pixels are marched.
#include "channels.glsl"
#include "frame.glsl"
#include "gbuffer_images.glsl"
#include "gbuffer_records.glsl"
#include "scattering.glsl"
#include "scene.glsl"

layout(push_constant, scalar) uniform Push { GodraysPush push; };

// Metres that the camera ray of a split pixel is in the medium: none inside of solids.
float medium_length(ivec2 p) {
    if (scene_has(FEATURE_TRANSMISSION) && imageLoad(ch_interior, p).x != 0u) return 0.0;
    return min(imageLoad(ch_view_depth, p).x, push.max_distance);
}

// The pixel of the flat frame that stands for the block `q` of 2 x 2: each of the four once in four frames.
ivec2 marched_pixel(ivec2 q) {
    uint i = frame.frame_index;
    return min(2 * q + ivec2(i & 1u, (i ^ i >> 1u) & 1u), ivec2(frame.size) - 1);
}
