// Indirect diffuse light at a third of the resolution: joint downsampling (Kopf et al. 2007, "Joint Bilateral Upsampling", the other way). The
// anchor of a tile is its middle pixel or, where that has no light, the first pixel that has. Extent: tiles.
#include "denoise_records.glsl"
layout(local_size_x = 16, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { LfPush push; };
layout(set = 2, binding = 0) uniform sampler2D source_sh;
layout(set = 2, binding = 1) uniform sampler2D source_cocg;
layout(set = 2, binding = 2, rgba32f) uniform writeonly image2D target_sh;
layout(set = 2, binding = 3, rgba32f) uniform writeonly image2D target_cocg;
#include "lf_tile.glsl"

// Light of a flat pixel; w of the chroma, 1 where it has two components, says whether it is known.
bool load_source(ivec2 pixel, out ShLight light) {
    light = NO_LIGHT;
    if (!inside(pixel)) return false;
    ivec2 at = flat_to_split(pixel, field_width());
    vec4 chroma = texelFetch(source_cocg, at, 0);
    light = ShLight(texelFetch(source_sh, at, 0), chroma.xy);
    return chroma.w >= 0.0 && is_light(light) && lf_guide(pixel).normal != 0u;
}

void main() {
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(tile, tile_count()))) return;
    ShLight light;
    int anchor = -1;
    // The middle first.
    for (int i = 0; i < 9 && anchor < 0; ++i) {
        int number = (i + 4) % 9;
        if (load_source(tile_pixel(tile, number), light)) anchor = number;
    }
    ShLight sum = NO_LIGHT;
    float weights = 0.0;
    if (anchor >= 0) {
        ivec2 middle = tile_pixel(tile, anchor);
        Guide p = lf_guide(middle);
        for (int i = 0; i < 9; ++i) {
            ivec2 pixel = tile_pixel(tile, i);
            if (!load_source(pixel, light)) continue;
            float weight = i == anchor ? 1.0 : lf_weight(p, lf_guide(pixel), pixel - middle, push.depth, push.normal);
            add(sum, light, weight);
            weights += weight;
        }
        scale(sum, 1.0 / weights);
    }
    imageStore(target_sh, tile, sum.luma);
    // z: number of the anchor's pixel + 1; 0: the tile has no light.
    imageStore(target_cocg, tile, vec4(sum.chroma, float(anchor + 1), 0.0));
}
