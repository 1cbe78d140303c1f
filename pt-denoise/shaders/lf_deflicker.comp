// Limits the luma of a tile of indirect diffuse light to a multiple of the mean of the tiles around it, so that single bright samples do not blink. What exceeds the
// limit is lost. Extent: tiles.
#include "denoise_records.glsl"
layout(local_size_x = 16, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { LfPush push; };
layout(set = 2, binding = 0) uniform sampler2D source_sh;
layout(set = 2, binding = 1) uniform sampler2D source_cocg;
layout(set = 2, binding = 2, rgba32f) uniform writeonly image2D target_sh;
layout(set = 2, binding = 3, rg32f) uniform writeonly image2D target_cocg;
#include "lf_tile.glsl"

void main() {
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(tile, tile_count()))) return;
    ShLight own = ShLight(texelFetch(source_sh, tile, 0), texelFetch(source_cocg, tile, 0).xy);
    float sum = 0.0, count = 0.0;
    for (int i = 0; i < 9; ++i) {
        ivec2 other = tile + ivec2(i % 3, i / 3) - 1;
        if (i == 4 || any(lessThan(other, ivec2(0))) || any(greaterThanEqual(other, tile_count()))) continue;
        if (imageLoad(im_tiles_guide, other).w == 0u) continue;
        sum += texelFetch(source_sh, other, 0).w;
        count += 1.0;
    }
    float limit = push.limit * sum / max(count, 1.0);
    if (count > 0.0 && own.luma.w > limit) scale(own, limit / own.luma.w);
    imageStore(target_sh, tile, own.luma);
    imageStore(target_cocg, tile, vec4(own.chroma, 0.0, 0.0));
}
