// One level of an a-trous filter over indirect diffuse light at a third of the resolution: Dammertz et al. 2010. Taps are push.step tiles apart.
// The weights of a pair are the same both ways, and what a tap may not give stays with the centre: the matrix is symmetric with rows of sum 1,
// so the sum of the light does not change. Extent: tiles.
#include "denoise_records.glsl"
layout(local_size_x = 16, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { LfPush push; };
layout(set = 2, binding = 0) uniform sampler2D source_sh;
layout(set = 2, binding = 1) uniform sampler2D source_cocg;
layout(set = 2, binding = 2, rgba32f) uniform writeonly image2D target_sh;
layout(set = 2, binding = 3, rg32f) uniform writeonly image2D target_cocg;
#include "lf_tile.glsl"

// Binomial, of sum 1 over 3 x 3 taps.
const float KERNEL[2] = float[2](0.5, 0.25);

// Far brighter light is that of another room. The same both ways, so that it keeps the sum.
float leak_guard(float p, float q) {
    float least = min(p, q), greatest = max(p, q);
    return greatest > 0.0 ? clamp(1.5 - 0.25 * greatest / max(least, 1e-20), 0.0, 1.0) : 1.0;
}

void main() {
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(tile, tile_count()))) return;
    ShLight own = ShLight(texelFetch(source_sh, tile, 0), texelFetch(source_cocg, tile, 0).xy);
    Anchor p = load_anchor(tile);
    if (p.steep != 0.0) {
        ShLight change = NO_LIGHT;
        [[unroll]] for (int i = 0; i < 9; ++i) {
            ivec2 offset = ivec2(i % 3, i / 3) - 1, other = tile + offset * int(push.step);
            if (i == 4) continue;
            // All fetches are on their way before the first one is looked at.
            ivec2 at = clamp(other, ivec2(0), tile_count() - 1);
            Anchor q = load_anchor(at);
            ShLight light = ShLight(texelFetch(source_sh, at, 0), texelFetch(source_cocg, at, 0).xy);
            turn_light(light, q.normal, p.normal);
            float weight = at == other ? lf_weight(p, q, push.normal) * KERNEL[abs(offset.x)] * KERNEL[abs(offset.y)] : 0.0;
            if (push.guard != 0u) weight *= leak_guard(own.luma.w, light.luma.w);
            add(change, ShLight(light.luma - own.luma, light.chroma - own.chroma), weight);
        }
        add(own, change, 1.0);
    }
    imageStore(target_sh, tile, own.luma);
    imageStore(target_cocg, tile, vec4(own.chroma, 0.0, 0.0));
}
