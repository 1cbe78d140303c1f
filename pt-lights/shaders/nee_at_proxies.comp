// The proxies of each tile for this frame (lights/nee_at.glsl). Of the NEE_AT_PROXIES of a tile
//
//   * some come from the feedback of the last frame: that of the texels of the tile and of a margin round it, each where its surface was
//     then, by systematic sampling in proportion to the weights;
//   * some are kept from the list that the tile had then, evenly spread over it, every fourth from the list of a neighbour instead: what
//     one tile finds spreads;
//   * some come from the list of any tile of the picture, or from all lights, by power or uniformly.
//
// Without feedback all that is learned is kept; without an old list all comes from feedback; without either, in the first frame, after a
// reset, in the sky and in the dark, the tile has learned nothing and its samples are global.
//
// Sums are of integers and orders are fixed, so the lists do not depend on the order of the threads. Extent: one workgroup a tile, one
// thread a proxy.
#include "channels.glsl"
#include "checkerboard.glsl"
#include "frame.glsl"
#include "lights/nee_at.glsl"
#include "nee_at_records.glsl"

layout(local_size_x = NEE_AT_PROXIES) in;
layout(push_constant, scalar) uniform Push { NeeAtPush push; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer NeeAtTilesOut { NeeAtTile at[]; };

// Texels of the window whose feedback counts: the tile and a margin as wide as it is.
const int MARGIN = int(NEE_AT_SIDE), WINDOW = 3 * int(NEE_AT_SIDE);
const uint TEXELS = uint(WINDOW * WINDOW);
const uint TEXELS_A_THREAD = (TEXELS + NEE_AT_PROXIES - 1u) / NEE_AT_PROXIES;
// The largest weight as an integer: the sum of all fits into 32 bits.
const float LARGEST = 4194304.0;
// With as many samples that found light, half of the narrow share is trusted.
const float HALF_TRUST = 256.0;
// One of so many kept proxies is a neighbour's.
const uint NEIGHBOUR_STRIDE = 4u;
// Of a texel of the margin, where one of the tile has 1.
const float MARGIN_WEIGHT = 0.25;
// Of the numbers that all proxies of a tile share.
const uint TILE_STREAM = NEE_AT_PROXIES;

shared uint found[TEXELS_A_THREAD * NEE_AT_PROXIES];
shared uint cumulative[TEXELS_A_THREAD * NEE_AT_PROXIES];
shared uint sums[NEE_AT_PROXIES];
shared uint proxies[NEE_AT_PROXIES];
shared uint largest_bits;
shared uint found_count;

uvec4 tile_bits(uint tile, uint stream) {
    return random4_bits(uvec2(tile * (TILE_STREAM + 1u) + stream, frame.frame_index), DIM_NEE_AT, frame.seed);
}

// Where the surface of a texel was in the last frame, as a texel of the same field; whether it was in the picture.
bool texel_before(ivec2 p, int field_width, out ivec2 before) {
    vec2 size = vec2(frame.size);
    vec2 at = vec2(split_to_flat(p, field_width)) + 0.5 + imageLoad(ch_motion, p).xy * size;
    before = ivec2(0);
    if (!(all(greaterThanEqual(at, vec2(0.0))) && all(lessThan(at, size)))) return false;
    before = ivec2(int(at.x) / 2 + (p.x < field_width ? 0 : field_width), int(at.y));
    return true;
}

// Feedback of texel `i` of the window. `first`: the tile's first texel, x within the field.
LightFeedback feedback_at(uint i, ivec2 first, int field, ivec2 size) {
    int field_width = size.x / 2;
    ivec2 p = first + ivec2(int(i) % WINDOW, int(i) / WINDOW) - MARGIN, before;
    if (i >= TEXELS) return NO_FEEDBACK;
    if (any(lessThan(p, ivec2(0))) || p.x >= field_width || p.y >= size.y) return NO_FEEDBACK;
    if (!texel_before(ivec2(p.x + field * field_width, p.y), field_width, before)) return NO_FEEDBACK;
    uvec2 words = LightFeedbackTable(push.feedback).at[before.y * size.x + before.x];
    if (words.x >= scene.light_tables.local_light_count) return NO_FEEDBACK;
    ivec2 inside = p - first;
    bool own = all(greaterThanEqual(inside, ivec2(0))) && all(lessThan(inside, ivec2(NEE_AT_SIDE)));
    return LightFeedback(words.x, uintBitsToFloat(words.y) * (own ? 1.0 : MARGIN_WEIGHT));
}

// Fills `found` and `cumulative`, the inclusive sums of the weights; returns their sum.
uint gather(ivec2 first, int field, ivec2 size) {
    uint thread = gl_LocalInvocationIndex;
    float weights[TEXELS_A_THREAD];
    for (uint i = 0u; i < TEXELS_A_THREAD; i++) {
        uint at = thread * TEXELS_A_THREAD + i;
        LightFeedback feedback = feedback_at(at, first, field, size);
        found[at] = feedback.light;
        weights[i] = feedback.weight;
        // The bits of positive numbers are in their order.
        atomicMax(largest_bits, floatBitsToUint(feedback.weight));
        if (feedback.weight > 0.0) atomicAdd(found_count, 1u);
    }
    barrier();
    float largest = uintBitsToFloat(largest_bits);
    uint parts[TEXELS_A_THREAD], sum = 0u;
    for (uint i = 0u; i < TEXELS_A_THREAD; i++) {
        parts[i] = largest > 0.0 ? uint(weights[i] / largest * LARGEST) : 0u;
        sum += parts[i];
    }
    // Inclusive sums over the threads (Hillis and Steele 1986).
    sums[thread] = sum;
    barrier();
    for (uint distance = 1u; distance < NEE_AT_PROXIES; distance *= 2u) {
        uint left = thread >= distance ? sums[thread - distance] : 0u;
        barrier();
        sums[thread] += left;
        barrier();
    }
    uint running = sums[thread] - sum;
    for (uint i = 0u; i < TEXELS_A_THREAD; i++) cumulative[thread * TEXELS_A_THREAD + i] = running += parts[i];
    barrier();
    return sums[NEE_AT_PROXIES - 1u];
}

// The light whose part of the sum of weights contains `position`.
uint light_at(uint position) {
    uint low = 0u, high = TEXELS - 1u;
    while (low < high) {
        uint middle = (low + high) / 2u;
        if (cumulative[middle] > position) high = middle;
        else low = middle + 1u;
    }
    return found[low];
}

uint high_product(uint a, uint b) {
    uint high, low;
    umulExtended(a, b, high, low);
    return high;
}

uint global_light(uvec4 bits) {
    vec4 xi = unit_from_bits(bits);
    if (xi.y < push.uniform_share) return high_product(bits.z, scene.light_tables.local_light_count);
    return alias_pick(scene.light_tables.local_alias, scene.light_tables.local_light_count, bits.z, xi.w);
}

// Address of the old tile at a texel, x within the field; 0: it is not there or has learned nothing.
uint64_t old_tile(ivec2 p, int field, ivec2 size) {
    int field_width = size.x / 2;
    ivec2 before;
    if (any(lessThan(p, ivec2(0))) || p.x >= field_width || p.y >= size.y) return 0ul;
    if (!texel_before(ivec2(p.x + field * field_width, p.y), field_width, before)) return 0ul;
    uint64_t old = nee_at_tile(push.tiles_before, before, size);
    return NeeAtTileTable(old).at[0].narrow > 0.0 ? old : 0ul;
}

// Bitonic sort (Batcher 1968).
void sort_proxies() {
    uint thread = gl_LocalInvocationIndex;
    for (uint size = 2u; size <= NEE_AT_PROXIES; size *= 2u) {
        for (uint distance = size / 2u; distance > 0u; distance /= 2u) {
            barrier();
            uint other = thread ^ distance;
            uint a = proxies[thread], b = proxies[other];
            if (other > thread && (a > b) == ((thread & size) == 0u)) {
                proxies[thread] = b;
                proxies[other] = a;
            }
        }
    }
    barrier();
}

void main() {
    uint thread = gl_LocalInvocationIndex;
    ivec2 size = imageSize(ch_motion);
    int field_width = size.x / 2, side = int(NEE_AT_SIDE);
    int columns = (field_width + side - 1) / side;
    int field = int(gl_WorkGroupID.x) / columns;
    ivec2 first = side * ivec2(int(gl_WorkGroupID.x) - field * columns, int(gl_WorkGroupID.y));
    uint tile = gl_WorkGroupID.y * uint(2 * columns) + gl_WorkGroupID.x;
    NeeAtTilesOut tiles = NeeAtTilesOut(push.tiles);
    bool blank = push.reset != 0u || scene.light_tables.local_light_count == 0u;

    if (thread == 0u) largest_bits = found_count = 0u;
    barrier();
    uint total = 0u;
    float evidence = 0.0;
    uint64_t old = 0ul;
    ivec2 middle = (first + min(first + side, ivec2(field_width, size.y))) / 2;
    if (!blank) {
        total = gather(first, field, size);
        old = old_tile(middle, field, size);
        if (old != 0ul) evidence = NeeAtTileTable(old).at[0].evidence;
    }
    if (total == 0u && old == 0ul) {
        tiles.at[tile].lights[thread] = 0u;
        if (thread == 0u) {
            tiles.at[tile].narrow = 0.0;
            tiles.at[tile].uniform_share = push.uniform_share;
            tiles.at[tile].evidence = 0.0;
        }
        return;
    }
    evidence = push.history * evidence + float(found_count);
    uint learned = NEE_AT_PROXIES - push.global_proxies;
    uint kept = old == 0ul ? 0u : (total == 0u ? learned : push.kept_proxies);
    uint fresh = learned - kept;
    uvec4 shared_bits = tile_bits(tile, TILE_STREAM), bits = tile_bits(tile, thread);
    uint light;
    if (thread < fresh) {
        // The sum is above the number of proxies: it contains LARGEST.
        uint stride = total / fresh;
        light = light_at(thread * stride + high_product(shared_bits.x, stride));
    } else if (thread < learned) {
        uint place = ((thread - fresh) * 65536u + (shared_bits.y >> 16u)) * NEE_AT_PROXIES / (kept * 65536u);
        uint64_t from = old;
        if (thread % NEIGHBOUR_STRIDE == 0u) {
            ivec2 offset = ivec2(high_product(bits.x, 3u), high_product(bits.y, 3u)) - 1;
            uint64_t neighbour = old_tile(middle + side * offset, field, size);
            if (neighbour != 0ul) from = neighbour;
        }
        light = NeeAtTileTable(from).at[0].lights[place];
    } else {
        // The even ones by power, the odd ones of any tile that has learned something.
        light = global_light(bits);
        uint64_t any_tile = nee_at_tile(push.tiles_before, ivec2(high_product(bits.x, uint(size.x)), high_product(bits.y, uint(size.y))), size);
        if (thread % 2u == 1u && NeeAtTileTable(any_tile).at[0].narrow > 0.0) {
            light = NeeAtTileTable(any_tile).at[0].lights[bits.z % NEE_AT_PROXIES];
        }
    }
    proxies[thread] = light;
    sort_proxies();
    tiles.at[tile].lights[thread] = proxies[thread];
    if (thread == 0u) {
        tiles.at[tile].narrow = push.narrow * evidence / (evidence + HALF_TRUST);
        tiles.at[tile].uniform_share = push.uniform_share;
        tiles.at[tile].evidence = evidence;
    }
}
