// The effects between the camera and what its rays find: blended over it, and where the one that the eye follows was in the last frame. Extent: split
// frame.
#include "channels.glsl"
#include "frame.glsl"
#include "gbuffer_images.glsl"
#include "gbuffer_records.glsl"
#include "checkerboard.glsl"
#include "effects.glsl"
#include "pixel_ray.glsl"

layout(local_size_x = 8, local_size_y = 4) in;
layout(push_constant, scalar) uniform Push { EffectsPush push; };

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (p.x >= 2 * int(frame.field_width) || p.y >= int(frame.size.y)) return;
    uvec2 key = imageLoad(ch_rng_seed, p).xy;
    CameraRay ray = pixel_ray(split_to_flat(p, int(frame.field_width)), key, push.jitter, push.jitter_per_pixel != 0u).camera;
    vec4 at = imageLoad(ch_shading_position, p);
    float reach = floatBitsToUint(at.w) != 0u ? distance(at.xyz, ray.origin) : SKY_DISTANCE;
    EffectsSeen seen = effects_along(ray.origin, ray.direction, reach);

    vec4 overlay = imageLoad(ch_transparent, p), throughput = imageLoad(ch_throughput, p);
    imageStore(ch_transparent, p, vec4(seen.radiance + seen.transmittance * overlay.rgb, overlay.a));
    imageStore(ch_throughput, p, vec4(throughput.rgb * seen.transmittance, throughput.a));
    vec2 motion = vec2(0.0);
    if (seen.leader != NONE) {
        vec3 now = ray.origin + seen.leader_t * ray.direction;
        vec3 before = now + EffectTable(scene.effects).at[seen.leader].displacement;
        motion = project(frame.camera_prev, before).xy - project(frame.camera, now).xy;
    }
    // Without a leader there is nothing to follow: fog has no motion of its own.
    bool leads = seen.leader != NONE;
    imageStore(im_effects_motion, p, vec4(motion, leads ? luminance(seen.radiance) : 0.0, leads ? 1.0 - seen.transmittance : 0.0));
}
