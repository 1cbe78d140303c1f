// The random numbers of a path: every decision has a dimension of its own.
#include "rng.glsl"

struct PathRandom { uvec2 key; };

PathRandom path_random(uvec2 pixel, uint sample_index) { return PathRandom(uvec2(pixel.x | pixel.y << 16, sample_index)); }

vec4 random_camera(PathRandom r) { return random4(r.key, 0u, frame.seed); }
vec4 random_bsdf(PathRandom r, uint vertex) { return random4(r.key, 4u * vertex + 1u, frame.seed); }
uvec4 random_light(PathRandom r, uint vertex) { return random4_bits(r.key, 4u * vertex + 2u, frame.seed); }
// x: kind of light, y: Russian roulette.
vec2 random_choices(PathRandom r, uint vertex) { return random4(r.key, 4u * vertex + 3u, frame.seed).xy; }

// Of the ray number `segment` of the path, and (shadow = 1) of the shadow ray from where it ends.
uint path_coverage_seed(PathRandom r, uint segment, uint shadow) {
    return coverage_seed(r.key, 0x10000u + 2u * segment + shadow, frame.seed);
}
