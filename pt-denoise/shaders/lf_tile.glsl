// The third of the resolution at which indirect diffuse light is filtered: one texel for each 3 x 3 pixels of the flat frame, a *tile*. A tile
// stands for the surface of its anchor, one of its pixels. The kernel declares `push` with `size`.
#include "checkerboard.glsl"
#include "edge_stopping.glsl"
#include "lf_light.glsl"

const int TILE_SIDE = 3;

int field_width() { return (int(push.size.x) + 1) / 2; }

bool inside(ivec2 pixel) { return all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, ivec2(push.size))); }

ivec2 tile_count() { return (ivec2(push.size) + TILE_SIDE - 1) / TILE_SIDE; }

// The pixel of a tile with number 0 to 8.
ivec2 tile_pixel(ivec2 tile, int number) { return tile * TILE_SIDE + ivec2(number % TILE_SIDE, number / TILE_SIDE); }

// The guide of a flat pixel with its vertex normal: the direction in the coefficients keeps what a normal map does.
Guide lf_guide(ivec2 pixel) { return load_smooth_guide(flat_to_split(pixel, field_width())); }

float lf_weight(Guide p, Guide q, ivec2 offset, float depth, float normal) {
    if (p.normal == 0u || q.normal == 0u || !same_path(p, q, offset)) return 0.0;
    float pixels = max(length(vec2(offset)), 1.0);
    return depth_weight(p, q, pixels, depth) * pow(normal_cosine(p, q), normal);
}
