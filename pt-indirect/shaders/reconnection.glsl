// Whether a surface of the G-buffer sees the point of a sample.
#include "trace.glsl"
#include "bounce_path.glsl"
#include "reused_bounce.glsl"

// With the instances and the coverage of the first ray of pixel p: what that has met, a surface in its place sees.
bool sees(ivec2 p, ReuseSurface s, Reservoir r) {
    uvec2 covered = uvec2(0u);
    if (scene_has(FEATURE_COVERAGE)) covered = bounce_coverage(imageLoad(ch_rng_seed, p).xy, 0u, BOUNCE_DIRECTION);
    return !trace_occluded(reconnection_ray(s, r), unseen_mask(0xffu), covered);
}
