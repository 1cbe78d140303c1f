// How probable each subset of a cluster's list is: in part uniform, in part by what its lights give about the middle of the cluster to
// surfaces of a direction, times the share of shadow rays that reached them. The table has for every cluster and side of the normal
// (statistics.glsl) the number of subsets and the sums of their weights; it is made by cluster_subsets.comp, every few frames for each
// cluster. A list that has become shorter or longer since then is taken uniformly.
#include "lights/light_tables.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer SubsetTable { float at[]; };

// Words of a row: the number of subsets, their sums.
const uint SUBSET_ROW = MAX_SUBSETS + 1u;
// Uniform part: what the estimate takes for nothing is found all the same.
const float UNIFORM_SUBSETS = 0.25;

struct Subsets {
    uint64_t row; // 0: uniform
    uint count;
};

Subsets uniform_subsets(uint count) { return Subsets(0ul, count); }

Subsets cluster_subsets(uint cluster, uint side, uint count) {
    uint64_t row = choice_tables().cluster_subsets + uint64_t((cluster * 6u + side) * SUBSET_ROW) * 4ul;
    SubsetTable table = SubsetTable(row);
    bool known = uint(table.at[0]) == count && table.at[min(count, MAX_SUBSETS)] > 0.0;
    return Subsets(known ? row : 0ul, count);
}

// Probability of the subsets up to, but without, `subset`.
float subset_cdf(Subsets s, uint subset) {
    float uniform_part = float(subset) / float(s.count);
    if (s.row == 0ul) return uniform_part;
    SubsetTable table = SubsetTable(s.row);
    float before = subset == 0u ? 0.0 : table.at[subset];
    return mix(before / table.at[s.count], uniform_part, UNIFORM_SUBSETS);
}

float subset_pmf(Subsets s, uint subset) { return subset_cdf(s, subset + 1u) - subset_cdf(s, subset); }

uint pick_subset(Subsets s, float xi) {
    uint low = 0u, high = s.count - 1u;
    if (s.row == 0ul) return min(uint(xi * float(s.count)), high);
    while (low < high) {
        uint middle = (low + high) / 2u;
        if (subset_cdf(s, middle + 1u) > xi) high = middle;
        else low = middle + 1u;
    }
    return low;
}
