// Included by atrous_3x3*.comp (RADIUS 1) and atrous_5x5*.comp (RADIUS 2).
//
// One level of the edge-avoiding a-trous filter for both light channels and their variances (alpha; -1 = missing light), on the flat extent:
// Dammertz et al. 2010, "Edge-Avoiding A-Trous Wavelet Transform", with the variance-guided weights of Schied et al. 2017, section 4.4.
//
// A group filters pixels that are `step` apart, so that its taps are neighbours in the tile at every level: the permutation of Dolp, Hanika
// and Dachsbacher 2024, "Fast SVGF". The first level mixes the two checkerboard fields (the kernel is zero at the checkerboard's frequency);
// the steps of all others are even and stay in the field by themselves.
#include "denoise_records.glsl"

// With these sides a tile fits into the 16384 bytes of shared memory that every device has.
const ivec2 GROUP = RADIUS == 1 ? ivec2(16, 8) : ivec2(8, 8);
layout(local_size_x = RADIUS == 1 ? 16 : 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { AtrousPush push; };
#include "atrous.glsl"

const int THREADS = GROUP.x * GROUP.y;
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

// First pixel of the group's lattice. Groups beside each other take the pixels between.
ivec2 group_origin() {
    ivec2 group = ivec2(gl_WorkGroupID.xy);
    int level = findLSB(push.step), between = (1 << level) - 1;
    return (group & between) + ((group >> level) * GROUP << level);
}

void load_tile(ivec2 origin) {
    for (int i = int(gl_LocalInvocationIndex); i < OUTER.x * OUTER.y; i += THREADS) {
        ivec2 place = ivec2(i % OUTER.x, i / OUTER.x), inner = place - 1;
        Texel texel = load_texel(origin + (place - RADIUS - 1) * int(push.step));
        tile_variance[i] = vec2(texel.hf.a, texel.spec.a);
        if (all(greaterThanEqual(inner, ivec2(0))) && all(lessThan(inner, TILE))) {
            int k = inner.y * TILE.x + inner.x;
            tile_surface[k] = texel.surface;
            tile_normal[k] = texel.normal;
            tile_hf[k] = texel.hf;
            tile_spec[k] = texel.spec;
        }
    }
}

// 3 x 3 binomial filter over the variances that are there (Schied et al. 2017, section 4.4), and the tolerance of the luminance that follows.
void smooth_variances() {
    for (int k = int(gl_LocalInvocationIndex); k < TILE.x * TILE.y; k += THREADS) {
        int corner = k / TILE.x * OUTER.x + k % TILE.x;
        vec2 sum = vec2(0.0), weights = vec2(0.0);
        [[unroll]] for (int y = 0; y < 3; ++y) {
            [[unroll]] for (int x = 0; x < 3; ++x) {
                vec2 v = tile_variance[corner + y * OUTER.x + x];
                vec2 w = (x == 1 ? 1.0 : 0.5) * (y == 1 ? 1.0 : 0.5) * vec2(greaterThanEqual(v, vec2(0.0)));
                sum += w * v;
                weights += w;
            }
        }
        vec2 inverse = inverse_tolerance(sum / max(weights, 1e-20), tile_variance[corner + OUTER.x + 1]);
        tile_hf[k].a = inverse.x;
        tile_spec[k].a = inverse.y;
    }
}

void main() {
    ivec2 origin = group_origin();
    load_tile(origin);
    barrier();
    smooth_variances();
    barrier();
    ivec2 local = ivec2(gl_LocalInvocationID.xy);
    ivec2 pixel = origin + local * int(push.step);
    if (!inside(pixel)) return;
    ivec2 at = flat_to_split(pixel, field_width());
    int centre = (local.y + RADIUS) * TILE.x + local.x + RADIUS;
    if (tile_surface[centre].y == 0.0) {
        imageStore(target_hf, at, NO_LIGHT);
        imageStore(target_spec, at, NO_LIGHT);
        return;
    }
    Centre p = centre_of(tile_surface[centre], tile_normal[centre], tile_hf[centre], tile_spec[centre]);
    Sum sum_hf = NO_SUM, sum_spec = NO_SUM;
    int outer = (local.y + RADIUS + 1) * OUTER.x + local.x + RADIUS + 1;
    [[unroll]] for (int y = -RADIUS; y <= RADIUS; ++y) {
        [[unroll]] for (int x = -RADIUS; x <= RADIUS; ++x) {
            int i = centre + y * TILE.x + x;
            vec2 variance = tile_variance[outer + y * OUTER.x + x];
            add_tap(sum_hf, sum_spec, p, ivec2(x, y), tile_surface[i], tile_normal[i], tile_hf[i], tile_spec[i], variance);
        }
    }
    vec2 own = tile_variance[outer];
    imageStore(target_hf, at, encode_light(finish(sum_hf, p.hf, own.x)));
    imageStore(target_spec, at, encode_light(finish(sum_spec, p.spec, own.y)));
}
