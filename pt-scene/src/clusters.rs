//! Clusters: space divided into cells, so that every point has a small stable number by which lists (of lights, of statistics)
//! can be kept.
//!
//! A k-d tree over the surfaces that stand still. Its planes are the only thing that a look-up asks about, by comparison
//! alone: no arithmetic, so that host and GPU (`clusters.glsl`) agree to the bit. The outer cells reach to infinity, so that
//! every point has a cluster, whether a surface is near it or not; a moving object is in the cluster of where it is.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::{DVec3, Vec3};
use pt_shaders::records::ClusterNode;

use crate::{Bounds, Scene};

/// Surface samples for each cluster that is asked for.
const SAMPLES_PER_CLUSTER: usize = 64;
/// Candidate planes across the extent of a cell, and those of them, round the middle, that are looked at.
const BINS: usize = 64;
const MIDDLE_BINS: std::ops::RangeInclusive<usize> = 20..=43;
/// `ClusterNode::link` of a leaf.
const LEAF: u32 = 3;

/// A division of a scene's space into cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Clusters {
    nodes: Vec<ClusterNode>,
    /// Outer cells are infinite.
    cells: Vec<Bounds>,
    /// Of the samples; an empty box at the origin without any.
    bounds: Bounds,
}

/// What stands still in a cluster.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ClusterContents {
    /// Triangles that reach into the cell; a triangle counts in each cell that it touches.
    pub triangles: usize,
    /// Bounds of the parts of these triangles inside the cell, a few units in the last place larger. `None`: nothing is
    /// there.
    pub bounds: Option<Bounds>,
}

/// Figures about a division.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClusterStatistics {
    /// Number of clusters.
    pub count: usize,
    /// Of these, with any surface in them.
    pub occupied: usize,
    /// Triangles per occupied cluster: smallest, median, largest.
    pub triangles: [usize; 3],
    /// Longest edge of [`ClusterContents::bounds`], metres: smallest, median, largest.
    pub cell_size: [f32; 3],
    /// Number of clusters with up to this many triangles (0, 1, 2, 4, 8 .. and more than the entry before).
    pub histogram: Vec<(usize, usize)>,
}

/// A leaf that may be divided further: the more samples and the larger, the sooner.
struct Candidate {
    cost: f64,
    node: u32,
    first: usize,
    len: usize,
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Candidate {}
impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        self.cost.total_cmp(&other.cost).then(other.node.cmp(&self.node))
    }
}

impl Clusters {
    /// Largest number of clusters.
    pub const MAX: usize = 4096;
    /// Number of clusters that scenes are divided into unless something else is asked for.
    pub const DEFAULT: usize = 512;

    /// Divides the space of `scene` into `target` cells (clamped to 1..=[`Clusters::MAX`]), fewer where there is too little
    /// to divide. Only what stands still counts, where it is in its rest pose; a scene in which everything moves is one cluster.
    ///
    /// Samples are spread over the surfaces, one half in proportion to area, the other equally over the triangles: large plain
    /// walls and small detailed things both get cells. The cell with the largest product of samples and extent
    /// is divided next, across its samples' longest extent, at the plane round the middle that the fewest samples are near: planes
    /// pass between walls rather than along them, where rounding would decide on a point's cluster.
    pub fn new(scene: &Scene, target: usize) -> Self {
        let target = target.clamp(1, Self::MAX);
        let mut samples = surface_samples(scene, SAMPLES_PER_CLUSTER * target);
        let everywhere = Bounds { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY };
        let mut nodes = vec![ClusterNode { split: 0.0, link: LEAF }];
        let mut cells = vec![everywhere];
        let bounds =
            Bounds::of(samples.iter().copied()).unwrap_or(Bounds { min: Vec3::ZERO, max: Vec3::ZERO });
        let mut queue = BinaryHeap::new();
        push(&mut queue, 0, 0, &samples);
        let mut leaves = 1;
        while leaves < target
            && let Some(Candidate { node, first, len, .. }) = queue.pop()
        {
            let own = &mut samples[first..first + len];
            let Some((axis, split)) = choose_plane(own) else { continue };
            let below = partition(own, |p| p[axis] < split);
            let child = nodes.len() as u32;
            nodes[node as usize] = ClusterNode { split, link: child << 2 | axis as u32 };
            nodes.extend([ClusterNode { split: 0.0, link: LEAF }; 2]);
            let cell = cells[node as usize];
            let (mut low, mut high) = (cell, cell);
            low.max[axis] = split;
            high.min[axis] = split;
            cells.extend([low, high]);
            push(&mut queue, child, first, &samples[first..first + below]);
            push(&mut queue, child + 1, first + below, &samples[first + below..first + len]);
            leaves += 1;
        }
        // Cells of inner nodes go; the leaves are numbered in the order of the tree.
        let mut leaf_cells = Vec::with_capacity(leaves);
        for (node, cell) in nodes.iter_mut().zip(cells).filter(|(node, _)| node.link & 3 == LEAF) {
            node.link = (leaf_cells.len() as u32) << 2 | LEAF;
            leaf_cells.push(cell);
        }
        Self { nodes, cells: leaf_cells, bounds }
    }

    /// Number of clusters, 1..=[`Clusters::MAX`].
    pub fn count(&self) -> usize {
        self.cells.len()
    }

    /// The tree as the kernels see it: the root first.
    pub fn nodes(&self) -> &[ClusterNode] {
        &self.nodes
    }

    /// The cluster of a world position: twin of `cluster_of` in `clusters.glsl`.
    pub fn find(&self, position: Vec3) -> u32 {
        let mut node = self.nodes[0];
        while node.link & 3 != LEAF {
            let below = position[(node.link & 3) as usize] < node.split;
            node = self.nodes[(node.link >> 2) as usize + usize::from(!below)];
        }
        node.link >> 2
    }

    /// The cell of a cluster: it holds every point with that number, its lower faces belong to it, its upper ones don't. Infinite
    /// where no other cell follows.
    pub fn cell(&self, cluster: u32) -> Bounds {
        self.cells[cluster as usize]
    }

    /// What stands still in each cluster.
    pub fn contents(&self, scene: &Scene) -> Vec<ClusterContents> {
        let largest = self.bounds.min.abs().max(self.bounds.max.abs()).max_element();
        let margin = Vec3::splat(4.0 * f32::EPSILON * largest);
        let mut contents = vec![ClusterContents::default(); self.count()];
        let mut stack = Vec::new();
        for_each_triangle(scene, |triangle| {
            stack.push((0usize, triangle.map(Vec3::as_dvec3).to_vec()));
            while let Some((index, polygon)) = stack.pop() {
                let node = self.nodes[index];
                if node.link & 3 == LEAF {
                    let own = &mut contents[(node.link >> 2) as usize];
                    own.triangles += 1;
                    for p in polygon.iter().map(|p| p.as_vec3()) {
                        let b = own.bounds.get_or_insert(Bounds { min: p - margin, max: p + margin });
                        *b = Bounds { min: b.min.min(p - margin), max: b.max.max(p + margin) };
                    }
                    continue;
                }
                let child = (node.link >> 2) as usize;
                let [below, above] = split(&polygon, (node.link & 3) as usize, node.split.into());
                stack.extend([(child, below), (child + 1, above)].into_iter().filter(|(_, p)| !p.is_empty()));
            }
        });
        contents
    }

    /// Figures about the division and what stands still in it.
    pub fn statistics(&self, scene: &Scene) -> ClusterStatistics {
        let contents = self.contents(scene);
        let mut triangles: Vec<usize> = contents.iter().map(|c| c.triangles).filter(|&n| n > 0).collect();
        triangles.sort_unstable();
        let mut sizes: Vec<f32> =
            contents.iter().filter_map(|c| c.bounds).map(|b| b.size().max_element()).collect();
        sizes.sort_by(f32::total_cmp);
        let mut histogram: Vec<(usize, usize)> = vec![(0, 0)];
        for n in contents.iter().map(|c| c.triangles) {
            let bin = if n == 0 { 0 } else { n.next_power_of_two().trailing_zeros() as usize + 1 };
            while histogram.len() <= bin {
                histogram.push((1 << (histogram.len() - 1), 0));
            }
            histogram[bin].1 += 1;
        }
        ClusterStatistics {
            count: self.count(),
            occupied: triangles.len(),
            triangles: spread(&triangles),
            cell_size: spread(&sizes),
            histogram,
        }
    }
}

/// Smallest, median and largest of sorted values; zeros without any.
fn spread<T: Copy + Default>(sorted: &[T]) -> [T; 3] {
    let last = sorted.len().saturating_sub(1);
    [0, sorted.len() / 2, last].map(|i| sorted.get(i).copied().unwrap_or_default())
}

fn push(queue: &mut BinaryHeap<Candidate>, node: u32, first: usize, samples: &[Vec3]) {
    let extent = Bounds::of(samples.iter().copied()).map_or(0.0, |b| b.size().max_element());
    if extent > 0.0 {
        queue.push(Candidate {
            cost: samples.len() as f64 * f64::from(extent),
            node,
            first,
            len: samples.len(),
        });
    }
}

/// Axis and place of the plane that divides a cell; `None` when single precision has no plane between its samples.
fn choose_plane(samples: &[Vec3]) -> Option<(usize, f32)> {
    let bounds = Bounds::of(samples.iter().copied())?;
    let size = bounds.size();
    let axis = if size.x >= size.y && size.x >= size.z { 0 } else { 1 + usize::from(size.z > size.y) };
    let (low, extent) = (bounds.min[axis], size[axis]);
    let mut near = [0u32; BINS];
    for p in samples {
        near[(((p[axis] - low) / extent * BINS as f32) as usize).min(BINS - 1)] += 1;
    }
    let bin = MIDDLE_BINS.min_by_key(|&bin| (near[bin], (2 * bin + 1).abs_diff(BINS)))?;
    let split = low + (bin as f32 + 0.5) / BINS as f32 * extent;
    (low < split && split < bounds.max[axis]).then_some((axis, split))
}

/// Brings what is `below` to the front and returns how many there are.
fn partition(samples: &mut [Vec3], below: impl Fn(&Vec3) -> bool) -> usize {
    let mut count = 0;
    for i in 0..samples.len() {
        if below(&samples[i]) {
            samples.swap(i, count);
            count += 1;
        }
    }
    count
}

/// The parts of a convex polygon with coordinates up to, and from, `plane`.
fn split(polygon: &[DVec3], axis: usize, plane: f64) -> [Vec<DVec3>; 2] {
    let mut parts = [Vec::new(), Vec::new()];
    for (i, &a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let above = |p: DVec3| usize::from(p[axis] >= plane);
        parts[above(a)].push(a);
        if above(a) != above(b) {
            let mut cut = a.lerp(b, (plane - a[axis]) / (b[axis] - a[axis]));
            cut[axis] = plane;
            parts.iter_mut().for_each(|part| part.push(cut));
        }
    }
    parts
}

/// Triangles of everything that stands still, world space.
fn for_each_triangle(scene: &Scene, mut act: impl FnMut([Vec3; 3])) {
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh as usize];
        if !instance.is_static(mesh) {
            continue;
        }
        for t in 0..mesh.triangle_count() {
            act(mesh.triangle(t).map(|p| instance.world_from_object.transform_point3(p)));
        }
    }
}

/// `count` points on what stands still, systematically spread.
fn surface_samples(scene: &Scene, count: usize) -> Vec<Vec3> {
    let area = |[a, b, c]: [Vec3; 3]| 0.5 * (b - a).as_dvec3().cross((c - a).as_dvec3()).length();
    let (mut total, mut triangles) = (0.0, 0u64);
    for_each_triangle(scene, |t| {
        total += area(t);
        triangles += 1;
    });
    let weight =
        |t| 0.5 / triangles as f64 + if total > 0.0 { 0.5 * area(t) / total } else { 0.5 / triangles as f64 };
    let mut samples = Vec::with_capacity(count);
    let mut sum = 0.0;
    for_each_triangle(scene, |t| {
        sum += weight(t);
        while samples.len() < count && samples.len() as f64 + 0.5 < sum * count as f64 {
            // The R2 sequence (Roberts 2018), folded into the triangle.
            let k = samples.len() as f64;
            let (x, y) = ((k * 0.754_877_666_246_693).fract(), (k * 0.569_840_290_998_053).fract());
            let (x, y) = if x + y > 1.0 { (1.0 - x, 1.0 - y) } else { (x, y) };
            let [a, b, c] = t.map(Vec3::as_dvec3);
            samples.push((a + x * (b - a) + y * (c - a)).as_vec3());
        }
    });
    samples
}
