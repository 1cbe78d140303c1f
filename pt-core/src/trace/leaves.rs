//! What the leaves of a mesh's tree hold: one triangle or two.

use crate::device::Device;
use glam::UVec3;
use obvhs::aabb::Aabb;

/// What a leaf of a mesh's tree holds (`trace/gpu_traversal.glsl`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leaf {
    /// One triangle, for CPU devices: there a ray pays for all triangles of the leaves that it meets.
    Triangle,
    /// Two triangles, neighbours as far as possible, for GPUs: with half as many leaves rays visit fewer nodes.
    Pair,
}

impl Leaf {
    /// Which one the kernels of the compute backend on a device read.
    pub(super) fn of(device: &Device) -> Self {
        if device.variant().gpu_traversal { Self::Pair } else { Self::Triangle }
    }

    /// Triangles of a leaf.
    pub const fn triangles(self) -> u32 {
        match self {
            Self::Triangle => 1,
            Self::Pair => 2,
        }
    }

    /// The leaves' triangles, as positions in `kept` (indices of triangles) and `bounds` (their boxes). One that finds no partner makes a
    /// pair with itself: rays meet it twice, which changes nothing, and refitting needs no exception.
    pub(super) fn gather(self, indices: &[UVec3], kept: &[u32], bounds: &[Aabb]) -> Vec<[u32; 2]> {
        match self {
            Self::Triangle => (0..kept.len() as u32).map(|i| [i, i]).collect(),
            Self::Pair => pairs(indices, kept, bounds),
        }
    }
}

/// Triangles at a vertex that are looked at for partners: bounds the time for fans.
const MOST_NEIGHBOURS: usize = 32;

/// Largest area of a pair's box relative to those of its triangles together. Above 1 its leaf is met more often than theirs, by the surface area
/// heuristic. On an H200 (`pt bench frame`, `pt bench path`) 0.8 is within 2 % of it, 0.6 is 3 to 4 % slower.
const LARGEST_RATIO: f32 = 1.0;

/// Each triangle with the one across an edge, or the next one of the list, that makes the smallest box with it relative to
/// both alone.
fn pairs(indices: &[UVec3], kept: &[u32], bounds: &[Aabb]) -> Vec<[u32; 2]> {
    let corners = |i: u32| indices[kept[i as usize] as usize].to_array();
    let count = kept.len() as u32;
    let at_vertex = AtVertex::new(count, &corners);
    let mut is_free = vec![true; kept.len()];
    let mut pairs = Vec::with_capacity(kept.len().div_ceil(2));
    for i in 0..count {
        if !is_free[i as usize] {
            continue;
        }
        let [a, b, c] = corners(i);
        // Of the two ends of an edge the one with fewer triangles.
        let ends = [[a, b], [b, c], [c, a]];
        let across = ends.iter().flat_map(|edge| {
            let [first, second] = edge.map(|vertex| at_vertex.of(vertex));
            let shorter = if first.len() <= second.len() { first } else { second };
            let shares_edge = |j: &u32| edge.iter().all(|v| corners(*j).contains(v));
            shorter.iter().copied().take(MOST_NEIGHBOURS).filter(shares_edge)
        });
        let mut best = (LARGEST_RATIO, i);
        for j in across.chain([i + 1]) {
            if j <= i || j >= count || !is_free[j as usize] {
                continue;
            }
            let [own, other] = [i, j].map(|k| bounds[k as usize]);
            // Not a number, so that they stay alone, where neither has an area: clustering would not tell their boxes apart.
            let ratio = own.union(&other).half_area() / (own.half_area() + other.half_area());
            if ratio < best.0 {
                best = (ratio, j);
            }
        }
        is_free[best.1 as usize] = false;
        pairs.push([i, best.1]);
    }
    pairs
}

/// The triangles at each vertex.
struct AtVertex {
    /// Where the list of a vertex begins; one more, the end of the last.
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

impl AtVertex {
    fn new(count: u32, corners: &impl Fn(u32) -> [u32; 3]) -> Self {
        let vertices = (0..count).flat_map(corners).max().map_or(0, |last| last as usize + 1);
        let mut starts = vec![0; vertices + 1];
        for vertex in (0..count).flat_map(corners) {
            starts[vertex as usize + 1] += 1;
        }
        for vertex in 0..vertices {
            starts[vertex + 1] += starts[vertex];
        }
        let mut next = starts.clone();
        let mut triangles = vec![0; 3 * count as usize];
        for i in 0..count {
            for vertex in corners(i) {
                let place = &mut next[vertex as usize];
                triangles[*place as usize] = i;
                *place += 1;
            }
        }
        Self { starts, triangles }
    }

    fn of(&self, vertex: u32) -> &[u32] {
        let [start, end] = [0, 1].map(|k| self.starts[vertex as usize + k] as usize);
        &self.triangles[start..end]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3A;

    fn boxes(positions: &[[f32; 2]], indices: &[UVec3]) -> Vec<Aabb> {
        let at = |v: u32| Vec3A::from([positions[v as usize][0], positions[v as usize][1], 0.0]);
        indices.iter().map(|i| Aabb::from_points(&i.to_array().map(at))).collect()
    }

    /// A strip of squares, each of two triangles that do not follow each other in the list.
    #[test]
    fn squares_are_pairs() {
        let count = 20;
        let positions: Vec<_> = (0..=count).flat_map(|x| [[x as f32, 0.0], [x as f32, 1.0]]).collect();
        let lower = (0..count).map(|x| UVec3::new(2 * x, 2 * x + 1, 2 * x + 2));
        let upper = (0..count).map(|x| UVec3::new(2 * x + 3, 2 * x + 2, 2 * x + 1));
        let indices: Vec<_> = lower.chain(upper).collect();
        let kept: Vec<_> = (0..2 * count).collect();
        let pairs = Leaf::Pair.gather(&indices, &kept, &boxes(&positions, &indices));
        assert_eq!(pairs, (0..count).map(|x| [x, x + count]).collect::<Vec<_>>());
    }

    /// Triangles far from each other stay alone; each one of a fan is in one leaf.
    #[test]
    fn each_triangle_is_in_one_leaf() {
        let far: Vec<_> =
            (0..9).map(|i| [f32::from(i as u8 % 3 == 2) + 10.0 * (i / 3) as f32, (i % 3) as f32]).collect();
        let apart: Vec<_> = (0..3).map(|t| UVec3::new(3 * t, 3 * t + 1, 3 * t + 2)).collect();
        let alone = Leaf::Pair.gather(&apart, &[0, 1, 2], &boxes(&far, &apart));
        assert_eq!(alone, [[0, 0], [1, 1], [2, 2]]);

        let count = 1001;
        let rim = |i: u32| (i as f32 * std::f32::consts::TAU / count as f32).sin_cos();
        let positions: Vec<_> = [[0.0; 2]].into_iter().chain((0..count).map(|i| rim(i).into())).collect();
        let indices: Vec<_> = (0..count).map(|i| UVec3::new(0, 1 + i, 1 + (i + 1) % count)).collect();
        let kept: Vec<_> = (0..count).collect();
        let pairs = Leaf::Pair.gather(&indices, &kept, &boxes(&positions, &indices));
        assert!(pairs.len() < 600, "{} leaves", pairs.len());
        let mut seen: Vec<_> =
            pairs.into_iter().flat_map(|[a, b]| [Some(a), (a != b).then_some(b)]).flatten().collect();
        seen.sort_unstable();
        assert_eq!(seen, kept);
    }
}
