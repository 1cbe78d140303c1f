// Indirect diffuse light from a third of the resolution to all pixels: joint bilateral upsampling (Kopf et al. 2007) from the four tiles around,
// guided by distance and vertex normal. A pixel that resembles none of them keeps its own light. Extent: the flat frame.
#include "denoise_records.glsl"
layout(local_size_x = 16, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { LfPush push; };
layout(set = 2, binding = 0) uniform sampler2D source_sh;
layout(set = 2, binding = 1) uniform sampler2D source_cocg;
layout(set = 2, binding = 2) uniform sampler2D tiles_sh;
layout(set = 2, binding = 3) uniform sampler2D tiles_cocg;
#include "history_code.glsl"
#include "lf_tile.glsl"

// The tiles around the pixels of a group.
const ivec2 GROUP = ivec2(16, 8), TILES = (GROUP + TILE_SIDE - 2) / TILE_SIDE + 2;
shared ivec2 tile_anchor[TILES.x * TILES.y];
// Anchor: normal, then distance; and its steepness.
shared vec4 tile_surface[TILES.x * TILES.y];
shared float tile_steep[TILES.x * TILES.y];
shared vec4 tile_luma[TILES.x * TILES.y];
shared vec2 tile_chroma[TILES.x * TILES.y];

// The tile left of and above a pixel's place between the middles of the tiles.
ivec2 corner_tile(ivec2 pixel) { return (pixel + TILE_SIDE - 1) / TILE_SIDE - 1; }

void load_tiles(ivec2 first) {
    for (int i = int(gl_LocalInvocationIndex); i < TILES.x * TILES.y; i += GROUP.x * GROUP.y) {
        ivec2 tile = clamp(first + ivec2(i % TILES.x, i / TILES.x), ivec2(0), tile_count() - 1);
        Anchor anchor = load_anchor(tile);
        tile_anchor[i] = anchor.pixel;
        tile_surface[i] = vec4(anchor.normal, anchor.depth);
        tile_steep[i] = anchor.steep;
        tile_luma[i] = texelFetch(tiles_sh, tile, 0);
        tile_chroma[i] = texelFetch(tiles_cocg, tile, 0).xy;
    }
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), first = corner_tile(ivec2(gl_WorkGroupID.xy) * GROUP);
    load_tiles(first);
    barrier();
    if (!inside(pixel)) return;
    ivec2 at = flat_to_split(pixel, field_width());
    Guide guide = lf_guide(pixel);
    Anchor p = anchor_of(guide, pixel);
    ShLight light = NO_LIGHT;
    float weights = 0.0;
    ivec2 corner = corner_tile(pixel);
    vec2 f = (vec2(pixel) - 1.0) / float(TILE_SIDE) - vec2(corner);
    [[unroll]] for (int i = 0; i < 4; ++i) {
        ivec2 offset = ivec2(i & 1, i >> 1), place = corner + offset - first;
        int k = place.y * TILES.x + place.x;
        Anchor q = Anchor(tile_anchor[k], tile_surface[k].xyz, tile_surface[k].w, tile_steep[k]);
        float weight = (offset.x == 1 ? f.x : 1.0 - f.x) * (offset.y == 1 ? f.y : 1.0 - f.y);
        weight *= lf_weight(p, q, push.normal);
        ShLight tile = ShLight(tile_luma[k], tile_chroma[k]);
        turn_light(tile, q.normal, p.normal);
        add(light, tile, weight);
        weights += weight;
    }
    if (weights > 1e-4) {
        scale(light, 1.0 / weights);
    } else {
        vec4 luma = texelFetch(source_sh, at, 0), chroma = texelFetch(source_cocg, at, 0);
        light = push.roots != 0u ? ShLight(signed_squares(luma), signed_squares(chroma).xy) : ShLight(luma, chroma.xy);
        if (guide.normal == 0u || chroma.w < 0.0 || !is_light(light)) light = NO_LIGHT;
    }
    imageStore(im_filtered_lf_sh, at, light.luma);
    imageStore(im_filtered_lf_cocg, at, vec4(light.chroma, 0.0, 0.0));
}
