// Waves on a liquid: three plane waves of equal steepness that run as those of deep water do (Airy wave theory). Host twin: pt_scene::Waves.
#include "math.glsl"

const vec3 WAVE_ANGLES = vec3(0.3, 1.5, -0.8); // from +X towards +Z
const vec3 WAVE_LENGTHS = vec3(1.0, 0.618, 0.382); // parts of the longest
const float GRAVITY = 9.81;

// Gradient of the height in world space. `slope`: root mean square; `longest`: metres; `time`: seconds.
vec3 wave_gradient(vec3 position, float slope, float longest, float time) {
    vec3 c = cos(WAVE_ANGLES), s = sin(WAVE_ANGLES);
    // In turns, of which only the fraction counts: cosines of large numbers have no precision on some devices.
    vec3 lengths = longest * WAVE_LENGTHS;
    vec3 turns = fract((c * position.x + s * position.z) / lengths - sqrt(GRAVITY / (2.0 * PI * lengths)) * time);
    // The slope of a sine of steepness a has the mean square a^2 / 2.
    vec3 along = slope * sqrt(2.0 / 3.0) * cos(2.0 * PI * turns);
    return vec3(dot(along, c), 0.0, dot(along, s));
}

// Bends a unit normal by the part of the gradient that lies in the surface: Mikkelsen 2020, "Surface Gradient-Based Bump Mapping Framework",
// JCGT 9(3).
vec3 wave_normal(vec3 normal, vec3 position, float slope, float longest, float time) {
    vec3 gradient = wave_gradient(position, slope, longest, time);
    return normalize(normal - (gradient - dot(gradient, normal) * normal));
}
