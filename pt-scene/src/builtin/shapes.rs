//! Mesh building for the built-in scenes. Lengths in metres; fronts are counter-clockwise.

use std::f32::consts::{PI, TAU};

use glam::{Affine3A, Vec2, Vec3, Vec4};

use crate::Mesh;

/// A mesh under construction.
#[derive(Default)]
pub(super) struct Shape {
    mesh: Mesh,
}

/// An arched opening in a wall, centred at `center` along it: straight sides from `sill` to `spring`, a half circle above.
#[derive(Clone, Copy)]
pub(super) struct Arch {
    pub center: f32,
    pub half_width: f32,
    pub sill: f32,
    pub spring: f32,
}

/// Segments of the half circle of an arch.
const ARCH_SEGMENTS: usize = 24;

impl From<Mesh> for Shape {
    fn from(mesh: Mesh) -> Self {
        Self { mesh }
    }
}

impl Shape {
    pub fn into_mesh(mut self) -> Mesh {
        self.mesh.compute_tangents();
        self.mesh
    }

    pub(super) fn vertex(&mut self, position: Vec3, normal: Vec3, uv: Vec2) -> u32 {
        self.mesh.positions.push(position);
        self.mesh.normals.push(normal);
        self.mesh.uv0.push(uv);
        self.mesh.uv1.push(uv);
        self.mesh.colors.push(Vec4::ONE);
        self.mesh.positions.len() as u32 - 1
    }

    pub(super) fn triangle(&mut self, corners: [u32; 3], material: u32) {
        self.mesh.indices.push(corners);
        self.mesh.triangle_materials.push(material);
    }

    /// A flat polygon with corners `p` and texture coordinates in metres along its own axes.
    pub fn polygon(&mut self, p: &[Vec3], uv: impl Fn(Vec3) -> Vec2, material: u32) {
        let normal = (p[1] - p[0]).cross(p[2] - p[0]).normalize_or(Vec3::Y);
        let v: Vec<u32> = p.iter().map(|&q| self.vertex(q, normal, uv(q))).collect();
        for i in 1..v.len() - 1 {
            self.triangle([v[0], v[i], v[i + 1]], material);
        }
    }

    /// A parallelogram seen from `u` x `v`. The texture is repeated `repeat` times, upright when `v` points up.
    pub fn quad(&mut self, corner: Vec3, u: Vec3, v: Vec3, repeat: Vec2, material: u32) -> &mut Self {
        let normal = u.cross(v).normalize_or(Vec3::Y);
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let [a, b, c, d] =
            corners.map(|(s, t)| self.vertex(corner + s * u + t * v, normal, Vec2::new(s, 1.0 - t) * repeat));
        self.triangle([a, b, c], material);
        self.triangle([a, c, d], material);
        self
    }

    /// A box seen from outside, texture coordinates in metres x `per_metre`.
    pub fn cuboid(&mut self, min: Vec3, max: Vec3, per_metre: f32, material: u32) -> &mut Self {
        let s = max - min;
        let (x, y, z) = (Vec3::X * s.x, Vec3::Y * s.y, Vec3::Z * s.z);
        let mut face = |corner, u: Vec3, v: Vec3| {
            self.quad(corner, u, v, per_metre * Vec2::new(u.length(), v.length()), material);
        };
        face(min + z, x, y);
        face(max - y, -z, y);
        face(min + x, -x, y);
        face(min, z, y);
        face(min + z + y, x, -z);
        face(min, x, z);
        self
    }

    /// A smooth surface over 0..1 x 0..1 in `nu` x `nv` cells, seen from dP/du x dP/dv. `repeat` scales (u, v) to texture
    /// coordinates. Normals are central differences; at poles they fall back to the direction from the middle of the row.
    pub fn surface(
        &mut self,
        nu: usize,
        nv: usize,
        repeat: Vec2,
        material: u32,
        p: impl Fn(f32, f32) -> Vec3,
    ) -> &mut Self {
        const STEP: f32 = 2e-4;
        let base = self.mesh.positions.len() as u32;
        for j in 0..=nv {
            for i in 0..=nu {
                let (u, v) = (i as f32 / nu as f32, j as f32 / nv as f32);
                let normal_at =
                    |v: f32| (p(u + STEP, v) - p(u - STEP, v)).cross(p(u, v + STEP) - p(u, v - STEP));
                let inward = if v < 0.5 { 4.0 * STEP } else { -4.0 * STEP };
                let n = normal_at(v);
                let normal = if n.length() > 1e-9 { n } else { normal_at(v + inward) };
                self.vertex(p(u, v), normal.normalize_or(Vec3::Y), Vec2::new(u, v) * repeat);
            }
        }
        let row = nu as u32 + 1;
        for j in 0..nv as u32 {
            for i in 0..nu as u32 {
                let a = base + j * row + i;
                self.triangle([a, a + 1, a + row + 1], material);
                self.triangle([a, a + row + 1, a + row], material);
            }
        }
        self
    }

    /// A sphere in `2 n` x `n` cells.
    pub fn sphere(&mut self, center: Vec3, radius: f32, n: usize, repeat: Vec2, material: u32) -> &mut Self {
        self.surface(2 * n, n, repeat, material, move |u, v| {
            let ((sin_a, cos_a), (sin_p, cos_p)) = ((TAU * u).sin_cos(), (PI * v).sin_cos());
            center + radius * Vec3::new(sin_p * cos_a, cos_p, sin_p * sin_a) * Vec3::new(1.0, 1.0, -1.0)
        });
        self.flip_last(4 * n * n)
    }

    /// Turns the last `triangles` triangles and their vertices inside out.
    fn flip_last(&mut self, triangles: usize) -> &mut Self {
        let first = self.mesh.indices.len() - triangles;
        let mut vertices: Vec<u32> = self.mesh.indices[first..].iter().flatten().copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices.iter().for_each(|&v| self.mesh.normals[v as usize] *= -1.0);
        self.mesh.indices[first..].iter_mut().for_each(|t| t.swap(1, 2));
        self
    }

    /// A solid of revolution about the vertical through `center`. `profile` maps v (0 bottom, 1 top) to (radius, height);
    /// `flute` scales the radius by angle (radians) and v.
    pub fn lathe(
        &mut self,
        center: Vec3,
        cells: (usize, usize),
        repeat: Vec2,
        material: u32,
        profile: impl Fn(f32) -> Vec2,
        flute: impl Fn(f32, f32) -> f32,
    ) -> &mut Self {
        self.surface(cells.0, cells.1, repeat, material, move |u, v| {
            let q = profile(v);
            let (sin, cos) = (TAU * u).sin_cos();
            let r = q.x * flute(TAU * u, v);
            center + Vec3::new(r * cos, q.y, -r * sin)
        })
    }

    /// A tube of the given radius round a closed curve over 0..1.
    pub fn tube(
        &mut self,
        cells: (usize, usize),
        radius: f32,
        repeat: Vec2,
        material: u32,
        curve: impl Fn(f32) -> Vec3,
    ) -> &mut Self {
        self.surface(cells.0, cells.1, repeat, material, move |u, v| {
            let along = (curve(u + 1e-3) - curve(u - 1e-3)).normalize_or(Vec3::Z);
            // The curve must not run vertically, which no knot of ours does for long.
            let side = along.cross(Vec3::Y).normalize_or(Vec3::X);
            let (sin, cos) = (TAU * v).sin_cos();
            curve(u) + radius * (side * cos + side.cross(along) * sin)
        })
    }

    /// A wall `length` along `along` from `origin`, `height` up, seen from `along` x +Y, with arched openings that must not
    /// overlap and are in order. Openings are lined to the depth of `thickness`; the back of the wall is built as well.
    pub fn wall(
        &mut self,
        origin: Vec3,
        along: Vec3,
        size: Vec2,
        thickness: f32,
        arches: &[Arch],
        material: u32,
    ) -> &mut Self {
        let normal = along.cross(Vec3::Y);
        let front = move |a: f32, y: f32| origin + along * a + Vec3::Y * y;
        let uv = move |q: Vec3| Vec2::new((q - origin).dot(along), -(q - origin).y);
        let mut strip = |a: f32, b: f32, low: (f32, f32), high: (f32, f32)| {
            if b - a > 1e-5 && high.0 + high.1 - low.0 - low.1 > 1e-5 {
                let corners = [front(a, low.0), front(b, low.1), front(b, high.1), front(a, high.0)];
                self.polygon(&corners, uv, material);
                let back = corners.map(|q| q - normal * thickness);
                self.polygon(&[back[1], back[0], back[3], back[2]], uv, material);
            }
        };
        let mut end = 0.0;
        for arch in arches {
            let (left, right) = (arch.center - arch.half_width, arch.center + arch.half_width);
            strip(end, left, (0.0, 0.0), (size.y, size.y));
            strip(left, right, (0.0, 0.0), (arch.sill, arch.sill));
            for i in 0..ARCH_SEGMENTS {
                let (a, b) = (arch.point(i), arch.point(i + 1));
                strip(a.x, b.x, (a.y, b.y), (size.y, size.y));
            }
            end = right;
        }
        strip(end, size.x, (0.0, 0.0), (size.y, size.y));
        for arch in arches {
            self.lining(arch, &front, normal * thickness, material);
        }
        self
    }

    /// The inner faces of an opening.
    fn lining(&mut self, arch: &Arch, front: &impl Fn(f32, f32) -> Vec3, depth: Vec3, material: u32) {
        let (left, right) = (arch.center - arch.half_width, arch.center + arch.half_width);
        let mut face = |a: Vec3, b: Vec3| {
            if a.distance(b) > 1e-5 {
                self.quad(a - depth, b - a, depth, Vec2::new(a.distance(b), depth.length()), material);
            }
        };
        face(front(left, arch.sill), front(left, arch.spring));
        face(front(right, arch.spring), front(right, arch.sill));
        // An opening that reaches down to the foot of the wall has no sill of its own.
        if arch.sill > 0.0 {
            face(front(right, arch.sill), front(left, arch.sill));
        }
        let arc = *arch;
        let length = PI * arch.half_width;
        let repeat = Vec2::new(length, depth.length());
        self.surface(ARCH_SEGMENTS, 1, repeat, material, |u, v| {
            let (sin, cos) = (PI * u).sin_cos();
            front(arc.center - arc.half_width * cos, arc.spring + arc.half_width * sin) - depth * (1.0 - v)
        });
    }

    /// Moves everything built so far.
    pub fn transformed(mut self, transform: Affine3A) -> Self {
        let normal_matrix = transform.matrix3.inverse().transpose();
        self.mesh.positions.iter_mut().for_each(|p| *p = transform.transform_point3(*p));
        self.mesh.normals.iter_mut().for_each(|n| *n = (normal_matrix * *n).normalize_or(Vec3::Y));
        self
    }

    /// Adds another shape.
    pub fn merge(&mut self, mut other: Self) -> &mut Self {
        other.mesh.tangents = vec![Vec4::X; other.mesh.positions.len()];
        self.mesh.append(&other.mesh);
        self
    }
}

impl Arch {
    /// A point of the half circle, from left to right.
    fn point(&self, i: usize) -> Vec2 {
        let (sin, cos) = (PI * i as f32 / ARCH_SEGMENTS as f32).sin_cos();
        Vec2::new(self.center - self.half_width * cos, self.spring + self.half_width * sin.max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six times the enclosed volume; positive when a closed surface faces outwards.
    fn volume6(mesh: &Mesh) -> f32 {
        (0..mesh.triangle_count()).map(|t| mesh.triangle(t)).map(|[a, b, c]| a.dot(b.cross(c))).sum()
    }

    /// Shading normals on the side of the geometric ones.
    fn agrees(mesh: &Mesh) -> bool {
        mesh.indices.iter().enumerate().all(|(t, corners)| {
            let [a, b, c] = mesh.triangle(t);
            let n = (b - a).cross(c - a);
            n.length() < 1e-8 || corners.iter().all(|&v| mesh.normals[v as usize].dot(n) > 0.0)
        })
    }

    #[test]
    fn closed_shapes_face_outwards() {
        let mut cuboid = Shape::default();
        cuboid.cuboid(Vec3::splat(-1.0), Vec3::splat(1.0), 1.0, 0);
        let mut sphere = Shape::default();
        sphere.sphere(Vec3::ZERO, 1.0, 32, Vec2::ONE, 0);
        let mut tube = Shape::default();
        tube.tube((128, 16), 0.2, Vec2::ONE, 0, |u| {
            Vec3::new((TAU * u).cos(), 0.3 * (2.0 * TAU * u).sin(), (TAU * u).sin())
        });
        let mut lathe = Shape::default();
        lathe.lathe(
            Vec3::ZERO,
            (64, 16),
            Vec2::ONE,
            0,
            |v| Vec2::new((PI * v).sin().max(1e-4), -(PI * v).cos()),
            |_, _| 1.0,
        );
        for (shape, expected) in [(cuboid, 8.0), (sphere, 4.19), (tube, 0.83), (lathe, 4.19)] {
            let mesh = shape.into_mesh();
            assert!(
                (volume6(&mesh) / 6.0 / expected - 1.0).abs() < 0.1,
                "{} of {expected}",
                volume6(&mesh) / 6.0
            );
            assert!(agrees(&mesh));
        }
    }

    #[test]
    fn a_wall_with_an_arch_faces_out_of_the_stone() {
        let arch = Arch { center: 2.0, half_width: 1.0, sill: 0.5, spring: 2.0 };
        let mut wall = Shape::default();
        wall.wall(Vec3::ZERO, Vec3::X, Vec2::new(4.0, 4.0), 0.5, &[arch], 0);
        let mesh = wall.into_mesh();
        assert!(agrees(&mesh));
        // Front z = 0, back z = -0.5; a vector area of zero along z says that both have the same outline.
        let area: Vec3 =
            (0..mesh.triangle_count()).map(|t| mesh.triangle(t)).map(|[a, b, c]| (b - a).cross(c - a)).sum();
        assert!(area.z.abs() < 1e-3, "{area}");
        // The lining looks into the opening.
        for (t, corners) in mesh.indices.iter().enumerate() {
            let [a, b, c] = mesh.triangle(t);
            let n = mesh.normals[corners[0] as usize];
            if n.z.abs() < 0.5 {
                let center = (a + b + c) / 3.0;
                assert!(
                    (Vec3::new(2.0, 1.7, center.z) - center).dot(n) > 0.0,
                    "triangle {t} at {center} faces {n}"
                );
            }
        }
    }
}
