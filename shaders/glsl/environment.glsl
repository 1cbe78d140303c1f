// Radiance of the lat-long environment. Orientation: v = 0 at +Y, u = 0.5 + atan(z, x) / 2 pi; the rotation is right-handed
// about +Y (counter-clockwise seen from above). The host twin is pt_scene::Environment. Lookups are bilinear: a sampler of the environment has to cover the texels' footprints.
#include "scene.glsl"

// `r`: cosine and sine of the rotation.
vec2 rotated_environment_uv(vec3 direction, vec2 r) {
    vec2 xz = vec2(r.x * direction.x - r.y * direction.z, r.y * direction.x + r.x * direction.z);
    return vec2(0.5 + atan(xz.y, xz.x) / (2.0 * PI), acos(clamp(direction.y, -1.0, 1.0)) * INV_PI);
}

vec2 environment_uv(vec3 direction) { return rotated_environment_uv(direction, scene.environment_rotation); }

vec3 environment_direction(vec2 uv) {
    float phi = (uv.x - 0.5) * 2.0 * PI;
    float theta = uv.y * PI;
    vec2 xz = sin(theta) * vec2(cos(phi), sin(phi));
    vec2 r = scene.environment_rotation;
    return vec3(r.x * xz.x + r.y * xz.y, cos(theta), r.x * xz.y - r.y * xz.x);
}

// Radiance at intensity 1.
vec3 environment_lookup(vec2 uv) { return textureLod(textures[nonuniformEXT(scene.environment_texture)], uv, 0.0).rgb; }

vec3 environment_radiance(vec3 direction) {
    if (scene.environment_intensity <= 0.0) return vec3(0.0);
    return scene.environment_intensity * environment_lookup(environment_uv(direction));
}

// Solid angle of every cell of a row of a lat-long grid: cos(top) - cos(bottom) as a product, which keeps its digits at the poles.
float environment_cell_solid_angle(uvec2 grid, uint row) {
    vec2 size = vec2(grid);
    return 4.0 * PI / size.x * sin(PI * (float(row) + 0.5) / size.y) * sin(0.5 * PI / size.y);
}

// A direction that is uniform in the solid angle of a cell: azimuth and sin^2(theta / 2) are uniform between the cell's borders. Rows below
// the horizon are sampled as their mirror images above, where sin^2(theta / 2) has all its digits. `rotation`: cosine and sine.
vec3 environment_cell_direction(uvec2 grid, uvec2 cell, vec2 rotation, vec2 xi) {
    bool below = 2u * cell.y >= grid.y;
    float mirrored_row = float(below ? grid.y - 1u - cell.y : cell.y);
    float half_step = 0.5 * PI / float(grid.y);
    float k = mix(square(sin(half_step * mirrored_row)), square(sin(half_step * (mirrored_row + 1.0))), xi.y);
    float sin_theta = 2.0 * sqrt(k * (1.0 - k));
    float cos_theta = below ? 2.0 * k - 1.0 : 1.0 - 2.0 * k;
    float phi = 2.0 * PI * ((float(cell.x) + xi.x) / float(grid.x) - 0.5);
    vec2 xz = sin_theta * vec2(cos(phi), sin(phi));
    return vec3(rotation.x * xz.x + rotation.y * xz.y, cos_theta, rotation.x * xz.y - rotation.y * xz.x);
}

// The cell of a direction.
uvec2 environment_cell(uvec2 grid, vec3 direction) { return min(uvec2(environment_uv(direction) * vec2(grid)), grid - 1u); }
