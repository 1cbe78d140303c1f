// Choice of a local light among those that the point's cluster may see, as in Quake II RTX: the list is divided into subsets of at most
// 8 lights with a stride, one subset is picked, and one of its lights in proportion to candidate_mass(). Without statistics the subsets are
// picked uniformly, else they have their weights too (subsets.glsl). Lights that the
// list leaves out are found by the catch-all: with its probability the light is picked by power among all.
//
// A list has places: the lights that stand still in ascending order, then those that may change. What stands still is stored subset by subset, so that
// the candidates of a choice lie side by side.
#include "lights/local_lights.glsl"
#include "lights/statistics.glsl"
#include "lights/subsets.glsl"

const uint CLUSTER_CANDIDATES = 8u;

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer ListRankTable { uvec2 at[]; };

ClusterListRecord cluster_list(uint cluster) { return ClusterListTable(choice_tables().cluster_lists).at[cluster]; }

uint cluster_list_size(ClusterListRecord list) { return list.count + list.moving_count; }

// Number of subsets of so many lights: their stride.
uint subset_count(uint lights) { return max((lights + CLUSTER_CANDIDATES - 1u) / CLUSTER_CANDIDATES, 1u); }

uint cluster_stride(ClusterListRecord list) { return subset_count(cluster_list_size(list)); }

// Where the lights that stand still of a subset begin, if the list has `subsets` of them.
uint first_entry(ClusterListRecord list, uint subset, uint subsets) {
    return list.first + subset * (list.count / subsets) + min(subset, list.count % subsets);
}

// Light that stands still at a place of the list.
uint fixed_light(ClusterListRecord list, uint place) {
    uint subsets = subset_count(list.count);
    return UintTable(choice_tables().cluster_entries).at[first_entry(list, place % subsets, subsets) + place / subsets];
}

uint moving_light(ClusterListRecord list, uint place) {
    return UintTable(choice_tables().cluster_moving_entries).at[list.moving_first + place];
}

// Light at a place of the list.
uint cluster_list_light(ClusterListRecord list, uint place) {
    return place < list.count ? fixed_light(list, place) : moving_light(list, place - list.count);
}

// Place of a light among those that stand still, or among the others; NONE: it is not there.
uint search_place(ClusterListRecord list, bool moving, uint light) {
    uint low = 0u, count = moving ? list.moving_count : list.count, high = count;
    while (low < high) {
        uint middle = (low + high) / 2u;
        if ((moving ? moving_light(list, middle) : fixed_light(list, middle)) < light) low = middle + 1u;
        else high = middle;
    }
    return low < count && (moving ? moving_light(list, low) : fixed_light(list, low)) == light ? low : NONE;
}

// Place of a light in the list of a cluster, NONE: it is not there.
uint cluster_list_place(ClusterListRecord list, uint cluster, uint light) {
    uint place;
    if (choice_tables().cluster_ranks != 0ul) {
        uvec2 word = ListRankTable(choice_tables().cluster_ranks).at[cluster * choice_tables().cluster_rank_words + light / 32u];
        uint bit = 1u << (light & 31u);
        place = (word.x & bit) != 0u ? word.y + bitCount(word.x & (bit - 1u)) : NONE;
    } else {
        place = search_place(list, false, light);
    }
    if (place != NONE || list.moving_count == 0u) return place;
    place = search_place(list, true, light);
    return place == NONE ? NONE : list.count + place;
}

float cluster_mass(LightContext c, uint light, bool statistics) {
    float mass = candidate_mass(c, light);
    return statistics && mass > 0.0 ? mass * lit_share(c.cluster, light, c.normal) : mass;
}

// One light of subset `first`, first + stride, ..., or the one that is `wanted`, if that is not NONE; `pmf` within the subset. A single number walks the
// cumulative masses: what is left of it is used for the next candidate.
uint pick_of_subset(LightContext c, ClusterListRecord list, uint first, uint stride, uint wanted, float xi, bool statistics, out float pmf) {
    uint size = cluster_list_size(list), picked = wanted;
    float sum = 0.0, kept = 0.0;
    // The subsets of the list are those of its storage if no other lights join them.
    bool side_by_side = stride == subset_count(list.count);
    uint entry = first_entry(list, first, stride);
    UintTable fixed_entries = UintTable(choice_tables().cluster_entries);
    for (uint i = 0u; i < CLUSTER_CANDIDATES; i++) {
        uint place = first + i * stride;
        // Behind the end there is the first one again, without a mass: no load waits for a branch.
        bool inside = place < size;
        if (!inside) place = first;
        uint light;
        if (place >= list.count) light = moving_light(list, place - list.count);
        else if (side_by_side) light = fixed_entries.at[entry + (inside ? i : 0u)];
        else light = fixed_light(list, place);
        float mass = cluster_mass(c, light, statistics);
        if (!inside || mass <= 0.0) continue;
        sum += mass;
        if (wanted != NONE) {
            if (light == wanted) kept = mass;
            continue;
        }
        float share = mass / sum;
        if (xi < share) {
            xi /= share;
            picked = light;
            kept = mass;
        } else {
            xi = (xi - share) / (1.0 - share);
        }
    }
    pmf = sum > 0.0 ? kept / sum : 0.0;
    return picked;
}

Subsets subsets_of(LightContext c, uint count, bool statistics) {
    return statistics ? cluster_subsets(c.cluster, normal_side(c.normal), count) : uniform_subsets(count);
}

// A light of the list and its probability, with the catch-all. `wanted`: that light, at that place of the list, NONE: any of the subset that `xi` picks.
uint pick_of_list(LightContext c, ClusterListRecord list, uint wanted, uint place, vec2 xi, bool statistics, out float pmf) {
    uint stride = cluster_stride(list);
    Subsets subsets = subsets_of(c, stride, statistics);
    uint subset = wanted == NONE ? pick_subset(subsets, xi.x) : place % stride;
    uint light = pick_of_subset(c, list, subset, stride, wanted, xi.y, statistics, pmf);
    if (light == NONE) return NONE;
    pmf *= (1.0 - list.catch_all) * subset_pmf(subsets, subset);
    if (list.catch_all > 0.0) pmf += list.catch_all * power_pmf(light);
    return light;
}

// Probability with which cluster_pick() returns a light.
float cluster_pmf(LightContext c, uint light, bool statistics) {
    ClusterListRecord list = cluster_list(c.cluster);
    uint place = cluster_list_place(list, c.cluster, light);
    if (place == NONE) return list.catch_all > 0.0 ? list.catch_all * power_pmf(light) : 0.0;
    float pmf;
    pick_of_list(c, list, light, place, vec2(0.0), statistics, pmf);
    return pmf;
}

// A light, NONE: none, and its probability. `xi`: for the catch-all and the subset, and for the light. `by_power`: a light picked by power. Threads that
// take this one and those that take one of the list go the same way.
uint cluster_pick(LightContext c, vec2 xi, uint by_power, bool statistics, out float pmf) {
    ClusterListRecord list = cluster_list(c.cluster);
    uint wanted = NONE, place = NONE;
    pmf = 0.0;
    if (xi.x < list.catch_all) {
        wanted = by_power;
        place = cluster_list_place(list, c.cluster, wanted);
        if (place == NONE) {
            pmf = list.catch_all * power_pmf(wanted);
            return wanted;
        }
    } else if (cluster_list_size(list) == 0u) {
        return NONE;
    }
    xi.x = (xi.x - list.catch_all) / (1.0 - list.catch_all);
    return pick_of_list(c, list, wanted, place, xi, statistics, pmf);
}
