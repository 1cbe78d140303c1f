// Surfaces that show what a camera of the scene sees (MaterialRecord.flags).
#include "camera.glsl"
#include "surface.glsl"

bool shows_camera(MaterialRecord m) { return scene_has(FEATURE_CAMERA_VIEWS) && (m.flags >> MATERIAL_CAMERA_SHIFT) != 0u; }

// The ray of the camera that stands for a ray to the point of the surface. Coordinates outside of the picture: its edge.
CameraRay camera_view_ray(MaterialRecord m, Surface s) {
    CameraRecord camera = CameraTable(scene.cameras).at[(m.flags >> MATERIAL_CAMERA_SHIFT) - 1u];
    return camera_ray(camera, clamp(s.uv[0], 0.0, 1.0), vec2(0.0));
}
