// The third of the resolution at which indirect diffuse light is filtered: one texel for each 3 x 3 pixels of the flat frame, a *tile*. A tile
// stands for the surface of its anchor, one of its pixels. The kernel declares `push` with `size` and `depth`.
#include "checkerboard.glsl"
#include "denoise_images.glsl"
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

// What the weights know of a pixel: its place in the flat frame; vertex normal; distance; and steepness(), negative: the fields hold two paths, 0: no surface.
struct Anchor { ivec2 pixel; vec3 normal; float depth; float steep; };

const Anchor NO_ANCHOR = Anchor(ivec2(0), vec3(0.0), 0.0, 0.0);

Anchor anchor_of(Guide guide, ivec2 pixel) {
    if (guide.normal == 0u) return NO_ANCHOR;
    return Anchor(pixel, unpack_unit_vector(guide.normal), guide.geometry.x, steepness(guide.geometry.y, push.depth));
}

// The guide of a tile's anchor as im_tiles_guide stores it.
uvec4 tile_guide(Guide guide, int number) { return uvec4(floatBitsToUint(guide.geometry.xy), guide.normal, uint(number) + 1u); }

Anchor load_anchor(ivec2 tile) {
    uvec4 word = imageLoad(im_tiles_guide, tile);
    if (word.w == 0u) return NO_ANCHOR;
    return anchor_of(Guide(vec4(uintBitsToFloat(word.xy), 0.0, 0.0), word.z), tile_pixel(tile, int(word.w) - 1));
}

// The same for (p, q) and (q, p).
float lf_weight(Anchor p, Anchor q, float normal) {
    ivec2 offset = p.pixel - q.pixel;
    bool two_paths = min(p.steep, q.steep) < 0.0 && ((offset.x ^ offset.y) & 1) != 0;
    if (p.steep == 0.0 || q.steep == 0.0 || two_paths) return 0.0;
    float inverse_distance = inversesqrt(max(float(offset.x * offset.x + offset.y * offset.y), 1.0));
    float depth = abs(p.depth - q.depth) * min(abs(p.steep), abs(q.steep)) * inverse_distance;
    return exp2(normal * log2(clamp(dot(p.normal, q.normal), 1e-30, 1.0)) - depth);
}
