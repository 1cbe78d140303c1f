//! How lists lie in the memory of the device (`lights/cluster_lists.glsl`).

use super::IndexLists;

/// Lights that a choice weighs: `CLUSTER_CANDIDATES` of the sampler.
const CANDIDATES: usize = 8;
/// Lights in a word of [`ranks`].
const WORD: usize = 32;

/// The entries of each list subset by subset, places k, k + stride, k + 2 stride, ..., as a choice reads them.
pub(crate) fn subset_by_subset(lists: &IndexLists) -> Vec<u32> {
    let mut entries = Vec::with_capacity(lists.entries.len());
    for cluster in 0..clusters(lists) {
        let list = lists.list(cluster);
        let stride = list.len().div_ceil(CANDIDATES).max(1);
        for subset in 0..stride {
            entries.extend(list.iter().skip(subset).step_by(stride));
        }
    }
    entries
}

/// Words of a cluster in [`ranks`], for so many lights.
pub(crate) fn rank_words(lights: usize) -> usize {
    lights.div_ceil(WORD)
}

/// For each cluster and 32 lights the bits of those in its list, and how many of its lights come before them: the place of a light in one load.
pub(crate) fn ranks(lists: &IndexLists, words: usize) -> Vec<[u32; 2]> {
    let mut ranks = vec![[0u32; 2]; clusters(lists) * words];
    for (cluster, row) in ranks.chunks_exact_mut(words.max(1)).enumerate() {
        for &light in lists.list(cluster) {
            row[light as usize / WORD][0] |= 1 << (light as usize % WORD);
        }
        let mut before = 0;
        for [bits, places] in row {
            *places = before;
            before += bits.count_ones();
        }
    }
    ranks
}

fn clusters(lists: &IndexLists) -> usize {
    lists.offsets.len().saturating_sub(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lists of 0, 1, 8, 9 and 37 lights.
    fn lists() -> IndexLists {
        let lengths = [0, 1, 8, 9, 37];
        let mut lists = IndexLists { offsets: vec![0], entries: Vec::new() };
        for (cluster, length) in (0..).zip(lengths) {
            lists.entries.extend((0..length).map(|place| 3 * place + cluster));
            lists.offsets.push(lists.entries.len() as u32);
        }
        lists
    }

    #[test]
    fn a_subset_lies_side_by_side() {
        let lists = lists();
        let stored = subset_by_subset(&lists);
        assert_eq!(stored.len(), lists.entries.len());
        for cluster in 0..5 {
            let (first, list) = (lists.offsets[cluster] as usize, lists.list(cluster));
            let subsets = list.len().div_ceil(8).max(1);
            // As first_entry() of the sampler says.
            for (place, light) in list.iter().enumerate() {
                let (subset, i) = (place % subsets, place / subsets);
                let entry = first + subset * (list.len() / subsets) + subset.min(list.len() % subsets);
                assert_eq!(stored[entry + i], *light, "cluster {cluster}, place {place}");
            }
        }
    }

    #[test]
    fn ranks_are_places() {
        let lists = lists();
        let words = rank_words(120);
        let ranks = ranks(&lists, words);
        for cluster in 0..5 {
            for light in 0..120 {
                let [bits, before] = ranks[cluster * words + light / 32];
                let bit = 1 << (light % 32);
                let place = (bits & bit != 0).then(|| (before + (bits & (bit - 1)).count_ones()) as usize);
                assert_eq!(place, lists.position(cluster, light as u32), "cluster {cluster}, light {light}");
            }
        }
    }
}
