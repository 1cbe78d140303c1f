//! Closed bodies, exact to the bit: neighbouring triangles name the same positions, so that no ray slips through a seam and
//! a dielectric has an inside.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use glam::{Affine3A, DVec2, DVec3, Vec2, Vec3};

use super::shapes::Shape;
use crate::Mesh;

impl Shape {
    /// A sphere as an icosahedron split `levels` times: 20 x 4^levels triangles with corners on the sphere. `smooth`: normals
    /// of the sphere; else each triangle has its own, and the body is a convex polyhedron and nothing else.
    pub fn icosphere(
        &mut self,
        center: Vec3,
        radius: f32,
        levels: u32,
        smooth: bool,
        material: u32,
    ) -> &mut Self {
        let (directions, faces) = icosphere(levels);
        let at = |i: u32| center + radius * directions[i as usize].as_vec3();
        if smooth {
            let vertices: Vec<u32> = directions
                .iter()
                .map(|d| self.vertex(center + radius * d.as_vec3(), d.as_vec3(), lat_long(*d)))
                .collect();
            faces.iter().for_each(|f| self.triangle(f.map(|i| vertices[i as usize]), material));
        } else {
            faces.iter().for_each(|f| self.polygon(&f.map(at), |_| Vec2::ZERO, material));
        }
        self
    }

    /// Turns a line of (radius, height) about the vertical through `center`, in `segments` steps. The solid is on the left
    /// hand of the line, where the axis is when it goes up. Each piece has its own normals, round about the axis; a radius
    /// of 0 closes the surface. `material` is asked for each piece.
    pub fn revolve(
        &mut self,
        center: Vec3,
        segments: usize,
        line: &[Vec2],
        material: impl Fn(usize) -> u32,
    ) -> &mut Self {
        for (piece, ends) in line.windows(2).enumerate() {
            let along = (ends[1] - ends[0]).normalize_or(Vec2::Y);
            let (outward, up) = (along.y, -along.x);
            let material = material(piece);
            let mut ring = |end: Vec2, v: f32| -> Vec<u32> {
                (0..=segments)
                    .map(|k| {
                        let round = round(k, segments);
                        let normal = Vec3::new(outward * round.x, up, outward * round.y);
                        self.vertex(
                            on_ring(center, end, k, segments),
                            normal,
                            Vec2::new(k as f32 / segments as f32, v),
                        )
                    })
                    .collect()
            };
            let (low, high) = (ring(ends[0], 0.0), ring(ends[1], 1.0));
            for k in 0..segments {
                if ends[0].x > 0.0 {
                    self.triangle([low[k], low[k + 1], high[k + 1]], material);
                }
                if ends[1].x > 0.0 {
                    self.triangle([low[k], high[k + 1], high[k]], material);
                }
            }
        }
        self
    }
}

/// Cosine and minus sine of step `k` of a full turn; the last step is the first.
fn round(k: usize, segments: usize) -> Vec2 {
    let (sin, cos) = (TAU * (k % segments) as f64 / segments as f64).sin_cos();
    Vec2::new(cos as f32, -sin as f32)
}

/// A corner of [`Shape::revolve`].
pub(super) fn on_ring(center: Vec3, radius_height: Vec2, k: usize, segments: usize) -> Vec3 {
    let round = round(k, segments);
    center + Vec3::new(radius_height.x * round.x, radius_height.y, radius_height.x * round.y)
}

fn lat_long(d: DVec3) -> Vec2 {
    Vec2::new(0.5 + (d.z.atan2(d.x) / TAU) as f32, (d.y.clamp(-1.0, 1.0).acos() / (0.5 * TAU)) as f32)
}

fn icosphere(levels: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let g = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut points: Vec<DVec3> = [(0.0, 1.0, g), (0.0, -1.0, g), (0.0, 1.0, -g), (0.0, -1.0, -g)]
        .into_iter()
        .flat_map(|(a, b, c)| [DVec3::new(a, b, c), DVec3::new(b, c, a), DVec3::new(c, a, b)])
        .map(DVec3::normalize)
        .collect();
    // Of all triples, those whose corners are neighbours; turned outwards.
    let edge = points[0].distance(points[3]) * 1.01;
    let near = |i: usize, j: usize| points[i].distance(points[j]) < edge;
    let mut faces = Vec::new();
    for (a, b, c) in (0..12).flat_map(|a| (a + 1..12).flat_map(move |b| (b + 1..12).map(move |c| (a, b, c))))
    {
        if near(a, b) && near(b, c) && near(a, c) {
            let outward = points[a].dot(points[b].cross(points[c])) > 0.0;
            faces.push(if outward { [a as u32, b as u32, c as u32] } else { [a as u32, c as u32, b as u32] });
        }
    }
    for _ in 0..levels {
        let mut middles = BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]).normalize());
                points.len() as u32 - 1
            })
        };
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    (points, faces)
}

/// Faces of a box about the origin under a transform, seen from outside; all eight corners are computed once.
pub(super) fn box_faces(half: Vec3, transform: Affine3A) -> [[Vec3; 4]; 6] {
    let corner = |i: usize| {
        let sign = |bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        transform.transform_point3(half * Vec3::new(sign(0), sign(1), sign(2)))
    };
    [[1, 3, 7, 5], [0, 4, 6, 2], [2, 6, 7, 3], [0, 1, 5, 4], [4, 5, 7, 6], [0, 2, 3, 1]]
        .map(|f| f.map(corner))
}

/// The parts of a convex polygon above and below the level `y`. The cut of an edge is the same point for both of its faces.
pub(super) fn split_at_level(polygon: &[Vec3], y: f32) -> [Vec<Vec3>; 2] {
    let mut parts = [Vec::new(), Vec::new()];
    for (i, &a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        parts[usize::from(a.y < y)].push(a);
        if (a.y < y) != (b.y < y) {
            let (low, high) =
                if a.y < b.y { (a.as_dvec3(), b.as_dvec3()) } else { (b.as_dvec3(), a.as_dvec3()) };
            let cut = low.lerp(high, (f64::from(y) - low.y) / (high.y - low.y)).as_vec3().with_y(y);
            parts.iter_mut().for_each(|part| part.push(cut));
        }
    }
    parts
}

/// Triangulates a polygon (counter-clockwise) with holes (clockwise) by ear clipping over bridges to the holes (Eberly 2002,
/// "Triangulation by Ear Clipping"). Indices count through the polygon, then the holes in order; no point is added.
pub(super) fn triangulate(outer: &[DVec2], holes: &[Vec<DVec2>]) -> Vec<[usize; 3]> {
    let points: Vec<DVec2> = outer.iter().chain(holes.iter().flatten()).copied().collect();
    let mut ring: Vec<usize> = (0..outer.len()).collect();
    let mut first = outer.len();
    let mut edges: Vec<(usize, usize)> = Vec::new();
    let mut spans = vec![(0, outer.len())];
    for hole in holes {
        spans.push((first, hole.len()));
        first += hole.len();
    }
    for &(start, n) in &spans {
        edges.extend((0..n).map(|i| (start + i, start + (i + 1) % n)));
    }
    for &(start, n) in &spans[1..] {
        // The shortest bridge that crosses nothing.
        let mut bridges: Vec<(usize, usize)> =
            (0..ring.len()).flat_map(|i| (start..start + n).map(move |j| (i, j))).collect();
        bridges.sort_by(|a, b| {
            let length = |&(i, j): &(usize, usize)| points[ring[i]].distance_squared(points[j]);
            length(a).total_cmp(&length(b))
        });
        let free = |&&(i, j): &&(usize, usize)| {
            let (a, b) = (ring[i], j);
            !edges
                .iter()
                .any(|&(c, d)| ![c, d].contains(&a) && ![c, d].contains(&b) && cross(&points, a, b, c, d))
        };
        let (i, j) = bridges.iter().find(free).copied().unwrap_or((0, start));
        let around = (0..=n).map(|k| start + (j - start + k) % n);
        let mut joined = ring[..=i].to_vec();
        joined.extend(around);
        joined.extend_from_slice(&ring[i..]);
        edges.push((ring[i], j));
        ring = joined;
    }
    clip_ears(&points, ring)
}

fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

fn cross(p: &[DVec2], a: usize, b: usize, c: usize, d: usize) -> bool {
    turn(p[a], p[b], p[c]) * turn(p[a], p[b], p[d]) < 0.0
        && turn(p[c], p[d], p[a]) * turn(p[c], p[d], p[b]) < 0.0
}

fn clip_ears(points: &[DVec2], mut ring: Vec<usize>) -> Vec<[usize; 3]> {
    let mut triangles = Vec::new();
    while ring.len() > 3 {
        let n = ring.len();
        let corner = |i: usize| [ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]];
        let is_ear = |&i: &usize| {
            let [a, b, c] = corner(i);
            let inside = |&q: &usize| {
                ![a, b, c].contains(&q)
                    && [(a, b), (b, c), (c, a)]
                        .iter()
                        .all(|&(s, t)| turn(points[s], points[t], points[q]) >= 0.0)
            };
            turn(points[a], points[b], points[c]) > 0.0 && !ring.iter().any(inside)
        };
        // The ear with the largest smallest angle would be prettier; the first will do.
        let Some(ear) = (0..n).find(is_ear) else { break };
        triangles.push(corner(ear));
        ring.remove(ear);
    }
    triangles.extend(<[usize; 3]>::try_from(ring));
    triangles
}

/// Area of all triangles, m^2.
pub(super) fn area(mesh: &Mesh) -> f64 {
    let triangle = |t: usize| {
        let [a, b, c] = mesh.triangle(t).map(|p| p.as_dvec3());
        0.5 * (b - a).cross(c - a).length()
    };
    (0..mesh.triangle_count()).map(triangle).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_tile_a_polygon_with_holes() {
        let ring = |n: usize, r: f64, at: DVec2, sign: f64| -> Vec<DVec2> {
            (0..n).map(|k| at + r * DVec2::from_angle(sign * TAU * k as f64 / n as f64)).collect()
        };
        let area =
            |p: &[DVec2]| -> f64 { (0..p.len()).map(|i| 0.5 * p[i].perp_dot(p[(i + 1) % p.len()])).sum() };
        let outer = ring(32, 1.0, DVec2::ZERO, 1.0);
        let holes =
            vec![ring(4, 0.3, DVec2::new(0.4, 0.1), -1.0), ring(5, 0.25, DVec2::new(-0.5, -0.2), -1.0)];
        let points: Vec<DVec2> = outer.iter().chain(holes.iter().flatten()).copied().collect();
        let triangles = triangulate(&outer, &holes);
        let sum: f64 = triangles.iter().map(|&[a, b, c]| 0.5 * turn(points[a], points[b], points[c])).sum();
        let expected = area(&outer) + holes.iter().map(|h| area(h)).sum::<f64>();
        assert!((sum - expected).abs() < 1e-12, "{sum} for {expected}");
        assert!(triangles.iter().all(|&[a, b, c]| turn(points[a], points[b], points[c]) > 0.0));
        // n - 2 of a polygon, 2 + n more for each hole.
        assert_eq!(triangles.len(), 30 + 6 + 7);
    }

    #[test]
    fn an_icosphere_nears_the_sphere() {
        let mut shape = Shape::default();
        shape.icosphere(Vec3::X, 2.0, 3, true, 0);
        let mesh = shape.into_mesh();
        assert_eq!(mesh.triangle_count(), 20 * 64);
        assert!((area(&mesh) / (8.0 * TAU) - 1.0).abs() < 0.01, "{}", area(&mesh));
        assert!(mesh.positions.iter().all(|p| (p.distance(Vec3::X) - 2.0).abs() < 1e-6));
    }
}
