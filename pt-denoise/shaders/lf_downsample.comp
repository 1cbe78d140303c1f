// Indirect diffuse light at a third of the resolution: joint downsampling (Kopf et al. 2007, "Joint Bilateral Upsampling", the other way). The
// anchor of a tile is its middle pixel or, where that has no light, the first pixel that has. One thread for each pixel of the flat frame; a group has 8 x 3 tiles.
#include "denoise_records.glsl"
layout(local_size_x = 24, local_size_y = 9) in;
layout(push_constant, scalar) uniform Push { LfPush push; };
layout(set = 2, binding = 0) uniform sampler2D source_sh;
layout(set = 2, binding = 1) uniform sampler2D source_cocg;
layout(set = 2, binding = 2, rgba32f) uniform writeonly image2D target_sh;
layout(set = 2, binding = 3, rg32f) uniform writeonly image2D target_cocg;
#include "history_code.glsl"
#include "lf_tile.glsl"

const ivec2 GROUP = ivec2(24, 9), TILES = GROUP / TILE_SIDE;
// What the pixels hand on takes turns in here, as bits of floats: the less shared memory a group needs, the more groups run at once.
// First: geometry.xy and normal of the guide, and whether there is light. Then what sum_of_tile() sums.
shared uvec4 pixels[GROUP.x * GROUP.y];

// Light of a flat pixel; w of the chroma, 1 where it has two components, says whether it is known.
bool load_source(ivec2 pixel, Guide guide, out ShLight light) {
    light = NO_LIGHT;
    if (!inside(pixel)) return false;
    ivec2 at = flat_to_split(pixel, field_width());
    vec4 luma = texelFetch(source_sh, at, 0), chroma = texelFetch(source_cocg, at, 0);
    light = push.roots != 0u ? ShLight(signed_squares(luma), signed_squares(chroma).xy) : ShLight(luma, chroma.xy);
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
        if (pixels[place_of(tile, number)].w != 0u) return number;
    }
    return -1;
}

Guide guide_of(int place) { return Guide(vec4(uintBitsToFloat(pixels[place].xy), 0.0, 0.0), pixels[place].z); }

// Sum over the tile that the thread stores, if it does. `value`: of its pixel.
vec4 sum_of_tile(vec4 value) {
    int own = int(gl_LocalInvocationIndex);
    barrier();
    pixels[own] = floatBitsToUint(value);
    barrier();
    vec4 sum = vec4(0.0);
    if (own < TILES.x * TILES.y) {
        for (int i = 0; i < 9; ++i) sum += uintBitsToFloat(pixels[place_of(ivec2(own % TILES.x, own / TILES.x), i)]);
    }
    return sum;
}

void main() {
    ivec2 local = ivec2(gl_LocalInvocationID.xy), corner = ivec2(gl_WorkGroupID.xy) * GROUP, pixel = corner + local;
    int own = int(gl_LocalInvocationIndex);
    ShLight light;
    Guide guide = NO_GUIDE;
    if (inside(pixel)) guide = lf_guide(pixel);
    bool known = load_source(pixel, guide, light);
    pixels[own] = uvec4(floatBitsToUint(guide.geometry.xy), guide.normal, known ? 1u : 0u);
    barrier();
    float weight = 0.0;
    if (known) {
        ivec2 tile = local / TILE_SIDE;
        int number = anchor_number(tile), place = place_of(tile, number);
        Anchor anchor = anchor_of(guide_of(place), corner + tile_pixel(tile, number)), here = anchor_of(guide, pixel);
        weight = place == own ? 1.0 : lf_weight(anchor, here, push.normal);
        if (place != own) turn_light(light, here.normal, anchor.normal);
        scale(light, weight);
        if (place == own) imageStore(im_tiles_guide, ivec2(gl_WorkGroupID.xy) * TILES + tile, tile_guide(guide, number));
    } else {
        light = NO_LIGHT;
    }
    vec4 luma = sum_of_tile(light.luma), chroma_and_weight = sum_of_tile(vec4(light.chroma, weight, 0.0));
    ivec2 target = ivec2(gl_WorkGroupID.xy) * TILES + ivec2(own % TILES.x, own / TILES.x);
    if (own >= TILES.x * TILES.y || any(greaterThanEqual(target, tile_count()))) return;
    ShLight sum = ShLight(luma, chroma_and_weight.xy);
    // The anchor, if there is one, has weight 1.
    if (chroma_and_weight.z > 0.0) scale(sum, 1.0 / chroma_and_weight.z);
    else imageStore(im_tiles_guide, target, uvec4(0u));
    imageStore(target_sh, target, sum.luma);
    imageStore(target_cocg, target, vec4(sum.chroma, 0.0, 0.0));
}
