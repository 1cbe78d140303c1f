// Next event estimation with adaptive light proxies, learned over time: after the public description of NEE-AT in NVIDIA's RTX Path
// Tracing 1.8. The split frame is divided into tiles. Each has a list of proxies, indices of local lights with repetition, which
// nee_at_proxies.comp makes each frame from what the samples of last frames found there. A sample is narrow with the tile's share: one of
// the proxies, all with the same probability; else it is global: any light, by power or uniformly. The pmf is that of the mixture,
//
//     pmf = narrow * (proxies of the light) / NEE_AT_PROXIES + (1 - narrow) * global_pmf,
//
// whatever was learned: the estimate stays unbiased, as narrow is never 1 and global_pmf is above 0 for all lights that shine.
//
// Proxies are indices: where the lights are, and how bright, is what the tables of this frame say.
#include "lights/local_lights.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer NeeAtTileTable { NeeAtTile at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer LightFeedbackTable { uvec2 at[]; };

// Number of a tile. Each checkerboard field has tiles of its own: fields may show different surfaces, and the texels of a tile are those
// of a workgroup. `p`: texel of the split frame, which has `size` texels.
uint nee_at_tile_index(ivec2 p, ivec2 size) {
    int field_width = size.x / 2, side = int(NEE_AT_SIDE);
    int columns = (field_width + side - 1) / side;
    int first = p.x < field_width ? 0 : columns;
    return uint(p.y / side * 2 * columns + first + (p.x < field_width ? p.x : p.x - field_width) / side);
}

// Address of the tile of a texel, in the table at `tiles`; 0: there is no table.
uint64_t nee_at_tile(uint64_t tiles, ivec2 p, ivec2 size) {
    return tiles == 0ul ? 0ul : tiles + uint64_t(nee_at_tile_index(p, size)) * uint64_t(NEE_AT_TILE_BYTES);
}

// How many of a tile's proxies are less than `light`.
uint proxies_below(NeeAtTileTable tile, uint light) {
    uint below = 0u;
    for (uint jump = NEE_AT_PROXIES / 2u; jump > 0u; jump /= 2u) {
        if (tile.at[0].lights[below + jump - 1u] < light) below += jump;
    }
    return tile.at[0].lights[below] < light ? below + 1u : below;
}

// Probability of a light if a share of the candidates, `narrow`, comes from the tile's proxies and the rest from all lights.
float nee_at_mixture(NeeAtTileTable tile, uint light, float narrow) {
    float pmf = (1.0 - narrow) * mix(power_pmf(light), 1.0 / float(scene.light_tables.local_light_count), tile.at[0].uniform_share);
    if (narrow <= 0.0) return pmf;
    uint copies = proxies_below(tile, light + 1u) - proxies_below(tile, light);
    return pmf + narrow * (float(copies) / float(NEE_AT_PROXIES));
}

// Probability with which nee_at_pick() returns a light.
float nee_at_pmf(LightContext c, uint light) {
    if (c.tile == 0ul) return power_pmf(light);
    NeeAtTileTable tile = NeeAtTileTable(c.tile);
    return nee_at_mixture(tile, light, tile.at[0].narrow);
}

// The mean of the probabilities among the tile's proxies and among all lights, whatever the tile's share is. No density of samples: it serves
// weights of multiple importance sampling alone.
float nee_at_averaged_pmf(LightContext c, uint light) {
    if (c.tile == 0ul) return power_pmf(light);
    NeeAtTileTable tile = NeeAtTileTable(c.tile);
    return nee_at_mixture(tile, light, tile.at[0].narrow > 0.0 ? 0.5 : 0.0);
}

// A light. There is at least one. `by_power`: a light picked by power.
uint nee_at_pick(LightContext c, uvec4 bits, uint by_power) {
    if (c.tile == 0ul) return by_power;
    NeeAtTileTable tile = NeeAtTileTable(c.tile);
    float xi = unit_from_bits(bits).x, narrow = tile.at[0].narrow;
    if (xi < narrow) return tile.at[0].lights[min(uint(xi / narrow * float(NEE_AT_PROXIES)), NEE_AT_PROXIES - 1u)];
    if ((xi - narrow) / (1.0 - narrow) >= tile.at[0].uniform_share) return by_power;
    uint light, fraction;
    umulExtended(bits.y, scene.light_tables.local_light_count, light, fraction);
    return light;
}

// What a pixel tells the next frame: one of the lights that its samples found, drawn in proportion to what arrived from each, and the sum.
struct LightFeedback { uint light; float weight; };

const LightFeedback NO_FEEDBACK = LightFeedback(NONE, 0.0);

// `weight`: luminance that arrived.
void insert_feedback(inout LightFeedback feedback, uint light, float weight, float xi) {
    // Not what is NaN or infinite, either.
    if (!(weight > 0.0 && weight < 1e30)) return;
    feedback.weight += weight;
    if (xi * feedback.weight < weight) feedback.light = light;
}

// What the pixel's samples before this one have kept.
LightFeedback kept_feedback(uint64_t table, ivec2 p, ivec2 size) {
    if (table == 0ul) return NO_FEEDBACK;
    uvec2 kept = LightFeedbackTable(table).at[p.y * size.x + p.x];
    return LightFeedback(kept.x, uintBitsToFloat(kept.y));
}

void keep_feedback(uint64_t table, ivec2 p, ivec2 size, LightFeedback feedback) {
    if (table == 0ul) return;
    LightFeedbackTable(table).at[p.y * size.x + p.x] = uvec2(feedback.light, floatBitsToUint(feedback.weight));
}
