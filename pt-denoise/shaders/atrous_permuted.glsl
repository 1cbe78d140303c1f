// Included by atrous_3x3*.comp (RADIUS 1) and atrous_5x5*.comp (RADIUS 2).
//
// One level of the edge-avoiding a-trous filter for both light channels and their variances (alpha; -1 = missing light), on the flat extent:
// Dammertz et al. 2010, "Edge-Avoiding A-Trous Wavelet Transform", with the variance-guided weights of Schied et al. 2017, section 4.4.
//
// A group filters pixels that are `step` apart, so that its taps are neighbours in the tile at every level: the permutation of Dolp, Hanika
// and Dachsbacher 2024, "Fast SVGF". The first level mixes the two checkerboard fields (the kernel is zero at the checkerboard's frequency);
// the steps of all others are even and stay in the field by themselves.
//
// How many groups a multiprocessor holds, and so how well it hides latency, depends on their shared memory. The surfaces, diffuse light and specular light therefore
// take turns in one tile; the weights by the surfaces stay in registers.
#include "denoise_records.glsl"

const ivec2 GROUP = ivec2(16, 8);
layout(local_size_x = 16, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { AtrousPush push; };
#include "atrous.glsl"

const int THREADS = GROUP.x * GROUP.y;
// Taps reach beyond the group, and the variances of these are smoothed with one more.
const ivec2 TILE = GROUP + 2 * RADIUS;
const ivec2 OUTER = TILE + 2;
const int TEXELS = TILE.x * TILE.y, OUTER_TEXELS = OUTER.x * OUTER.y;
// Texels of the outer tile that a thread loads.
const int SLOTS = (OUTER_TEXELS + THREADS - 1) / THREADS;
const int SIDE = 2 * RADIUS + 1, TAPS = SIDE * SIDE;
// Normal and roughness; then light as it is filtered, alpha: inverse_tolerance().
shared vec4 tile[TEXELS];
// Distances, then steepness; then the variances of the outer tile.
shared float tile_scalars[2 * TEXELS];

int own_index() { return int(gl_LocalInvocationIndex); }

// First pixel of the group's lattice. Groups beside each other take the pixels between.
ivec2 group_origin() {
    ivec2 group = ivec2(gl_WorkGroupID.xy);
    int level = findLSB(push.step), between = (1 << level) - 1;
    return (group & between) + ((group >> level) * GROUP << level);
}

// Index in the outer tile of what the thread loads; the last ones are loaded by several.
int outer_index(int slot) { return min(own_index() + slot * THREADS, OUTER_TEXELS - 1); }

ivec2 slot_pixel(int slot) {
    int i = outer_index(slot);
    return group_origin() + (ivec2(i % OUTER.x, i / OUTER.x) - RADIUS - 1) * int(push.step);
}

// Index in the tile; negative: outside.
int slot_texel(int slot) {
    int i = outer_index(slot);
    ivec2 inner = ivec2(i % OUTER.x, i / OUTER.x) - 1;
    return all(greaterThanEqual(inner, ivec2(0))) && all(lessThan(inner, TILE)) ? inner.y * TILE.x + inner.x : -1;
}

Texel texel_at(int k, float angle) { return Texel(tile_scalars[k], tile_scalars[TEXELS + k], tile[k].xyz, tile[k].w, angle); }

// 3 x 3 binomial filter over the variances that are there (Schied et al. 2017, section 4.4), and the tolerance of the luminance that follows.
void smooth_variances(float sigma) {
    for (int k = own_index(); k < TEXELS; k += THREADS) {
        int corner = k / TILE.x * OUTER.x + k % TILE.x;
        float sum = 0.0, weights = 0.0;
        [[unroll]] for (int y = 0; y < 3; ++y) {
            [[unroll]] for (int x = 0; x < 3; ++x) {
                float v = tile_scalars[corner + y * OUTER.x + x];
                float w = v >= 0.0 ? (x == 1 ? 1.0 : 0.5) * (y == 1 ? 1.0 : 0.5) : 0.0;
                sum += w * v;
                weights += w;
            }
        }
        tile[k].a = inverse_tolerance(sigma, sum / max(weights, 1e-20), tile_scalars[corner + OUTER.x + 1]);
    }
}

// One channel, encoded. `light`: what the thread has loaded; `geometric`: weights of the taps; `sigma`: tolerance in standard deviations; `dimension`: of the history, if the
// target is one.
vec4 filtered(vec4 light[SLOTS], float geometric[TAPS], float sigma, ivec2 pixel, uint dimension) {
    // The tile has served.
    barrier();
    [[unroll]] for (int n = 0; n < SLOTS; ++n) {
        int k = slot_texel(n);
        if (k >= 0) tile[k].xyz = light[n].xyz;
        tile_scalars[outer_index(n)] = light[n].a;
    }
    barrier();
    smooth_variances(sigma);
    barrier();
    ivec2 local = ivec2(gl_LocalInvocationID.xy);
    int centre = (local.y + RADIUS) * TILE.x + local.x + RADIUS, outer = (local.y + RADIUS + 1) * OUTER.x + local.x + RADIUS + 1;
    vec4 p = tile[centre];
    Sum sum = NO_SUM;
    [[unroll]] for (int i = 0; i < TAPS; ++i) {
        int x = i % SIDE - RADIUS, y = i / SIDE - RADIUS;
        if (x != 0 || y != 0) add(sum, p, tile[centre + y * TILE.x + x], tile_scalars[outer + y * OUTER.x + x], geometric[i]);
    }
    return encode_light(finish(sum, p, tile_scalars[outer]), pixel, dimension);
}

void main() {
    ivec2 local = ivec2(gl_LocalInvocationID.xy), pixel = group_origin() + local * int(push.step), at = place_of(pixel);
    float angle = load_texel(pixel).angle;
    vec4 hf[SLOTS], spec[SLOTS];
    bool surfaces[SLOTS];
    [[unroll]] for (int n = 0; n < SLOTS; ++n) {
        ivec2 other = slot_pixel(n);
        Texel texel = load_texel(other);
        surfaces[n] = texel.steep != 0.0;
        hf[n] = surfaces[n] ? decode_light(texelFetch(source_hf, place_of(other), 0)) : NO_LIGHT;
        int k = slot_texel(n);
        if (k >= 0) {
            tile[k] = vec4(texel.normal, texel.roughness);
            tile_scalars[k] = texel.distance;
            tile_scalars[TEXELS + k] = texel.steep;
        }
    }
    barrier();
    int centre = (local.y + RADIUS) * TILE.x + local.x + RADIUS;
    Texel p = texel_at(centre, angle);
    float geometric_hf[TAPS], geometric_spec[TAPS];
    [[unroll]] for (int i = 0; i < TAPS; ++i) {
        ivec2 offset = ivec2(i % SIDE, i / SIDE) - RADIUS;
        vec2 geometric = vec2(0.0);
        if (offset != ivec2(0)) geometric = geometric_weights(p, texel_at(centre + offset.y * TILE.x + offset.x, 0.0), offset);
        geometric_hf[i] = geometric.x;
        geometric_spec[i] = geometric.y;
    }
    [[unroll]] for (int n = 0; n < SLOTS; ++n) {
        spec[n] = surfaces[n] ? decode_light(texelFetch(source_spec, place_of(slot_pixel(n)), 0)) : NO_LIGHT;
    }
    vec4 filtered_hf = filtered(hf, geometric_hf, push.luminance_hf, pixel, DIM_HISTORIES + 5u);
    vec4 filtered_spec = filtered(spec, geometric_spec, push.luminance_spec, pixel, DIM_HISTORIES + 6u);
    if (!inside(pixel)) return;
    imageStore(target_hf, at, p.steep == 0.0 ? NO_LIGHT : filtered_hf);
    imageStore(target_spec, at, p.steep == 0.0 ? NO_LIGHT : filtered_spec);
}
