// The random numbers of a path's vertices: each has dimensions of its own (dimensions.rs). Vertex 0 is the surface of the G-buffer.
#include "random.glsl"

const uint BOUNCE_DIRECTION = 0u;     // as bsdf_sample takes them; the ray's coverage
const uint BOUNCE_CHOICES = 1u;       // x: kind of light, y: Russian roulette
const uint BOUNCE_LIGHT = 2u;         // as the samplers of lights.glsl take them
const uint BOUNCE_LIGHT_BY_POWER = 3u;
const uint BOUNCE_SHADOW_RAY = 4u;    // the ray's coverage
const uint BOUNCE_TEXTURES = 5u;      // stochastic texture filter, as DIM_TEXTURE
const uint BOUNCE_CANDIDATES = 8u;    // and the following: of resampled importance sampling

uint bounce_dimension(uint vertex, uint decision) { return DIM_INDIRECT + vertex * BOUNCE_DIMENSIONS + decision; }

vec4 bounce_texture_random(uvec2 key, uint vertex) {
    if (scene_has(FEATURE_TEXTURE_FILTER)) return vec4(0.0);
    return random_numbers(key, bounce_dimension(vertex, BOUNCE_TEXTURES));
}

vec4 bounce_choices(uvec2 key, uint vertex) { return random_numbers(key, bounce_dimension(vertex, BOUNCE_CHOICES)); }
