// A homogeneous medium between the camera and what its rays find, of single scattering: where a path is scattered, the distance is drawn in
// proportion to the light that the medium takes away there (Pharr, Jakob and Humphreys 2023, section 14.1.2), and a light sample of a directional
// light ends the path. Light that arrives is not weakened: the medium has no border that the sun is outside of.
#include "scattering.glsl"

layout(constant_id = 15) const float medium_density = 0.0; // 1 / m; 0: there is none
layout(constant_id = 17) const float medium_albedo = 0.0;
layout(constant_id = 18) const float medium_anisotropy = 0.0;
layout(constant_id = 19) const float medium_max_distance = 0.0;

// Whether the camera ray is scattered within `reach` metres; if so, after `t`.
bool is_scattered(PathState path, float reach, out float t) {
    t = 0.0;
    if (medium_density <= 0.0 || path.segment != 1u || is_inside(path.interior)) return false;
    t = optical_depth(random_distance(path.random)) / medium_density;
    return t < min(reach, medium_max_distance);
}

// A light sample at the point of the camera ray that is `t` metres away; false: there is none. Extinction and density of the distance cancel,
// the albedo is left.
bool scattered_light(PathState path, float t, out Ray ray, out vec3 radiance) {
    LightSample light = NO_LIGHT_SAMPLE;
    if (kind_on(KIND_SUN)) light = sample_sun(random_light(path.random, 0u));
    if (light.pdf <= 0.0) return false;
    ray = Ray(path.origin + t * path.direction, 0.0, light.direction, SKY_DISTANCE);
    float phase = henyey_greenstein(dot(path.direction, light.direction), medium_anisotropy);
    radiance = light.radiance * (medium_albedo * phase / light.pdf);
    return max_component(radiance) > 0.0;
}
