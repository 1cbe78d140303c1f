// Included by atrous_3x3*.comp (RADIUS 1) and atrous_5x5*.comp (RADIUS 2).
//
// One level of the edge-avoiding a-trous filter for both light channels and their variances (alpha; -1 = missing light), on the flat extent:
// Dammertz et al. 2010, "Edge-Avoiding A-Trous Wavelet Transform", with the variance-guided weights of Schied et al. 2017, section 4.4.
//
// A group filters pixels that are `step` apart, so that its taps are neighbours in the tile at every level: the permutation of Dolp, Hanika
// and Dachsbacher 2024, "Fast SVGF". The first level mixes the two checkerboard fields (the kernel is zero at the checkerboard's frequency);
// the steps of all others are even and stay in the field by themselves.
//
// A thread filters a block of pixels: a tap that several of them have is read from the tile once, and a pair of them is weighed once.
#include "denoise_records.glsl"

// With these sides a tile fits into the 16384 bytes of shared memory that every device has.
const ivec2 GROUP = RADIUS == 1 ? ivec2(16, 8) : ivec2(8, 8);
#ifndef BLOCK_X
#define BLOCK_X (RADIUS == 1 ? 2 : 1)
#define BLOCK_Y 2
#endif
#ifndef BATCH
#define BATCH 4
#endif
const ivec2 BLOCK = ivec2(BLOCK_X, BLOCK_Y);
layout(local_size_x = (RADIUS == 1 ? 16 : 8) / (BLOCK_X), local_size_y = 8 / (BLOCK_Y)) in;
layout(push_constant, scalar) uniform Push { AtrousPush push; };
#include "atrous.glsl"

const int THREADS = GROUP.x / BLOCK.x * GROUP.y / BLOCK.y;
// Taps reach beyond the group, and the variances of these are smoothed with one more.
const ivec2 TILE = GROUP + 2 * RADIUS;
const ivec2 OUTER = TILE + 2;
// As in Texel; alpha of the light: inverse_tolerance().
shared vec4 tile_surface[TILE.x * TILE.y];
shared vec4 tile_normal[TILE.x * TILE.y];
shared vec4 tile_hf[TILE.x * TILE.y];
shared vec4 tile_spec[TILE.x * TILE.y];
// Of both channels, as they are.
shared vec2 tile_variance[OUTER.x * OUTER.y];

// Places in the tiles. What neighbouring threads read at a time lies side by side, so that they use different banks.
int column(int x, int width) { return x / BLOCK.x + x % BLOCK.x * (width / BLOCK.x); }
int tile_place(ivec2 at) { return at.y * TILE.x + column(at.x, TILE.x); }
int outer_place(ivec2 at) { return at.y * OUTER.x + column(at.x, OUTER.x); }

// First pixel of the group's lattice. Groups beside each other take the pixels between.
ivec2 group_origin() {
    ivec2 group = ivec2(gl_WorkGroupID.xy);
    int level = findLSB(push.step), between = (1 << level) - 1;
    return (group & between) + ((group >> level) * GROUP << level);
}

void store_in_tile(int i, Texel texel) {
    ivec2 at = ivec2(i % OUTER.x, i / OUTER.x), inner = at - 1;
    tile_variance[outer_place(at)] = vec2(texel.hf.a, texel.spec.a);
    if (all(greaterThanEqual(inner, ivec2(0))) && all(lessThan(inner, TILE))) {
        int k = tile_place(inner);
        tile_surface[k] = texel.surface;
        tile_normal[k] = texel.normal;
        tile_hf[k] = texel.hf;
        tile_spec[k] = texel.spec;
    }
}

void load_tile(ivec2 origin) {
    const int COUNT = OUTER.x * OUTER.y;
    // The fetches of some pixels are on their way before the first one is looked at.
    for (int start = int(gl_LocalInvocationIndex); start < COUNT; start += BATCH * THREADS) {
        Fetched fetched[BATCH];
        [[unroll]] for (int n = 0; n < BATCH; ++n) {
            int i = start + n * THREADS;
            fetched[n] = fetch(origin + (ivec2(i % OUTER.x, i / OUTER.x) - RADIUS - 1) * int(push.step));
        }
        [[unroll]] for (int n = 0; n < BATCH; ++n) {
            int i = start + n * THREADS;
            if (i < COUNT) store_in_tile(i, decode(fetched[n]));
        }
    }
}

// 3 x 3 binomial filter over the variances that are there (Schied et al. 2017, section 4.4), and the tolerance of the luminance that follows.
void smooth_variances() {
    for (int i = int(gl_LocalInvocationIndex); i < TILE.x * TILE.y; i += THREADS) {
        ivec2 at = ivec2(i % TILE.x, i / TILE.x);
        vec2 sum = vec2(0.0), weights = vec2(0.0);
        [[unroll]] for (int y = 0; y < 3; ++y) {
            [[unroll]] for (int x = 0; x < 3; ++x) {
                vec2 v = tile_variance[outer_place(at + ivec2(x, y))];
                vec2 w = (x == 1 ? 1.0 : 0.5) * (y == 1 ? 1.0 : 0.5) * vec2(greaterThanEqual(v, vec2(0.0)));
                sum += w * v;
                weights += w;
            }
        }
        vec2 inverse = inverse_tolerance(sum / max(weights, 1e-20), tile_variance[outer_place(at + 1)]);
        int k = tile_place(at);
        tile_hf[k].a = inverse.x;
        tile_spec[k].a = inverse.y;
    }
}

Texel texel_at(ivec2 at) {
    int k = tile_place(at);
    return Texel(tile_surface[k], tile_normal[k], tile_hf[k], tile_spec[k]);
}

void main() {
    ivec2 origin = group_origin();
    load_tile(origin);
    barrier();
    smooth_variances();
    barrier();
    ivec2 first = ivec2(gl_LocalInvocationID.xy) * BLOCK;
    const int PIXELS = BLOCK.x * BLOCK.y;
    Texel own[PIXELS];
    vec2 variances[PIXELS];
    Sums sums[PIXELS];
    bool surface = false;
    [[unroll]] for (int k = 0; k < PIXELS; ++k) {
        ivec2 at = first + ivec2(k % BLOCK.x, k / BLOCK.x);
        own[k] = texel_at(at + RADIUS);
        variances[k] = tile_variance[outer_place(at + RADIUS + 1)];
        sums[k] = NO_SUMS;
        surface = surface || own[k].surface.y != 0.0;
    }
    if (surface) {
        [[unroll]] for (int j = 0; j < PIXELS; ++j) {
            [[unroll]] for (int k = j + 1; k < PIXELS; ++k) {
                ivec2 offset = ivec2(k % BLOCK.x - j % BLOCK.x, k / BLOCK.x - j / BLOCK.x);
                if (max(abs(offset.x), abs(offset.y)) <= RADIUS) add_pair(sums[j], sums[k], own[j], own[k], variances[j], variances[k], offset);
            }
        }
        [[unroll]] for (int y = -RADIUS; y < BLOCK.y + RADIUS; ++y) {
            [[unroll]] for (int x = -RADIUS; x < BLOCK.x + RADIUS; ++x) {
                if (x < 0 || y < 0 || x >= BLOCK.x || y >= BLOCK.y) {
                    ivec2 at = first + ivec2(x, y);
                    Texel q = texel_at(at + RADIUS);
                    vec2 variance = tile_variance[outer_place(at + RADIUS + 1)];
                    [[unroll]] for (int k = 0; k < PIXELS; ++k) {
                        ivec2 offset = ivec2(x - k % BLOCK.x, y - k / BLOCK.x);
                        if (max(abs(offset.x), abs(offset.y)) <= RADIUS) add_tap(sums[k], own[k], q, variance, offset);
                    }
                }
            }
        }
    }
    [[unroll]] for (int k = 0; k < PIXELS; ++k) {
        ivec2 pixel = origin + (first + ivec2(k % BLOCK.x, k / BLOCK.x)) * int(push.step);
        if (inside(pixel)) store(pixel, sums[k], own[k], variances[k]);
    }
}
