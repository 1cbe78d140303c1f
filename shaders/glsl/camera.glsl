// Camera rays and projection. UV is the full frame: (0, 0) top left, (1, 1) bottom right; a pixel's area is its unit box.
#include "records.glsl"

struct CameraRay { vec3 origin; vec3 direction; };

vec2 view_plane(CameraRecord camera, vec2 uv) { return vec2(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y) * camera.half_extent; }

// `lens`: point of the unit disk. Thin lens: the ray leaves the lens towards the point in focus (Cook et al. 1984).
CameraRay camera_ray(CameraRecord camera, vec2 uv, vec2 lens) {
    vec2 plane = view_plane(camera, uv);
    vec3 origin = camera.projection == 0u ? vec3(0.0) : vec3(plane, 0.0);
    vec3 direction = camera.projection == 0u ? vec3(plane, -1.0) : vec3(0.0, 0.0, -1.0);
    if (camera.lens_radius > 0.0) {
        vec3 focus = origin + direction * camera.focus_distance;
        origin.xy += lens * camera.lens_radius;
        direction = focus - origin;
    }
    return CameraRay((camera.world_from_view * vec4(origin, 1.0)).xyz, normalize(mat3(camera.world_from_view) * direction));
}

// xy = UV, z = Euclidean distance from the camera (orthographic: from the image plane). The lens plays no part in it.
vec3 project(CameraRecord camera, vec3 world_position) {
    vec3 view = (camera.view_from_world * vec4(world_position, 1.0)).xyz;
    float scale = camera.projection == 0u ? 1.0 / max(-view.z, 1e-18) : 1.0;
    vec2 plane = view.xy * scale / camera.half_extent;
    return vec3(0.5 + 0.5 * plane.x, 0.5 - 0.5 * plane.y, camera.projection == 0u ? length(view) : -view.z);
}

// As project() for a point infinitely far away: UV only.
vec2 project_direction(CameraRecord camera, vec3 world_direction) {
    vec3 view = mat3(camera.view_from_world) * world_direction;
    vec2 plane = view.xy / max(-view.z, 1e-6) / camera.half_extent;
    return vec2(0.5 + 0.5 * plane.x, 0.5 - 0.5 * plane.y);
}

// Radius of the cone round a pixel's ray after `path_length` metres.
float cone_radius(CameraRecord camera, float half_cone_angle, float path_length, uint height) {
    return camera.projection == 0u ? path_length * half_cone_angle : 2.0 * camera.half_extent.y / float(height);
}

// Half angle of the cone round a pixel's ray, from the rays of its right and lower neighbours. Taken as a length rather than
// as acos of a dot product near 1, which has no digits left in fp32.
float pixel_half_cone_angle(CameraRecord camera, vec2 uv, vec2 pixel_uv) {
    if (camera.projection != 0u) return 0.0;
    vec3 d = camera_ray(camera, uv, vec2(0.0)).direction;
    vec3 dx = camera_ray(camera, uv + vec2(pixel_uv.x, 0.0), vec2(0.0)).direction - d;
    vec3 dy = camera_ray(camera, uv + vec2(0.0, pixel_uv.y), vec2(0.0)).direction - d;
    return max(length(dx), length(dy));
}
