// Reuse of the bounces of neighbours, of one pixel: Ouyang et al. 2021, section 4.3, with pairwise weights of multiple importance sampling, each
// neighbour against the pixel itself (Bitterli 2022, "Correlations and Reuse for Fast and Accurate Physically Based Light Transport"; Lin et al. 2022, eq. 36
// to 38, with confidence weights). The samples of all reservoirs are resampled for the pixel with the weights m_i target W_i; for every sample that the pixel
// sees all m_i add up to 1 over the reservoirs that could hold it. Reservoirs that are rejected count nowhere.
//
// A kernel that includes this defines before: sees_in_weight() for targets, and sees_at_last() for the sample that the surface gets its light of.

const uint MAX_RESERVOIRS = 9u; // the pixel's own, then its neighbours'

struct Reservoirs {
    ivec2 at[MAX_RESERVOIRS];
    uint count;
    float candidates; // sum of their M
};

Reservoir load_reservoir(ivec2 p) { return make_reservoir(imageLoad(im_reuse_point, p), imageLoad(im_reuse_light, p)); }

float count_at(ivec2 p) { return float(imageLoad(im_reuse_light, p).w & 0xffffu); }

Reservoirs find_reservoirs(ivec2 p, ReuseSurface s, uvec2 key) {
    Reservoirs found;
    found.at[0] = p;
    found.count = 1u;
    found.candidates = count_at(p);
    uint flags = imageLoad(ch_view_direction, p).y;
    ivec2 here = split_to_flat(p, int(frame.field_width));
    for (uint i = 0u; i < push.restir_counts >> 16u; i++) {
        vec4 xi = random_numbers(key, DIM_REUSE_NEIGHBOURS + i / 2u);
        // Uniform in the disk.
        vec2 offset = push.restir_radius * sample_disk((i & 1u) == 0u ? xi.xy : xi.zw);
        ivec2 at = ivec2(floor(vec2(here) + 0.5 + offset));
        if (at == here || any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(frame.size)))) continue;
        ivec2 q = flat_to_split(at, int(frame.field_width));
        if (imageLoad(im_reuse_surface, q).x == 0u || imageLoad(ch_view_direction, q).y != flags) continue;
        if (!reusable(s, s.depth, load_surface_at(q))) continue;
        found.at[found.count++] = q;
        found.candidates += count_at(q);
    }
    return found;
}

// m_i of the sample of neighbour q, times `target`, that at the pixel. The neighbour sees its own sample.
float neighbour_weight(Reservoirs all, ivec2 q, Reservoir r, float target) {
    float own = count_at(all.at[0]), others = all.candidates - own;
    float there = others * geometric_target(load_surface_at(q), r);
    return there > 0.0 ? float(r.count) / all.candidates * there / (there + own * target) * target : 0.0;
}

// The same of the pixel's own sample.
float own_weight(Reservoirs all, Reservoir r, float target) {
    float own = float(r.count), others = all.candidates - own, sum = own / all.candidates;
    for (uint i = 1u; i < all.count; i++) {
        ReuseSurface s = load_surface_at(all.at[i]);
        float there = geometric_target(s, r);
        if (there > 0.0 && !sees_in_weight(all.at[i], s, r)) there = 0.0;
        sum += count_at(all.at[i]) / all.candidates * own * target / (others * there + own * target);
    }
    return sum * target;
}

// Light that the surface gets along `way` to the sample, over the density per solid angle, its direction, and its distance: what indirect_lighting_reused.comp
// reads.
uvec4 reused_light(ReuseSurface s, Reservoir r) {
    vec3 way = r.position - s.position;
    float squared = dot(way, way);
    vec3 direction = way * inversesqrt(squared);
    vec3 light = r.light * (r.weight * area_to_solid_angle(-dot(r.normal, direction), squared));
    return uvec4(pack_light(light), pack_unit_vector(direction), floatBitsToUint(sqrt(squared)));
}

void reuse_of_neighbours(ivec2 p) {
    Reservoir kept = NO_RESERVOIR;
    ReuseSurface s = load_surface_at(p);
    if (imageLoad(im_reuse_surface, p).x != 0u) {
        uvec2 key = imageLoad(ch_rng_seed, p).xy;
        Reservoirs all = find_reservoirs(p, s, key);
        float xi = random_numbers(key, DIM_REUSE).y, sum = 0.0, kept_target = 0.0;
        for (uint i = 0u; i < all.count; i++) {
            Reservoir r = load_reservoir(all.at[i]);
            if (r.weight <= 0.0) continue;
            float target = geometric_target(s, r), weight;
            if (target <= 0.0) continue;
            if (i == 0u) {
                weight = own_weight(all, r, target);
            } else {
                if (!sees_in_weight(p, s, r)) continue;
                weight = neighbour_weight(all, all.at[i], r, target);
            }
            weight *= luminance(r.light) * r.weight;
            if (!(weight > 0.0)) continue;
            sum += weight;
            float share = weight / sum;
            if (xi < share) {
                xi /= share;
                kept = r;
                kept_target = target * luminance(r.light);
            } else {
                xi = (xi - share) / (1.0 - share);
            }
        }
        kept.weight = kept_target > 0.0 ? sum / kept_target : 0.0;
    }
    bool brings_light = kept.weight > 0.0 && sees_at_last(p, s, kept);
    RowTable(bounce_tables().points).at[path_index(uvec2(p))] = brings_light ? reused_light(s, kept) : uvec4(0u);
}
