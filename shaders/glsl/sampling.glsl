// Points and directions from uniform numbers, with their densities. Directions are in a local frame with the normal, or the
// axis, along +Z. The host twins are in pt_lights::oracle::sampling.
#include "math.glsl"

// Barycentric weights of the second and third vertex, uniform in area: Heitz 2019, "A Low-Distortion Map Between Triangle and
// Square".
vec2 sample_triangle(vec2 xi) {
    return xi.y > xi.x ? vec2(0.5 * xi.x, xi.y - 0.5 * xi.x) : vec2(xi.x - 0.5 * xi.y, 0.5 * xi.y);
}

// Uniform in the unit disk: Shirley and Chiu 1997, "A Low Distortion Map Between Disk and Square".
vec2 sample_disk(vec2 xi) {
    vec2 p = 2.0 * xi - 1.0;
    if (p == vec2(0.0)) return vec2(0.0);
    bool wide = abs(p.x) > abs(p.y);
    float radius = wide ? p.x : p.y;
    float phi = wide ? 0.25 * PI * (p.y / p.x) : 0.5 * PI - 0.25 * PI * (p.x / p.y);
    return radius * vec2(cos(phi), sin(phi));
}

// Uniform in the solid angle of a cone about +Z. The cone is given as 1 - cos(half angle), which keeps its digits for cones as
// narrow as the sun's.
vec3 sample_cone(vec2 xi, float one_minus_cos) {
    float k = xi.x * one_minus_cos;
    float sin_theta = sqrt(k * (2.0 - k));
    float phi = 2.0 * PI * xi.y;
    return vec3(sin_theta * cos(phi), sin_theta * sin(phi), 1.0 - k);
}

float cone_pdf(float one_minus_cos) { return 1.0 / (2.0 * PI * one_minus_cos); }

// Density cos(theta) / pi: Malley's method, i.e. the disk projected up.
vec3 sample_cosine_hemisphere(vec2 xi) {
    vec2 d = sample_disk(xi);
    return vec3(d, sqrt(max(0.0, 1.0 - dot(d, d))));
}

float cosine_hemisphere_pdf(float cos_theta) { return max(cos_theta, 0.0) * INV_PI; }

// GGX distribution of normals (Walter et al. 2007, eq. 33). sin^2 is taken from x and y: 1 - h.z^2 has no digits left at the
// peak of a smooth surface.
float ggx_d(float alpha, vec3 h) {
    float a2 = alpha * alpha;
    return a2 / (PI * square(h.z * h.z * a2 + dot(h.xy, h.xy)));
}

// Normal from the distribution of those visible from `v` (v.z > 0): Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with
// Spherical Caps".
vec3 sample_ggx_vndf(vec3 v, float alpha, vec2 xi) {
    vec3 stretched = normalize(vec3(alpha * v.xy, v.z));
    float phi = 2.0 * PI * xi.x;
    float z = (1.0 - xi.y) * (1.0 + stretched.z) - stretched.z;
    float sin_theta = sqrt(clamp(1.0 - z * z, 0.0, 1.0));
    vec3 h = vec3(sin_theta * cos(phi), sin_theta * sin(phi), z) + stretched;
    return normalize(vec3(alpha * h.xy, max(h.z, 0.0)));
}

// Density, per solid angle of l, of reflecting v about such a normal: G1(v) D(h) / (4 v.z) (Heitz 2018, eq. 17).
float ggx_reflection_pdf(vec3 v, vec3 l, float alpha) {
    float a2 = alpha * alpha;
    float g1_over_2cos = 1.0 / (v.z + sqrt(a2 + (1.0 - a2) * v.z * v.z));
    return 0.5 * g1_over_2cos * ggx_d(alpha, normalize(v + l));
}
