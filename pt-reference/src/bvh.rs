//! Ray casts in double precision: a plain binary BVH, split at the median.

use glam::DVec3;

/// Most triangles of a leaf.
const LEAF: usize = 4;

/// Corners, and edges from the first of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triangle {
    pub(crate) corner: DVec3,
    pub(crate) edges: [DVec3; 2],
}

impl Triangle {
    pub(crate) fn new([a, b, c]: [DVec3; 3]) -> Self {
        Self { corner: a, edges: [b - a, c - a] }
    }

    /// Distance and weights of the second and third corner (Moller and Trumbore 1997).
    pub(crate) fn intersect(&self, origin: DVec3, direction: DVec3) -> Option<(f64, [f64; 2])> {
        let [e1, e2] = self.edges;
        let p = direction.cross(e2);
        let determinant = e1.dot(p);
        if determinant == 0.0 {
            return None;
        }
        let s = origin - self.corner;
        let q = s.cross(e1);
        let (u, v) = (s.dot(p) / determinant, direction.dot(q) / determinant);
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then(|| (e2.dot(q) / determinant, [u, v]))
    }
}

struct Node {
    min: DVec3,
    max: DVec3,
    /// First entry of `order` and number of entries of a leaf; of an inner node the second child and 0 (the first child
    /// follows the node).
    start: usize,
    count: usize,
}

pub(crate) struct Bvh {
    triangles: Vec<Triangle>,
    order: Vec<usize>,
    nodes: Vec<Node>,
}

/// Nearest hit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    pub(crate) t: f64,
    pub(crate) triangle: usize,
    /// Weights of the second and third corner.
    pub(crate) weights: [f64; 2],
}

impl Bvh {
    pub(crate) fn new(triangles: Vec<Triangle>) -> Self {
        let order = (0..triangles.len()).collect();
        let mut bvh = Self { triangles, order, nodes: Vec::new() };
        if !bvh.order.is_empty() {
            bvh.build(0, bvh.order.len());
        }
        bvh
    }

    fn build(&mut self, start: usize, end: usize) -> usize {
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for t in self.order[start..end].iter().map(|&i| self.triangles[i]) {
            for corner in [t.corner, t.corner + t.edges[0], t.corner + t.edges[1]] {
                (min, max) = (min.min(corner), max.max(corner));
            }
        }
        // Room for the rounding of the box test.
        let slack = 1e-9 * min.abs().max(max.abs());
        let index = self.nodes.len();
        self.nodes.push(Node { min: min - slack, max: max + slack, start, count: end - start });
        if end - start > LEAF {
            let axis = (max - min).to_array();
            let axis = (0..3).fold(0, |best, i| if axis[i] > axis[best] { i } else { best });
            let triangles = &self.triangles;
            let center = |i: &usize| {
                3.0 * triangles[*i].corner[axis] + triangles[*i].edges[0][axis] + triangles[*i].edges[1][axis]
            };
            let middle = (end - start) / 2;
            self.order[start..end]
                .select_nth_unstable_by(middle, |a, b| center(a).total_cmp(&center(b)).then(a.cmp(b)));
            self.build(start, start + middle);
            let second = self.build(start + middle, end);
            self.nodes[index].start = second;
            self.nodes[index].count = 0;
        }
        index
    }

    /// Calls `found` for every hit in (t_min, t_max); it returns the new t_max.
    fn visit(
        &self,
        origin: DVec3,
        direction: DVec3,
        t_min: f64,
        t_max: f64,
        mut found: impl FnMut(Hit) -> f64,
    ) {
        let inverse = direction.recip();
        let mut t_max = t_max;
        let mut stack = if self.nodes.is_empty() { Vec::new() } else { vec![0] };
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index];
            let (a, b) = ((node.min - origin) * inverse, (node.max - origin) * inverse);
            // 0 x infinity is no number: a ray in the plane of a box face counts as inside.
            let near = [0, 1, 2].iter().fold(t_min, |t, &i| t.max(a[i].min(b[i])));
            let far = [0, 1, 2].iter().fold(t_max, |t, &i| t.min(a[i].max(b[i])));
            if near > far {
                continue;
            }
            if node.count == 0 {
                stack.extend([node.start, index + 1]);
                continue;
            }
            for &triangle in &self.order[node.start..node.start + node.count] {
                if let Some((t, weights)) = self.triangles[triangle].intersect(origin, direction)
                    && t > t_min
                    && t < t_max
                {
                    t_max = found(Hit { t, triangle, weights });
                }
            }
        }
    }

    /// Nearest hit beyond `t_min`.
    pub(crate) fn closest(&self, origin: DVec3, direction: DVec3, t_min: f64) -> Option<Hit> {
        let mut nearest = None;
        self.visit(origin, direction, t_min, f64::INFINITY, |hit| {
            nearest = Some(hit);
            hit.t
        });
        nearest
    }

    /// Whether anything lies between `t_min` and `t_max`.
    pub(crate) fn occluded(&self, origin: DVec3, direction: DVec3, t_min: f64, t_max: f64) -> bool {
        let mut any = false;
        self.visit(origin, direction, t_min, t_max, |_| {
            any = true;
            f64::NEG_INFINITY
        });
        any
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pseudo-random number in [-1, 1).
    fn noise(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    #[test]
    fn tree_finds_what_a_loop_finds() {
        let mut state = 1;
        let mut point = || DVec3::new(noise(&mut state), noise(&mut state), noise(&mut state));
        let triangles: Vec<Triangle> = (0..300)
            .map(|_| {
                let corner = point();
                Triangle::new([corner, corner + 0.2 * point(), corner + 0.2 * point()])
            })
            .collect();
        let bvh = Bvh::new(triangles.clone());
        let mut hits = 0;
        for i in 0..2000 {
            let origin = 2.0 * point();
            // Also along the axes, where a component's inverse is infinite.
            let direction = if i % 10 == 0 { DVec3::X } else { point() - origin };
            let expected = triangles
                .iter()
                .enumerate()
                .filter_map(|(i, t)| t.intersect(origin, direction).map(|(t, _)| (t, i)))
                .filter(|(t, _)| *t > 0.0)
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let found = bvh.closest(origin, direction, 0.0).map(|hit| (hit.t, hit.triangle));
            assert_eq!(found, expected);
            assert_eq!(bvh.occluded(origin, direction, 0.0, f64::INFINITY), expected.is_some());
            if let Some((t, _)) = expected {
                assert!(!bvh.occluded(origin, direction, 0.0, t));
                hits += 1;
            }
        }
        assert!(hits > 200);
    }
}
