// Radiance of the lat-long environment. Orientation: v = 0 at +Y, u = 0.5 + atan(z, x) / 2 pi; the rotation is right-handed
// about +Y (counter-clockwise seen from above). The host twin is pt_scene::Environment. Lookups are bilinear: a sampler of the environment has to cover the texels' footprints.
#include "scene.glsl"

vec2 environment_uv(vec3 direction) {
    vec2 r = scene.environment_rotation;
    vec2 xz = vec2(r.x * direction.x - r.y * direction.z, r.y * direction.x + r.x * direction.z);
    return vec2(0.5 + atan(xz.y, xz.x) / (2.0 * PI), acos(clamp(direction.y, -1.0, 1.0)) * INV_PI);
}

vec3 environment_direction(vec2 uv) {
    float phi = (uv.x - 0.5) * 2.0 * PI;
    float theta = uv.y * PI;
    vec2 xz = sin(theta) * vec2(cos(phi), sin(phi));
    vec2 r = scene.environment_rotation;
    return vec3(r.x * xz.x + r.y * xz.y, cos(theta), r.x * xz.y - r.y * xz.x);
}

vec3 environment_radiance(vec3 direction) {
    if (scene.environment_intensity <= 0.0) return vec3(0.0);
    return scene.environment_intensity *
           textureLod(textures[nonuniformEXT(scene.environment_texture)], environment_uv(direction), 0.0).rgb;
}
