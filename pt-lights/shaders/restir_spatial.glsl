// Reuse of the reservoirs of neighbours, of one pixel: Bitterli et al. 2020, algorithms 4 to 6, with the weights of multiple importance
// sampling of Lin et al. 2022. A kernel that includes this defines visible_from() before.
//
// The samples of all reservoirs are resampled for the pixel with the weights m_i target W_i. Where all m_i of a sample add up to 1 over
// the reservoirs that could hold it, the result is unbiased:
//     one-over-m   M_i / sum M: reservoirs that could not hold the sample count as well, which loses light
//     balance      M_i target_i / sum_j M_j target_j, the generalised balance heuristic (Lin et al. 2022, eq. 22)
//     pairwise     each neighbour against the pixel itself (Bitterli 2022, "Correlations and Reuse for Fast and Accurate Physically Based
//                  Light Transport"; Lin et al. 2022, eq. 36 to 38, with confidence weights)
// Reservoirs that are rejected count nowhere.

const uint MAX_RESERVOIRS = 9u; // the pixel's own, then its neighbours'

struct Reservoirs {
    ivec2 at[MAX_RESERVOIRS];
    uint count;
    float candidates; // sum of their M
};

Reservoir load_reservoir(ivec2 p) {
    return make_reservoir(imageLoad(im_restir_temporal_point, p).xy, imageLoad(im_restir_temporal_weight, p).xy);
}

// Target at reservoir's pixel p, with what its point sees if visibility is among the weights.
float target_at(ivec2 p, Reservoir r) {
    LightContext c = load_context(p);
    float target = sample_target(c, r.light, r.numbers, push.kinds);
    return target > 0.0 && visible_from(p, c, r) ? target : 0.0;
}

// Flat offset from the pixel: uniform in the disk.
vec2 neighbour_offset(vec2 xi) { return push.restir_radius * sample_disk(xi); }

Reservoirs find_reservoirs(ivec2 p, uvec2 key) {
    Reservoirs found;
    found.at[0] = p;
    found.count = 1u;
    found.candidates = float(imageLoad(im_restir_temporal_weight, p).y);
    vec3 normal = unpack_unit_vector(imageLoad(ch_normal, p).x);
    float depth = imageLoad(ch_view_depth, p).x;
    uint flags = imageLoad(ch_view_direction, p).y;
    ivec2 here = split_to_flat(p, int(frame.field_width));
    for (uint i = 0u; i < push.restir_spatial; i++) {
        vec4 xi = random_numbers(key, DIM_RESTIR_NEIGHBOURS + i / 2u);
        ivec2 at = ivec2(floor(vec2(here) + 0.5 + neighbour_offset((i & 1u) == 0u ? xi.xy : xi.zw)));
        if (at == here || any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(frame.size)))) continue;
        ivec2 q = flat_to_split(at, int(frame.field_width));
        uint count = imageLoad(im_restir_temporal_weight, q).y;
        if (count == 0u || imageLoad(ch_view_direction, q).y != flags) continue;
        if (!reusable(normal, unpack_unit_vector(imageLoad(ch_normal, q).x), depth, imageLoad(ch_view_depth, q).x)) continue;
        found.at[found.count++] = q;
        found.candidates += float(count);
    }
    return found;
}

// Weight m_i of the sample of reservoir i in multiple importance sampling, times its target at the pixel, `target`.
float weighted_target(Reservoirs all, uint i, Reservoir r, float target) {
    if (push.restir_weights == RESTIR_WEIGHTS_ONE_OVER_M) return float(r.count) / all.candidates * target;
    float own = float(imageLoad(im_restir_temporal_weight, all.at[0]).y);
    if (push.restir_weights == RESTIR_WEIGHTS_PAIRWISE && i > 0u) {
        float others = all.candidates - own;
        float there = others * target_at(all.at[i], r);
        return float(r.count) / all.candidates * there / (there + own * target) * target;
    }
    // Both need the targets of a sample at many pixels: balance of every sample at all, pairwise of the pixel's own at the neighbours.
    float sum = own * target, pairs = own / all.candidates, mine = i == 0u ? own * target : 0.0;
    for (uint j = 1u; j < all.count; j++) {
        float count = float(imageLoad(im_restir_temporal_weight, all.at[j]).y);
        float there = target_at(all.at[j], r);
        sum += count * there;
        if (j == i) mine = count * there;
        pairs += count / all.candidates * own * target / ((all.candidates - own) * there + own * target);
    }
    return (push.restir_weights == RESTIR_WEIGHTS_PAIRWISE ? pairs : mine / sum) * target;
}

void restir_spatial(ivec2 p) {
    Reservoir kept = NO_RESERVOIR;
    Reservoir own = load_reservoir(p);
    if (own.count > 0u) {
        uvec2 key = imageLoad(ch_rng_seed, p).xy;
        Reservoirs all = find_reservoirs(p, key);
        float xi = random_numbers(key, DIM_RESTIR).z, sum = 0.0, kept_target = 0.0;
        for (uint i = 0u; i < all.count; i++) {
            Reservoir r = load_reservoir(all.at[i]);
            if (r.weight <= 0.0) continue;
            float target = target_at(p, r);
            if (target <= 0.0) continue;
            float weight = weighted_target(all, i, r, target) * r.weight;
            if (weight <= 0.0) continue;
            sum += weight;
            float share = weight / sum;
            if (xi < share) {
                xi /= share;
                kept = r;
                kept_target = target;
            } else {
                xi = (xi - share) / (1.0 - share);
            }
        }
        kept.weight = kept_target > 0.0 ? sum / kept_target : 0.0;
        kept.count = uint(all.candidates);
    }
    imageStore(im_restir_point, p, uvec4(reservoir_point(kept), 0u, 0u));
    imageStore(im_restir_weight, p, uvec4(reservoir_weight(kept), 0u, 0u));
    // What was tested in this frame's scene is no sample of a point that may see more in the next one.
    if (push.restir_visibility == RESTIR_VISIBILITY_IN_WEIGHT) kept = own;
    imageStore(im_restir_history_point, p, uvec4(reservoir_point(kept), 0u, 0u));
    imageStore(im_restir_history_weight, p, uvec4(reservoir_weight(kept), 0u, 0u));
}
