//! Wide BVHs of the compute backend: one per mesh and one over the instances.
//!
//! Both are compressed 8-wide BVHs (Ylitie, Karras, Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through
//! Compressed Wide BVHs"), built with `obvhs` and handed to the GPU node by node (`trace/compute.glsl`).

use super::{Leaf, MeshGeometry, TraceError};
use glam::{Affine3A, UVec3, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, node::Bvh2Node, reinsertion::ReinsertionOptimizer};
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::cwbvh::{CwBvh, node::CwBvhNode};
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use pt_shaders::records::{BvhNode, BvhTriangle};
use serde::{Deserialize, Serialize};

/// Levels of a mesh's tree and of the one over the instances. `trace/compute.glsl` has a stack of 48 entries: one a level,
/// and two where a mesh is entered.
const MAX_MESH_DEPTH: u32 = 28;
const MAX_TOP_DEPTH: u32 = 18;
/// Levels that a binary tree may have before it is made wide: `obvhs` recurses down to its leaves. Real scenes have 40.
const MAX_BINARY_DEPTH: u32 = 256;

/// How much time goes into a mesh's BVH. Seconds are for 237,000 triangles on one core of a 2023 server.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BvhQuality {
    /// 0.1 s: for geometry that changes.
    Fast,
    /// 0.15 s, rays 10-15 % faster than with `Fast`.
    #[default]
    Medium,
    /// 0.5 s, rays 2-5 % faster than with `Medium`.
    High,
}

/// Triangles up to which a scene gets trees of high quality: at the rate above they take some 2 s on one core.
const MAX_HIGH_QUALITY: usize = 1_000_000;

impl BvhQuality {
    /// For geometry that is loaded once: high, as long as nobody waits for it.
    pub fn for_loading(meshes: &[MeshGeometry]) -> Self {
        let triangles: usize = meshes.iter().map(|mesh| mesh.indices.len()).sum();
        if triangles <= MAX_HIGH_QUALITY { Self::High } else { Self::Medium }
    }

    /// Neighbours looked at when clusters merge, levels on which only the next one is looked at, share of the nodes that
    /// are re-inserted where they lower the surface area heuristic's cost.
    fn parameters(self) -> (PlocSearchDistance, usize, f32) {
        match self {
            Self::Fast => (PlocSearchDistance::Low, 2, 0.0),
            Self::Medium => (PlocSearchDistance::Medium, 3, 0.05),
            Self::High => (PlocSearchDistance::VeryHigh, 1, 0.5),
        }
    }
}

/// BVH over the triangles of one mesh, in object space.
#[derive(Clone, Debug, Default)]
pub struct MeshBvh {
    /// Nodes and leaf order; `primitive_indices` are triangle indices of the mesh, of a pair that of the first.
    pub bvh: CwBvh,
    /// Triangles in leaf order, [`Leaf::triangles`] a leaf, as the GPU reads them.
    pub triangles: Vec<BvhTriangle>,
}

impl MeshBvh {
    /// Builds the BVH of the triangles `indices` over `positions` (object space, metres). Triangles with a vertex that is
    /// not finite are left out.
    ///
    /// # Errors
    /// [`TraceError::VertexIndex`] when an index is outside of `positions`, [`TraceError::BvhDepth`] when the geometry
    /// makes a tree deeper than the traversal's stack.
    pub fn build(
        positions: &[Vec3],
        indices: &[UVec3],
        quality: BvhQuality,
        leaf: Leaf,
    ) -> Result<Self, TraceError> {
        super::check_indices(positions, indices)?;
        let corners = |triangle: u32| {
            let index = indices[triangle as usize];
            [index.x, index.y, index.z].map(|i| positions[i as usize])
        };
        let mut bounds = Vec::with_capacity(indices.len());
        let mut kept = Vec::with_capacity(indices.len());
        for triangle in 0..indices.len() as u32 {
            let corners = corners(triangle);
            if corners.iter().all(|p| p.is_finite()) {
                bounds.push(Aabb::from_points(&corners.map(Vec3A::from)));
                kept.push(triangle);
            }
        }
        if kept.is_empty() {
            return Ok(Self::default());
        }
        let leaves = leaf.gather(indices, &kept, &bounds);
        bounds = leaves.iter().map(|&[a, b]| bounds[a as usize].union(&bounds[b as usize])).collect();
        tell_apart(&mut bounds);
        let (distance, narrow_levels, reinsertion) = quality.parameters();
        let order = (0..leaves.len() as u32).collect();
        let mut bvh2 = PlocBuilder::with_capacity(bounds.len()).build(
            distance,
            &bounds,
            order,
            SortPrecision::U64,
            narrow_levels,
        );
        if binary_depth(&bvh2) <= MAX_BINARY_DEPTH {
            ReinsertionOptimizer::default().run(&mut bvh2, reinsertion, None);
        }
        let mut bvh = wide(&bvh2, &bounds, MAX_MESH_DEPTH)?;
        drop((bvh2, bounds));
        let triangle = |&i: &u32| {
            let triangle = kept[i as usize];
            let [v0, v1, v2] = corners(triangle);
            BvhTriangle { v0, e1: v1 - v0, e2: v2 - v0, triangle, padding: [0; 2] }
        };
        let of_leaf = |&i: &u32| leaves[i as usize][..leaf.triangles() as usize].iter().map(triangle);
        let triangles = bvh.primitive_indices.iter().flat_map(of_leaf).collect();
        for index in &mut bvh.primitive_indices {
            *index = kept[leaves[*index as usize][0] as usize];
        }
        Ok(Self { bvh, triangles })
    }

    /// Object-space bounds; `None` without triangles.
    pub fn bounds(&self) -> Option<Aabb> {
        (!self.bvh.nodes.is_empty()).then_some(self.bvh.total_aabb)
    }
}

/// Entries of a leaf: triangles, pairs of them or instances. One: then a set of child slots says which entries to test, without a table of counts.
/// Rays are up to a quarter faster than with three, on the CPU too.
const LEAF_ENTRIES: u32 = 1;

/// BVH over the world-space bounds of the instances, rebuilt when they move. Keeps its allocations.
#[derive(Clone, Default)]
pub struct TopLevel {
    /// Nodes and leaf order; `primitive_indices` are instance indices. Leaves hold one instance.
    pub bvh: CwBvh,
    builder: Option<PlocBuilder>,
    bvh2: Bvh2,
    bounds: Vec<Aabb>,
    instances: Vec<u32>,
}

impl TopLevel {
    /// Rebuilds over `instances`: object-space bounds (`None`: nothing to hit) and world-from-object transform of each.
    ///
    /// # Errors
    /// [`TraceError::BvhDepth`] when the instances make a tree deeper than the traversal's stack.
    pub fn rebuild(
        &mut self,
        instances: impl Iterator<Item = (Option<Aabb>, Affine3A)>,
    ) -> Result<(), TraceError> {
        self.bounds.clear();
        self.instances.clear();
        for (index, (bounds, world_from_object)) in instances.enumerate() {
            let Some(bounds) = bounds.map(|b| world_bounds(&b, &world_from_object)).filter(Aabb::valid)
            else {
                continue;
            };
            self.bounds.push(bounds);
            self.instances.push(index as u32);
        }
        if self.bounds.is_empty() {
            self.bvh = CwBvh::default();
            return Ok(());
        }
        tell_apart(&mut self.bounds);
        let builder = self.builder.get_or_insert_default();
        let order = (0..self.bounds.len() as u32).collect();
        let distance = PlocSearchDistance::Medium;
        builder.build_with_bvh(&mut self.bvh2, distance, &self.bounds, order, SortPrecision::U64, 0);
        self.bvh = wide(&self.bvh2, &self.bounds, MAX_TOP_DEPTH)?;
        for index in &mut self.bvh.primitive_indices {
            *index = self.instances[*index as usize];
        }
        Ok(())
    }
}

/// The nodes as the GPU reads them; at least a root.
pub fn gpu_nodes(bvh: &CwBvh) -> Vec<BvhNode> {
    if bvh.nodes.is_empty() {
        return vec![BvhNode { words: [0; 10] }];
    }
    let pair = |low: u32, high: u32| u64::from(low) | u64::from(high) << 32;
    bvh.nodes
        .iter()
        .map(|n| {
            let leaves = (0..8).filter(|&slot| n.is_leaf(slot) && !n.is_child_empty(slot));
            let leaves = leaves.fold(0, |set, slot| set | 1u32 << slot);
            BvhNode {
                words: [
                    pair(n.p.x.to_bits(), n.p.y.to_bits()),
                    pair(n.p.z.to_bits(), u32::from_le_bytes([n.e[0], n.e[1], n.e[2], n.imask])),
                    pair(n.child_base_idx | leaves << 28, n.primitive_base_idx | leaves >> 4 << 28),
                    u64::from_le_bytes(n.child_min_x),
                    u64::from_le_bytes(n.child_max_x),
                    u64::from_le_bytes(n.child_min_y),
                    u64::from_le_bytes(n.child_max_y),
                    u64::from_le_bytes(n.child_min_z),
                    u64::from_le_bytes(n.child_max_z),
                    0,
                ],
            }
        })
        .collect()
}

/// Bounds of a transformed box (Arvo 1990), widened by the rounding of the object-space ray.
fn world_bounds(bounds: &Aabb, world_from_object: &Affine3A) -> Aabb {
    let m = world_from_object.matrix3;
    let center = world_from_object.transform_point3a(bounds.center());
    let half = bounds.diagonal() * 0.5;
    let half = m.x_axis.abs() * half.x + m.y_axis.abs() * half.y + m.z_axis.abs() * half.z;
    let pad = 1e-6 * (center.abs() + half).max_element();
    Aabb::new(center - half - pad, center + half + pad)
}

/// Widens boxes that are alike or next to nothing by different amounts: some roundings of the largest coordinate. Clustering takes quadratic
/// time where all distances are equal.
fn tell_apart(bounds: &mut [Aabb]) {
    let whole = bounds.iter().fold(Aabb::empty(), |all, b| all.union(b));
    let tiny = 4e-6 * whole.min.abs().max(whole.max.abs()).max_element().max(1e-12);
    // One bit for each hash: a few boxes count as seen that were not, and widening those as well does no harm.
    let mut seen = vec![0u64; bounds.len().next_power_of_two().div_ceil(4)];
    let last_word = seen.len() - 1;
    for (i, b) in (0u32..).zip(bounds) {
        let is_small = b.diagonal().max_element() <= tiny;
        let hash = hash(b);
        let (word, bit) = (&mut seen[(hash >> 6) as usize & last_word], 1 << (hash % 64));
        let is_seen = *word & bit != 0;
        *word |= bit;
        if is_small || is_seen {
            // Multiples of the golden ratio are spread evenly.
            let random = i.wrapping_mul(0x9e37_79b9) as f32 / 2f32.powi(32);
            let pad = tiny * (0.5 + 0.5 * random);
            (b.min, b.max) = (b.min - pad, b.max + pad);
        }
    }
}

/// Multiply and mix (the finaliser of SplitMix64; Steele, Lea, Flood 2014) over the six coordinates.
fn hash(b: &Aabb) -> u64 {
    let words = [b.min.x, b.min.y, b.min.z, b.max.x, b.max.y, b.max.z].map(|x| u64::from(x.to_bits()));
    words.into_iter().fold(0, |state, word| {
        let z = (state ^ word).wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    })
}

/// The binary tree over `bounds` as a wide one of at most `limit` levels. Where clustering made chains, a balanced
/// tree takes its place.
fn wide(bvh2: &Bvh2, bounds: &[Aabb], limit: u32) -> Result<CwBvh, TraceError> {
    let convert = |bvh2: &Bvh2| {
        let bvh = bvh2_to_cwbvh(bvh2, LEAF_ENTRIES, true, false);
        let depth = levels(&bvh.nodes).into_iter().max().unwrap_or(0);
        if depth > limit { Err(TraceError::BvhDepth { depth, limit }) } else { Ok(bvh) }
    };
    match binary_depth(bvh2) {
        0..=MAX_BINARY_DEPTH => convert(bvh2).or_else(|_| convert(&balanced(bounds))),
        _ => convert(&balanced(bounds)),
    }
}

/// A binary tree whose depth is the logarithm of the number of boxes: each node is cut at the median of the centres along its
/// longest axis.
fn balanced(bounds: &[Aabb]) -> Bvh2 {
    let mut order: Vec<u32> = (0..bounds.len() as u32).collect();
    let mut nodes = vec![Bvh2Node::default()];
    let mut pending = vec![(0, 0..bounds.len())];
    while let Some((node, range)) = pending.pop() {
        let part = &mut order[range.clone()];
        let aabb = part.iter().fold(Aabb::empty(), |all, &i| all.union(&bounds[i as usize]));
        if let [_] = part {
            nodes[node] = Bvh2Node::new(aabb, 1, range.start as u32);
            continue;
        }
        let axis = aabb.diagonal().max_position();
        let half = part.len() / 2;
        let center = |i: u32| bounds[i as usize].center()[axis];
        part.select_nth_unstable_by(half, |&a, &b| center(a).total_cmp(&center(b)).then(a.cmp(&b)));
        let child = nodes.len();
        nodes[node] = Bvh2Node::new(aabb, 0, child as u32);
        nodes.resize(child + 2, Bvh2Node::default());
        let middle = range.start + half;
        pending.push((child, range.start..middle));
        pending.push((child + 1, middle..range.end));
    }
    Bvh2 { nodes, primitive_indices: order, children_are_ordered_after_parents: true, ..Bvh2::default() }
}

/// Number of levels.
fn binary_depth(bvh2: &Bvh2) -> u32 {
    let mut deepest = 0;
    let mut pending = vec![(0, 1)];
    while let Some((node, depth)) = pending.pop() {
        deepest = deepest.max(depth);
        let node = &bvh2.nodes[node as usize];
        if !node.is_leaf() {
            pending.extend([node.first_index, node.first_index + 1].map(|child| (child, depth + 1)));
        }
    }
    deepest
}

/// Level of every node, the root's is 1. Children come after their parent in `nodes`.
pub(super) fn levels(nodes: &[CwBvhNode]) -> Vec<u32> {
    let mut levels = vec![1u32; nodes.len()];
    for (index, node) in nodes.iter().enumerate() {
        let level = levels[index];
        for child in 0..node.imask.count_ones() {
            levels[(node.child_base_idx + child) as usize] = level + 1;
        }
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_levels_fit_the_stack_of_the_traversal() {
        let source = include_str!("../../../shaders/glsl/trace/compute.glsl");
        let stack = format!("const uint STACK_SIZE = {}u;", MAX_MESH_DEPTH + 2 + MAX_TOP_DEPTH);
        assert!(source.contains(&stack), "{stack}");
    }

    /// Places of boxes without extent that clustering makes a chain of: all the same, on a line, and closer and closer.
    fn chains(count: usize) -> [Vec<Vec3>; 5] {
        let step = 130.0 / count as f32;
        let closer = |i: usize| 2f32.powf(i as f32 * step - 90.0);
        let make = |place: &dyn Fn(usize) -> Vec3| (0..count).map(place).collect();
        [
            make(&|_| Vec3::ZERO),
            make(&|_| Vec3::ONE),
            make(&|i| Vec3::X * i as f32),
            make(&|i| Vec3::X * closer(i)),
            make(&|i| Vec3::ONE * closer(i)),
        ]
    }

    fn depth(nodes: &[CwBvhNode]) -> u32 {
        levels(nodes).into_iter().max().unwrap_or(0)
    }

    fn is_permutation(indices: &[u32], count: usize) -> bool {
        let mut sorted = indices.to_vec();
        sorted.sort_unstable();
        sorted.into_iter().eq(0..count as u32)
    }

    #[test]
    fn degenerate_meshes_make_trees_that_can_be_traced() {
        for count in [1000, 30_000] {
            for places in chains(count) {
                let positions: Vec<_> = places.iter().flat_map(|&p| [p; 3]).collect();
                let indices: Vec<_> =
                    (0..count as u32).map(|i| UVec3::new(3 * i, 3 * i + 1, 3 * i + 2)).collect();
                for quality in [BvhQuality::Fast, BvhQuality::Medium, BvhQuality::High] {
                    for leaf in [Leaf::Triangle, Leaf::Pair] {
                        let tree = MeshBvh::build(&positions, &indices, quality, leaf).unwrap();
                        assert!(depth(&tree.bvh.nodes) <= MAX_MESH_DEPTH);
                        let mut triangles: Vec<_> = tree.triangles.iter().map(|t| t.triangle).collect();
                        triangles.sort_unstable();
                        triangles.dedup();
                        assert!(is_permutation(&triangles, count));
                    }
                }
            }
        }
    }

    #[test]
    fn coincident_and_crowded_instances_make_a_tree_that_can_be_traced() {
        for count in [200, 30_000] {
            for places in chains(count) {
                let bounds = Some(Aabb::new(Vec3A::ZERO, Vec3A::splat(1e-20)));
                let instances = places.iter().map(|&p| (bounds, Affine3A::from_translation(p)));
                let mut top = TopLevel::default();
                top.rebuild(instances).unwrap();
                assert!(depth(&top.bvh.nodes) <= MAX_TOP_DEPTH);
                assert!(is_permutation(&top.bvh.primitive_indices, count));
            }
        }
    }

    #[test]
    fn trees_beyond_the_limit_are_errors() {
        let bounds = vec![Aabb::new(Vec3A::ZERO, Vec3A::ZERO); 65];
        assert!(wide(&balanced(&bounds), &bounds, 8).is_ok());
        let error = wide(&balanced(&bounds), &bounds, 6).unwrap_err().to_string();
        assert!(error.contains("levels, the traversal takes 6"), "{error}");
    }
}
