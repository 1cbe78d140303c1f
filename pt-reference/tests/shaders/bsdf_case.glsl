// Surfaces of the tests.
#include "bsdf.glsl"
#include "test_records.glsl"

layout(set = 2, binding = 0, scalar) readonly buffer cases { BsdfCase case_at[]; };

Bsdf test_bsdf(BsdfCase c) {
    LobeWeights none = LobeWeights(0.0, 0.0, LobeProbabilities(0.0, 0.0, 0.0));
    Bsdf b = Bsdf(mat3(1.0), c.face_normal, c.coat_normal, c.base_color, c.metallic, c.alpha, c.eta, c.specular, c.specular_color,
                  c.transmission, c.coat, c.coat_alpha, c.sheen_color, c.sheen_alpha, c.film.x, c.film.y, c.film.z, c.flags, vec3(0.0), vec3(0.0), none);
    return bsdf_towards(b, c.wo);
}

// Where a direction lies in the unit square: polar about the axis, stretched where the lobe is narrow. tan(theta / 2) = w y / (1 - y).
vec2 chart(vec3 axis, float width, vec3 direction) {
    vec3 local = direction * basis_around(axis);
    float azimuth = fract(atan(local.y, local.x) / (2.0 * PI) + 1.0);
    float t = local.z > 0.9 ? length(local.xy) / (1.0 + local.z) : sqrt(max(1.0 - local.z, 0.0) / max(1.0 + local.z, 1e-12));
    return vec2(azimuth, t / (t + width));
}

// The inverse, with the solid angle per unit of area in w.
vec4 chart_direction(vec3 axis, float width, vec2 p) {
    float t = width * p.y / (1.0 - p.y);
    float theta = 2.0 * atan(t), phi = 2.0 * PI * p.x;
    vec3 direction = basis_around(axis) * vec3(sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta));
    float dtheta = 2.0 / (1.0 + t * t) * width / square(1.0 - p.y);
    return vec4(direction, sin(theta) * dtheta * 2.0 * PI);
}
