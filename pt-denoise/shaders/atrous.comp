// One level of the edge-avoiding a-trous filter for both light channels and their variances (alpha; -1 = missing light), on the flat extent:
// Dammertz et al. 2010, "Edge-Avoiding A-Trous Wavelet Transform", with the variance-guided weights of Schied et al. 2017, section 4.4.
//
// A group filters pixels that are `step` apart, so that its taps are neighbours in the tile at every level: the permutation of Dolp, Hanika
// and Dachsbacher 2024, "Fast SVGF". The first level mixes the two checkerboard fields (the kernel is zero at the checkerboard's frequency);
// the steps of all others are even and stay in the field by themselves.
#include "denoise_records.glsl"

layout(local_size_x = 16, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { AtrousPush push; };
#include "atrous.glsl"

// Taps reach two pixels beyond the group, and the variances of these are smoothed with one more.
const ivec2 TILE = GROUP + 4;
const ivec2 OUTER = GROUP + 6;
// rgb, and inverse_tolerance(); negative: missing.
shared vec4 tile_hf[TILE.x * TILE.y];
shared vec4 tile_spec[TILE.x * TILE.y];
// xyz: Texel::geometry; w: x of the normal.
shared vec4 tile_geometry[TILE.x * TILE.y];
// y and z of the normal. With these the tile fits into the 16384 bytes that every device has.
shared vec2 tile_normal[TILE.x * TILE.y];
// Of both channels, as they are.
shared vec2 tile_variance[OUTER.x * OUTER.y];

// First pixel of the group's lattice. Groups beside each other take the pixels between.
ivec2 group_origin() {
    ivec2 group = ivec2(gl_WorkGroupID.xy), s = ivec2(int(push.step));
    return group % s + group / s * GROUP * s;
}

void load_tile() {
    ivec2 origin = group_origin();
    for (int i = int(gl_LocalInvocationIndex); i < OUTER.x * OUTER.y; i += 128) {
        ivec2 place = ivec2(i % OUTER.x, i / OUTER.x);
        Texel texel = load_texel(origin + (place - 3) * int(push.step));
        tile_variance[i] = vec2(texel.hf.a, texel.spec.a);
        ivec2 inner = place - 1;
        if (all(greaterThanEqual(inner, ivec2(0))) && all(lessThan(inner, TILE))) {
            int k = inner.y * TILE.x + inner.x;
            tile_hf[k] = texel.hf;
            tile_spec[k] = texel.spec;
            tile_geometry[k] = vec4(texel.geometry, texel.normal.x);
            tile_normal[k] = texel.normal.yz;
        }
    }
}

// 3 x 3 binomial filter over the variances that are there (Schied et al. 2017, section 4.4), and the tolerance of the luminance that follows.
void smooth_variances() {
    for (int k = int(gl_LocalInvocationIndex); k < TILE.x * TILE.y; k += 128) {
        ivec2 centre = ivec2(k % TILE.x, k / TILE.x) + 1;
        vec2 sum = vec2(0.0), weights = vec2(0.0);
        for (int i = 0; i < 9; ++i) {
            ivec2 offset = ivec2(i % 3, i / 3) - 1;
            vec2 v = tile_variance[(centre.y + offset.y) * OUTER.x + centre.x + offset.x];
            vec2 w = exp2(float(-abs(offset.x) - abs(offset.y))) * vec2(greaterThanEqual(v, vec2(0.0)));
            sum += w * max(v, 0.0);
            weights += w;
        }
        vec2 inverse = inverse_tolerance(sum / max(weights, 1e-20));
        if (tile_hf[k].a >= 0.0) tile_hf[k].a = inverse.x;
        if (tile_spec[k].a >= 0.0) tile_spec[k].a = inverse.y;
    }
}

void main() {
    load_tile();
    barrier();
    smooth_variances();
    barrier();
    ivec2 local = ivec2(gl_LocalInvocationID.xy);
    ivec2 pixel = group_origin() + local * int(push.step);
    if (!inside(pixel)) return;
    ivec2 at = flat_to_split(pixel, field_width());
    int centre = (local.y + 2) * TILE.x + local.x + 2;
    vec4 hf = tile_hf[centre], spec = tile_spec[centre], geometry = tile_geometry[centre];
    if (geometry.y == 0.0) {
        imageStore(target_hf, at, hf);
        imageStore(target_spec, at, spec);
        return;
    }
    Centre p = centre_at(at, geometry.xyz, vec3(geometry.w, tile_normal[centre]), hf, spec);
    Sum sum_hf = NO_SUM, sum_spec = NO_SUM;
    for (int y = -2; y <= 2; ++y) {
        for (int x = -2; x <= 2; ++x) {
            int i = centre + y * TILE.x + x;
            vec4 q = tile_geometry[i];
            vec2 variance = tile_variance[(local.y + 3 + y) * OUTER.x + local.x + 3 + x];
            add_tap(sum_hf, sum_spec, p, ivec2(x, y), q.xyz, vec3(q.w, tile_normal[i]), tile_hf[i], tile_spec[i], variance);
        }
    }
    vec2 own = tile_variance[(local.y + 3) * OUTER.x + local.x + 3];
    imageStore(target_hf, at, finish(sum_hf, hf, own.x));
    imageStore(target_spec, at, finish(sum_spec, spec, own.y));
}
