// Choice of a local light among those that the point's cluster may see, as in Quake II RTX: the list is divided into subsets of at most
// 8 lights with a stride, one subset is picked, and one of its lights in proportion to light_mass(). Without statistics the subsets are
// picked uniformly, else they have their weights too (subsets.glsl). Lights that the
// list leaves out are found by the catch-all: with its probability the light is picked by power among all.
#include "lights/local_lights.glsl"
#include "lights/statistics.glsl"
#include "lights/subsets.glsl"

const uint CLUSTER_CANDIDATES = 8u;

ClusterListRecord cluster_list(uint cluster) { return ClusterListTable(choice_tables().cluster_lists).at[cluster]; }

uint cluster_list_size(ClusterListRecord list) { return list.count + list.moving_count; }

// Light at a place of the list.
uint cluster_list_light(ClusterListRecord list, uint place) {
    if (place < list.count) return UintTable(choice_tables().cluster_entries).at[list.first + place];
    return UintTable(choice_tables().cluster_moving_entries).at[list.moving_first + (place - list.count)];
}

uint find_entry(uint64_t entries, uint first, uint count, uint light) {
    UintTable table = UintTable(entries);
    uint low = first, high = first + count;
    while (low < high) {
        uint middle = (low + high) / 2u;
        if (table.at[middle] < light) low = middle + 1u;
        else high = middle;
    }
    return low < first + count && table.at[low] == light ? low - first : NONE;
}

// Place of a light in the list, NONE: it is not there.
uint cluster_list_place(ClusterListRecord list, uint light) {
    uint place = find_entry(choice_tables().cluster_entries, list.first, list.count, light);
    if (place != NONE) return place;
    place = find_entry(choice_tables().cluster_moving_entries, list.moving_first, list.moving_count, light);
    return place == NONE ? NONE : list.count + place;
}

float cluster_mass(LightContext c, uint light, bool statistics) {
    float mass = light_mass(c, choice_light(light));
    return statistics && mass > 0.0 ? mass * lit_share(c.cluster, light, c.normal) : mass;
}

// One light of subset `first`, first + stride, ...; `pmf` within the subset. A single number walks the cumulative masses: what is left of
// it is used for the next candidate.
uint pick_of_subset(LightContext c, ClusterListRecord list, uint first, uint stride, float xi, bool statistics, out float pmf) {
    uint size = cluster_list_size(list), picked = NONE;
    float sum = 0.0, kept = 0.0;
    for (uint i = 0u; i < CLUSTER_CANDIDATES; i++) {
        uint place = first + i * stride;
        if (place >= size) break;
        uint light = cluster_list_light(list, place);
        float mass = cluster_mass(c, light, statistics);
        if (mass <= 0.0) continue;
        sum += mass;
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

uint cluster_stride(ClusterListRecord list) { return max((cluster_list_size(list) + CLUSTER_CANDIDATES - 1u) / CLUSTER_CANDIDATES, 1u); }

Subsets subsets_of(LightContext c, uint count, bool statistics) {
    return statistics ? cluster_subsets(c.cluster, normal_side(c.normal), count) : uniform_subsets(count);
}

// Probability with which cluster_pick() returns a light.
float cluster_pmf(LightContext c, uint light, bool statistics) {
    ClusterListRecord list = cluster_list(c.cluster);
    float pmf = list.catch_all > 0.0 ? list.catch_all * power_pmf(light) : 0.0;
    uint place = cluster_list_place(list, light);
    if (place == NONE) return pmf;
    uint size = cluster_list_size(list), stride = cluster_stride(list);
    float sum = 0.0;
    for (uint at = place % stride; at < size; at += stride) sum += cluster_mass(c, cluster_list_light(list, at), statistics);
    float mass = cluster_mass(c, light, statistics);
    if (sum <= 0.0) return pmf;
    return pmf + (1.0 - list.catch_all) * subset_pmf(subsets_of(c, stride, statistics), place % stride) * mass / sum;
}

// A light, NONE: none, and its probability. `xi`: for the catch-all and the subset, and for the light. `by_power`: a light picked by power.
uint cluster_pick(LightContext c, vec2 xi, uint by_power, bool statistics, out float pmf) {
    ClusterListRecord list = cluster_list(c.cluster);
    if (xi.x < list.catch_all) {
        pmf = cluster_pmf(c, by_power, statistics);
        return by_power;
    }
    pmf = 0.0;
    if (cluster_list_size(list) == 0u) return NONE;
    uint stride = cluster_stride(list);
    Subsets subsets = subsets_of(c, stride, statistics);
    uint subset = pick_subset(subsets, (xi.x - list.catch_all) / (1.0 - list.catch_all));
    uint light = pick_of_subset(c, list, subset, stride, xi.y, statistics, pmf);
    if (light == NONE) return NONE;
    pmf *= (1.0 - list.catch_all) * subset_pmf(subsets, subset);
    if (list.catch_all > 0.0) pmf += list.catch_all * power_pmf(light);
    return light;
}
