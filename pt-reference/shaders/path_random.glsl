#include "rng.glsl"
struct PathRandom { uvec2 key; };
PathRandom path_random(uvec2 pixel, uint s) { return PathRandom(uvec2(pixel.x | pixel.y << 16, s)); }
vec4 random_camera(PathRandom r) { return random4(r.key, 0u, frame.seed); }
