// Points and directions from uniform numbers, with their densities. Directions are in a local frame with the normal, or the
// axis, along +Z. The host twins are in pt_light_sampling::oracle::sampling.
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
