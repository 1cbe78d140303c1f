//! The light tree: a binary tree over the local lights that a sampler descends at random (Conty Estevez and Kulla 2018, "Importance
//! Sampling of Many Lights with Adaptive Tree Splitting"). The sampler is `lights/light_bvh.glsl`, its host twin
//! [`crate::oracle::light_bvh`].

mod build;
mod cone;
mod packed;
mod summary;
#[cfg(test)]
mod tests;

use crate::LightBounds;
pub(crate) use packed::Unpacked;
use pt_shaders::records::{LIGHT_BVH_LEAF, LightBvhNode};
use summary::Summary;

/// Trail of a light that the tree does not have.
pub const NO_TRAIL: u64 = u64::MAX;

/// No leaf lies deeper: a trail has a bit for each branch, and none is [`NO_TRAIL`].
const MAX_DEPTH: u32 = 63;

/// Trees of fewer lights are worked on by one thread.
const PARALLEL: usize = 4096;

/// A binary tree over the local lights; each leaf is one light.
///
/// Distant lights are left out: they have no place (`lights/tree_and_quads.glsl` chooses between the tree and them).
///
/// Lights that can't be sampled are left out: those without power, and those whose power, box, axis or cosines are not finite or
/// whose box reaches beyond [`pt_shaders::constants::SKY_DISTANCE`]. The sampler never returns them, and their probability is 0: to it they
/// are dark.
///
/// **Memory** for n lights in the tree, of N: 64 n + 8 N bytes, on the host and again on the device; while it is built, 52 N bytes more.
/// 2 million lights take 144 MB, and 104 MB while the tree is built.
///
/// The tree depends on the lights alone, not on the number of threads.
#[derive(Clone, Debug, PartialEq)]
pub struct LightBvh {
    nodes: Vec<LightBvhNode>,
    trails: Vec<u64>,
    power: f64,
}

impl LightBvh {
    /// Builds the tree. `None` for 2^30 lights or more, which its links can't tell apart.
    pub fn new(lights: &[LightBounds]) -> Option<Self> {
        if lights.len() >= (LIGHT_BVH_LEAF / 2) as usize {
            return None;
        }
        let mut bvh = Self { nodes: build::topology(lights), trails: Vec::new(), power: 0.0 };
        bvh.trails = trails(&bvh.nodes, lights.len());
        bvh.power = refit_tree(&mut bvh.nodes, lights);
        Some(bvh)
    }

    /// Gives the nodes new bounds, for lights that have moved, changed or gone dark; the branches stay. False, and nothing has changed, if
    /// the number of lights is another or a light shines that is not in the tree: it needs to be built again.
    ///
    /// The bounds are those that the same tree would have if it were built now. Lights that move far apart from their
    /// neighbours make it slower to converge, not wrong.
    pub fn refit(&mut self, lights: &[LightBounds]) -> bool {
        let covers =
            |(light, &trail): (&LightBounds, &u64)| trail != NO_TRAIL || Summary::of(light, 1.0).is_none();
        if lights.len() != self.trails.len() || !lights.iter().zip(&self.trails).all(covers) {
            return false;
        }
        self.power = refit_tree(&mut self.nodes, lights);
        true
    }

    /// The nodes as the GPU reads them (`LIGHT_BVH_NODES` of the sampler): the root first, never empty.
    pub fn nodes(&self) -> &[LightBvhNode] {
        &self.nodes
    }

    /// For each light the branches from the root to its leaf, from bit 0 on, 1 for the second child; [`NO_TRAIL`] without a leaf
    /// (`LIGHT_BVH_TRAILS` of the sampler).
    pub fn trails(&self) -> &[u64] {
        &self.trails
    }

    /// Luminous flux of the lights in the tree, of which the nodes have shares.
    pub fn power(&self) -> f64 {
        self.power
    }

    /// How many nodes a tree over `lights` lights has at most: what a buffer has to hold for a tree that is built again.
    pub const fn max_nodes(lights: usize) -> usize {
        if lights == 0 { 1 } else { 2 * lights - 1 }
    }
}

/// The trail of each of `count` lights.
fn trails(nodes: &[LightBvhNode], count: usize) -> Vec<u64> {
    let mut trails = vec![NO_TRAIL; count];
    let mut stack = vec![(0, 0, 0)];
    while let Some((node, trail, depth)) = stack.pop() {
        let link: u32 = nodes[node as usize].link;
        if link & LIGHT_BVH_LEAF == 0 {
            stack.push((link + 1, trail | 1 << depth, depth + 1));
            stack.push((link, trail, depth + 1));
        } else if let Some(place) = trails.get_mut((link & !LIGHT_BVH_LEAF) as usize) {
            // The leaf of an empty tree names no light.
            *place = trail;
        }
    }
    trails
}

/// Returns the flux of all lights.
fn refit_tree(nodes: &mut [LightBvhNode], lights: &[LightBounds]) -> f64 {
    let total: f64 =
        lights.iter().filter(|light| Summary::of(light, 1.0).is_some()).map(|l| f64::from(l.power)).sum();
    if let [root, block @ ..] = nodes {
        refit_node(root, block, lights, if total > 0.0 { 1.0 / total } else { 0.0 });
    }
    total
}

/// Bounds of a node whose descendants are `block`, laid out as [`build::topology`] says. `None` if all its lights are dark.
fn refit_node(
    node: &mut LightBvhNode,
    block: &mut [LightBvhNode],
    lights: &[LightBounds],
    scale: f64,
) -> Option<Summary> {
    let summary = if node.link & LIGHT_BVH_LEAF != 0 {
        let light = lights.get((node.link & !LIGHT_BVH_LEAF) as usize);
        light.and_then(|light| Summary::of(light, scale))
    } else {
        let ([left, right], rest) = block.split_first_chunk_mut().expect("an inner node has two children");
        let inner = right.link & LIGHT_BVH_LEAF == 0;
        let middle = if inner { (right.link - node.link) as usize - 2 } else { rest.len() };
        let parallel = rest.len() >= 2 * PARALLEL;
        let (left_block, right_block) = rest.split_at_mut(middle);
        let summaries = both(
            parallel,
            || refit_node(left, left_block, lights, scale),
            || refit_node(right, right_block, lights, scale),
        );
        match summaries {
            (Some(a), Some(b)) => Some(a.union(&b)),
            (a, b) => a.or(b),
        }
    };
    *node = summary.as_ref().map_or_else(|| summary::dark(node.link), |s| s.record(node.link));
    summary
}

/// Does two things, at the same time if `parallel`.
fn both<A: Send, B: Send>(
    parallel: bool,
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    if parallel { rayon::join(a, b) } else { (a(), b()) }
}
