// Indirect diffuse light at a third of the resolution: joint downsampling (Kopf et al. 2007, "Joint Bilateral Upsampling", the other way). The
// anchor of a tile is its middle pixel or, where that has no light, the first pixel that has. One thread for each pixel of the flat frame; a group has 8 x 3 tiles.
#include "denoise_records.glsl"
layout(local_size_x = 24, local_size_y = 9) in;
layout(push_constant, scalar) uniform Push { LfPush push; };
layout(set = 2, binding = 0) uniform sampler2D source_sh;
layout(set = 2, binding = 1) uniform sampler2D source_cocg;
layout(set = 2, binding = 2, rgba32f) uniform writeonly image2D target_sh;
layout(set = 2, binding = 3, rg32f) uniform writeonly image2D target_cocg;
#include "lf_tile.glsl"

const ivec2 GROUP = ivec2(24, 9), TILES = GROUP / TILE_SIDE;
// Light of the pixels, weighted; the weight, negative: there is none.
shared vec4 pixel_luma[GROUP.x * GROUP.y];
shared vec2 pixel_chroma[GROUP.x * GROUP.y];
shared float pixel_weight[GROUP.x * GROUP.y];
// xy: Guide::geometry.
shared vec2 pixel_geometry[GROUP.x * GROUP.y];
shared uint pixel_normal[GROUP.x * GROUP.y];

// Light of a flat pixel; w of the chroma, 1 where it has two components, says whether it is known.
bool load_source(ivec2 pixel, Guide guide, out ShLight light) {
    light = NO_LIGHT;
    if (!inside(pixel)) return false;
    ivec2 at = flat_to_split(pixel, field_width());
    vec4 chroma = texelFetch(source_cocg, at, 0);
    light = ShLight(texelFetch(source_sh, at, 0), chroma.xy);
    return chroma.w >= 0.0 && is_light(light) && guide.normal != 0u;
}

// Place in the group of a tile's pixel.
int place_of(ivec2 tile, int number) {
    ivec2 local = tile_pixel(tile, number);
    return local.y * GROUP.x + local.x;
}

// Number of the anchor; -1: no pixel of the tile has light. The middle first.
int anchor_number(ivec2 tile) {
    for (int i = 0; i < 9; ++i) {
        int number = (i + 4) % 9;
        if (pixel_weight[place_of(tile, number)] >= 0.0) return number;
    }
    return -1;
}

Guide guide_of(int place) { return Guide(vec4(pixel_geometry[place], 0.0, 0.0), pixel_normal[place]); }

void main() {
    ivec2 local = ivec2(gl_LocalInvocationID.xy), corner = ivec2(gl_WorkGroupID.xy) * GROUP, pixel = corner + local;
    int own = int(gl_LocalInvocationIndex);
    ShLight light;
    Guide guide = NO_GUIDE;
    if (inside(pixel)) guide = lf_guide(pixel);
    bool known = load_source(pixel, guide, light);
    pixel_geometry[own] = guide.geometry.xy;
    pixel_normal[own] = guide.normal;
    pixel_weight[own] = known ? 1.0 : -1.0;
    barrier();
    float weight = -1.0;
    if (known) {
        ivec2 tile = local / TILE_SIDE;
        int number = anchor_number(tile), place = place_of(tile, number);
        weight = place == own ? 1.0 : lf_weight(anchor_of(guide_of(place), corner + tile_pixel(tile, number)), anchor_of(guide, pixel), push.normal);
        scale(light, weight);
        pixel_luma[own] = light.luma;
        pixel_chroma[own] = light.chroma;
    }
    barrier();
    pixel_weight[own] = weight;
    barrier();
    ivec2 tile = ivec2(own % TILES.x, own / TILES.x), target = ivec2(gl_WorkGroupID.xy) * TILES + tile;
    if (own >= TILES.x * TILES.y || any(greaterThanEqual(target, tile_count()))) return;
    int number = anchor_number(tile);
    ShLight sum = NO_LIGHT;
    float weights = 0.0;
    for (int i = 0; i < 9; ++i) {
        int place = place_of(tile, i);
        if (pixel_weight[place] < 0.0) continue;
        add(sum, ShLight(pixel_luma[place], pixel_chroma[place]), 1.0);
        weights += pixel_weight[place];
    }
    if (number >= 0) scale(sum, 1.0 / weights);
    imageStore(target_sh, target, sum.luma);
    imageStore(target_cocg, target, vec4(sum.chroma, 0.0, 0.0));
    imageStore(im_tiles_guide, target, number < 0 ? uvec4(0u) : tile_guide(guide_of(place_of(tile, number)), number));
}
