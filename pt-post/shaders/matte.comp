// Straight (not premultiplied) radiance and alpha of a frame with a transparent background. Extent: flat frame.
//
// A pixel whose camera ray met no surface is 0 in flat_color, alpha included. The mean over frames is therefore premultiplied: alpha is
// the share of the frames that met a surface. Tone curves are not linear and need the radiance of the surfaces alone: mean / alpha.
// A pixel that is not finite does not count, as in accumulate.comp.
#include "channels.glsl"
#include "finite.glsl"
#include "post_images.glsl"
#include "post_records.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 2, binding = 0) uniform sampler2D resolved;
layout(push_constant, scalar) uniform Push { MattePush push; };

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(im_matte)))) return;

    // x: frames that met a surface, y: all frames.
    vec2 frames = push.reset != 0u ? vec2(0.0) : imageLoad(im_coverage, p).xy;
    vec4 now = imageLoad(ch_flat_color, p);
    if (is_finite(now.rgb)) frames += vec2(now.a != 0.0 ? 1.0 : 0.0, 1.0);
    imageStore(im_coverage, p, vec4(frames, 0.0, 0.0));

    float alpha = frames.y > 0.0 ? frames.x / frames.y : 1.0;
    vec3 premultiplied = texelFetch(resolved, p, 0).rgb;
    imageStore(im_matte, p, vec4(alpha > 0.0 ? premultiplied / alpha : vec3(0.0), alpha));
}
