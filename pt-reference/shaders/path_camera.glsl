// Camera rays: the start of paths.
#include "camera.glsl"
#include "sampling.glsl"

// Box filter of one pixel, thin lens.
CameraRay sample_camera_ray(uvec2 pixel, vec4 xi) {
    vec2 uv = (vec2(pixel) + xi.xy) / vec2(frame.size);
    return camera_ray(frame.camera, uv, sample_disk(xi.zw));
}

// As the real-time stages take it.
vec2 pixel_cone(uvec2 pixel) {
    vec2 size = vec2(frame.size);
    if (frame.camera.projection != 0u) return vec2(2.0 * frame.camera.half_extent.y / size.y, 0.0);
    return vec2(0.0, pixel_half_cone_angle(frame.camera, (vec2(pixel) + 0.5) / size, 1.0 / size));
}

PathState start_path(uvec2 pixel, uint sample_index) {
    PathState path;
    path.random = path_random(pixel, sample_index);
    CameraRay camera = sample_camera_ray(pixel, random_camera(path.random));
    path.origin = camera.origin;
    path.direction = camera.direction;
    path.throughput = vec3(1.0);
    path.last_pdf = 0.0;
    path.passed = 0.0;
    path.chord = 0.0;
    path.glossy = vec3(0.0);
    path.flags = PATH_DELTA | PATH_SEEN;
    path.vertex = 0u;
    path.segment = 0u;
    path.shadow_rays = 0u;
    path.sample_index = sample_index;
    path.interior = EMPTY_INTERIOR;
    if (scene_has(FEATURE_TRANSMISSION)) path.interior = InteriorList(push.camera_solids, push.camera_iors);
    path.cone = vec2(0.0);
    if (ray_cones) path.cone = pixel_cone(pixel);
    return path;
}
