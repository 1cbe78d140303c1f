//! Which of the lights that reach a cluster are listed.

use super::irradiance::{Emitters, Estimates, LANES};
use super::{ClusterBox, MAX_CATCH_ALL, MIN_CATCH_ALL, Visible};
use rayon::prelude::*;

/// Clusters that a task takes from the queue.
const CHUNK: usize = 16;
/// What counts of a light that [`super::VisibilityEstimate`] found hidden: the expected visible part after as many rays as that traces, all
/// of them blocked (Laplace's rule of succession).
const HIDDEN_SHARE: f64 = 1.0 / (super::visibility::RAYS as f64 + 2.0);

/// How long lists may become. The two counts apply to the lists of the lights that may change and to those of all others separately.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ListLimits {
    /// Share of the light in a cluster below which a light is not listed.
    pub min_share: f32,
    /// Most lights of a cluster.
    pub max_per_cluster: usize,
    /// Most entries of all clusters together. At most 2^32 - 1.
    pub max_entries: usize,
}

impl Default for ListLimits {
    /// Lights that matter less than one in ten thousand are left out. 1024 lights per cluster are 128 strides of 8 candidates;
    /// 2^19 entries are 2 MiB, 128 per cluster for 4096 clusters.
    fn default() -> Self {
        Self { min_share: 1e-4, max_per_cluster: 1024, max_entries: 1 << 19 }
    }
}

/// A list of light indices for each cluster, one after the other.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct IndexLists {
    /// Where the list of each cluster begins in `entries`, and where the last one ends.
    pub offsets: Vec<u32>,
    /// Light indices, ascending within a cluster.
    pub entries: Vec<u32>,
}

impl IndexLists {
    /// The lights of a cluster.
    pub fn list(&self, cluster: usize) -> &[u32] {
        &self.entries[self.offsets[cluster] as usize..self.offsets[cluster + 1] as usize]
    }

    /// The place of a light in the list of a cluster.
    pub fn position(&self, cluster: usize, light: u32) -> Option<usize> {
        self.list(cluster).binary_search(&light).ok()
    }
}

/// How much of the light in a cluster its list leaves out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Left {
    /// Irradiance of all lights.
    total: f64,
    /// Of the lights that are not listed.
    out: f64,
    /// Whether any light that may reach the cluster is not listed.
    any: bool,
}

impl Left {
    pub(super) fn with(&self, other: &Self) -> Self {
        Self { total: self.total + other.total, out: self.out + other.out, any: self.any || other.any }
    }

    pub(super) fn catch_all(&self, is_empty: bool) -> f32 {
        let total = self.total.max(self.out);
        let share = if total > 0.0 { self.out / total } else { 1.0 };
        match (self.any, is_empty) {
            (false, _) => 0.0,
            (true, true) => 1.0,
            (true, false) => (share as f32).clamp(MIN_CATCH_ALL, MAX_CATCH_ALL),
        }
    }

    fn leave_out(&mut self, irradiance: f32) {
        self.out += f64::from(irradiance);
        self.any = true;
    }
}

#[derive(Clone, Copy)]
struct Entry {
    light: u32,
    most: f32,
    typical: f32,
}

/// The lists of some clusters.
struct Chunk {
    entries: Vec<Entry>,
    /// Length of each.
    lists: Vec<(usize, Left)>,
}

/// Memory that a thread uses for one cluster after the other.
#[derive(Default)]
struct Scratch {
    estimates: Estimates,
    /// Lights that may be listed: places in [`Builder::names`].
    places: Vec<u32>,
    keys: Vec<u64>,
}

/// Everything that the lists of one group of lights are made from.
pub(super) struct Builder<'a> {
    pub boxes: &'a [ClusterBox],
    pub emitters: &'a Emitters,
    /// Light index of each emitter, ascending.
    pub names: &'a [u32],
    pub limits: ListLimits,
    pub visible: Option<&'a Visible<'a>>,
    /// Of the lights whose irradiance counts for [`ListLimits::min_share`] too; empty without any.
    pub before: &'a [Left],
}

impl Builder<'_> {
    pub(super) fn build(&self) -> (IndexLists, Vec<Left>) {
        let chunks: Vec<Chunk> = self
            .boxes
            .par_chunks(CHUNK)
            .enumerate()
            .map_init(Scratch::default, |scratch, (chunk, boxes)| {
                let mut entries = Vec::new();
                let lists = (CHUNK * chunk..).zip(boxes).map(|(cluster, of)| {
                    let before = entries.len();
                    let left = self.choose(cluster, of, scratch, &mut entries);
                    (entries.len() - before, left)
                });
                let lists = lists.collect();
                Chunk { entries, lists }
            })
            .collect();
        let (mut entries, mut lengths, mut left) = (Vec::new(), Vec::new(), Vec::new());
        for chunk in chunks {
            entries.extend(chunk.entries);
            lengths.extend(chunk.lists.iter().map(|(length, _)| *length));
            left.extend(chunk.lists.iter().map(|(_, left)| *left));
        }
        self.limit_all(&mut entries, &mut lengths, &mut left);
        let mut end = 0;
        let ends = lengths.iter().map(|&length| {
            end += length as u32;
            end
        });
        let offsets = std::iter::once(0).chain(ends).collect();
        (IndexLists { offsets, entries: entries.iter().map(|e| e.light).collect() }, left)
    }

    /// Appends the list of one cluster, ascending.
    fn choose(
        &self,
        cluster: usize,
        of: &ClusterBox,
        scratch: &mut Scratch,
        entries: &mut Vec<Entry>,
    ) -> Left {
        let Scratch { estimates, places, keys } = scratch;
        self.emitters.estimate(of, estimates);
        let Estimates { most, typical } = &*estimates;
        let mut left = Left { total: sum(typical), ..Left::default() };
        let before = self.before.get(cluster).map_or(0.0, |left| left.total);
        let least = (f64::from(self.limits.min_share) * (before + left.total)).min(f32::MAX.into()) as f32;
        let (reached, weak) = count(most, typical, least);
        candidates(&most[..self.names.len()], least, places);
        left.out = weak;
        // Beyond an open box, the lights that do not reach it may do.
        left.any = places.len() < reached || of.open && reached < self.emitters.lit;
        if let Some(visible) = self.visible {
            places.retain(|&i| {
                let keep = visible(cluster as u32, self.names[i as usize]);
                if !keep {
                    let hidden = f64::from(typical[i as usize]);
                    left.total -= (1.0 - HIDDEN_SHARE) * hidden;
                    left.out += HIDDEN_SHARE * hidden;
                    left.any = true;
                }
                keep
            });
        }
        if let Some(surplus @ 1..) = places.len().checked_sub(self.limits.max_per_cluster) {
            // Positive numbers have the order of their bits. Of equal ones the first stay.
            let key = |&i: &u32| u64::from(most[i as usize].to_bits()) << 32 | u64::from(!i);
            keys.clear();
            keys.extend(places.iter().map(key));
            let (_, &mut strongest_out, _) = keys.select_nth_unstable(surplus - 1);
            places.retain(|i| {
                let keep = key(i) > strongest_out;
                if !keep {
                    left.leave_out(typical[*i as usize]);
                }
                keep
            });
        }
        entries.extend(places.iter().map(|&i| {
            let (light, i) = (self.names[i as usize], i as usize);
            Entry { light, most: most[i], typical: typical[i] }
        }));
        left
    }

    /// Shortens the lists together: the entries that are weakest in proportion to the light in their cluster go.
    fn limit_all(&self, entries: &mut Vec<Entry>, lengths: &mut [usize], left: &mut [Left]) {
        let most = self.limits.max_entries.min(u32::MAX as usize);
        if entries.len() <= most {
            return;
        }
        let total = |left: &Left| left.total.clamp(f32::MIN_POSITIVE.into(), f32::MAX.into()) as f32;
        let totals: Vec<f32> = left.iter().map(total).collect();
        let clusters = || (0..).zip(&*lengths).flat_map(|(cluster, &n)| std::iter::repeat_n(cluster, n));
        let share = |entry: &Entry, cluster: usize| entry.most / totals[cluster];
        let shares: Vec<f32> = entries.iter().zip(clusters()).map(|(e, c): (_, usize)| share(e, c)).collect();
        let mut sorted = shares.clone();
        let (above, &mut limit, _) = sorted.select_nth_unstable_by(most, |a, b| b.total_cmp(a));
        // Of entries with the same share the first ones stay.
        let mut ties = most - above.iter().filter(|&&share| share > limit).count();
        let mut kept = Vec::with_capacity(most);
        let mut all = entries.iter().zip(&shares);
        for (length, left) in lengths.iter_mut().zip(left) {
            let before = kept.len();
            for (entry, &share) in all.by_ref().take(*length) {
                let tie = share == limit && ties > 0;
                ties -= usize::from(tie);
                if share > limit || tie {
                    kept.push(*entry);
                } else {
                    left.leave_out(entry.typical);
                }
            }
            *length = kept.len() - before;
        }
        *entries = kept;
    }
}

/// In an order that lets the compiler use vector instructions.
fn sum(values: &[f32]) -> f64 {
    let mut sums = [0.0f64; LANES];
    for part in values.as_chunks::<LANES>().0 {
        for (sum, &value) in sums.iter_mut().zip(part) {
            *sum += f64::from(value);
        }
    }
    sums.iter().sum()
}

/// How many lights reach a box, and the typical irradiance of those with a bound below `least`.
fn count(most: &[f32], typical: &[f32], least: f32) -> (usize, f64) {
    let (mut reached, mut weak) = ([0u32; LANES], [0.0f64; LANES]);
    for (most, typical) in most.as_chunks::<LANES>().0.iter().zip(typical.as_chunks::<LANES>().0) {
        for i in 0..LANES {
            reached[i] += u32::from(most[i] > 0.0);
            weak[i] += f64::from(if most[i] < least { typical[i] } else { 0.0 });
        }
    }
    (reached.iter().sum::<u32>() as usize, weak.iter().sum())
}

/// The places of the bounds that are positive and not below `least`. Without branches: they would be taken at random.
fn candidates(most: &[f32], least: f32, places: &mut Vec<u32>) {
    // A positive bound is at least that.
    let least = least.max(f32::MIN_POSITIVE);
    places.resize(most.len(), 0);
    let mut count = 0;
    for (place, &bound) in (0..).zip(most) {
        places[count] = place;
        count += usize::from(bound >= least);
    }
    places.truncate(count);
}
