// Indirect diffuse light from a third of the resolution to all pixels: joint bilateral upsampling (Kopf et al. 2007) from the four tiles around,
// guided by distance and vertex normal. A pixel that resembles none of them keeps its own light. Extent: the flat frame.
#include "denoise_images.glsl"
#include "denoise_records.glsl"
layout(local_size_x = 16, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { LfPush push; };
layout(set = 2, binding = 0) uniform sampler2D source_sh;
layout(set = 2, binding = 1) uniform sampler2D source_cocg;
layout(set = 2, binding = 2) uniform sampler2D tiles_sh;
layout(set = 2, binding = 3) uniform sampler2D tiles_cocg;
#include "lf_tile.glsl"

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!inside(pixel)) return;
    ivec2 at = flat_to_split(pixel, field_width());
    Guide p = lf_guide(pixel);
    ShLight light = NO_LIGHT;
    float weights = 0.0;
    vec2 place = (vec2(pixel) - 1.0) / float(TILE_SIDE);
    ivec2 corner = ivec2(floor(place));
    vec2 f = place - vec2(corner);
    for (int i = 0; i < 4; ++i) {
        ivec2 offset = ivec2(i & 1, i >> 1);
        ivec2 tile = clamp(corner + offset, ivec2(0), tile_count() - 1);
        vec4 chroma = texelFetch(tiles_cocg, tile, 0);
        if (chroma.z == 0.0) continue;
        ivec2 anchor = tile_pixel(tile, int(chroma.z) - 1);
        float weight = (offset.x == 1 ? f.x : 1.0 - f.x) * (offset.y == 1 ? f.y : 1.0 - f.y);
        weight *= lf_weight(p, lf_guide(anchor), anchor - pixel, push.depth, push.normal);
        add(light, ShLight(texelFetch(tiles_sh, tile, 0), chroma.xy), weight);
        weights += weight;
    }
    if (weights > 1e-4) {
        scale(light, 1.0 / weights);
    } else {
        vec4 chroma = texelFetch(source_cocg, at, 0);
        light = ShLight(texelFetch(source_sh, at, 0), chroma.xy);
        if (p.normal == 0u || chroma.w < 0.0 || !is_light(light)) light = NO_LIGHT;
    }
    imageStore(im_filtered_lf_sh, at, light.luma);
    imageStore(im_filtered_lf_cocg, at, vec4(light.chroma, 0.0, 0.0));
}
