use glam::{DVec3, Vec2, Vec3, Vec4};

use crate::Material;
use crate::animation::{Deformation, Influence, MorphDelta, VertexLists};

/// Triangles with their vertices, in object space. All vertex arrays have the same length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Name from the file, for messages.
    pub name: String,
    /// Metres.
    pub positions: Vec<Vec3>,
    /// Unit shading normals.
    pub normals: Vec<Vec3>,
    /// Unit tangents (xyz) with the sign (w, +1 or -1) of bitangent = w cross(normal, tangent).
    pub tangents: Vec<Vec4>,
    /// First texture coordinates, v down; zero where the file has none.
    pub uv0: Vec<Vec2>,
    /// Second texture coordinates; zero where the file has none.
    pub uv1: Vec<Vec2>,
    /// Linear RGBA that multiplies the base colour; white where the file has none.
    pub colors: Vec<Vec4>,
    /// Vertices of each triangle, counter-clockwise seen from the front.
    pub indices: Vec<[u32; 3]>,
    /// Material of each triangle, an index into [`crate::Scene::materials`].
    pub triangle_materials: Vec<u32>,
    /// Triangles from here on have alpha to be looked at ([`Material::is_masked`]); those before have none.
    pub first_masked: usize,
    /// Joints that move each vertex; empty without a skin.
    pub influences: VertexLists<Influence>,
    /// What morph targets do to each vertex; empty without any.
    pub morphs: VertexLists<MorphDelta>,
    /// Vertices at rest and the pose now, of a mesh that changes its shape.
    pub deformation: Option<Box<Deformation>>,
}

impl Mesh {
    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.indices.len()
    }

    /// Corners of a triangle, object space.
    pub fn triangle(&self, triangle: usize) -> [Vec3; 3] {
        self.indices[triangle].map(|v| self.positions[v as usize])
    }

    /// Sorts triangles into opaque and masked ones, each in their former order, and sets `first_masked`.
    pub fn sort_by_opacity(&mut self, materials: &[Material]) {
        let masked = |t: usize| materials[self.triangle_materials[t] as usize].is_masked();
        if (0..self.indices.len()).all(|t| !masked(t)) {
            self.first_masked = self.indices.len();
            return;
        }
        let (mut order, rest): (Vec<usize>, Vec<usize>) = (0..self.indices.len()).partition(|&t| !masked(t));
        self.first_masked = order.len();
        order.extend(rest);
        self.indices = order.iter().map(|&t| self.indices[t]).collect();
        self.triangle_materials = order.iter().map(|&t| self.triangle_materials[t]).collect();
    }

    /// Whether a vertex has another colour than opaque white.
    pub fn is_colored(&self) -> bool {
        self.colors.iter().any(|&color| color != Vec4::ONE)
    }

    /// Appends another mesh's vertices and triangles; both count as unsorted afterwards.
    pub fn append(&mut self, other: &Mesh) {
        let base = self.positions.len() as u32;
        self.influences.append(&other.influences, self.vertex_count(), other.vertex_count());
        self.morphs.append(&other.morphs, self.vertex_count(), other.vertex_count());
        self.positions.extend_from_slice(&other.positions);
        self.normals.extend_from_slice(&other.normals);
        self.tangents.extend_from_slice(&other.tangents);
        self.uv0.extend_from_slice(&other.uv0);
        self.uv1.extend_from_slice(&other.uv1);
        self.colors.extend_from_slice(&other.colors);
        self.indices.extend(other.indices.iter().map(|t| t.map(|v| v + base)));
        self.triangle_materials.extend_from_slice(&other.triangle_materials);
    }

    /// Replaces the vertices by those that `sources` names; what is not filled yet stays empty. Indices are left alone.
    pub fn gather(&mut self, sources: &[u32]) {
        fn pick<T: Copy>(values: &mut Vec<T>, sources: &[u32]) {
            if !values.is_empty() {
                *values = sources.iter().map(|&v| values[v as usize]).collect();
            }
        }
        pick(&mut self.positions, sources);
        pick(&mut self.normals, sources);
        pick(&mut self.tangents, sources);
        pick(&mut self.uv0, sources);
        pick(&mut self.uv1, sources);
        pick(&mut self.colors, sources);
        if !self.influences.is_empty() {
            self.influences = self.influences.select(sources);
        }
        if !self.morphs.is_empty() {
            self.morphs = self.morphs.select(sources);
        }
    }

    /// Gives every triangle its own three vertices and the geometric normal, as glTF wants where normals are missing.
    pub fn flat_shade(&mut self) {
        let corners: Vec<u32> = self.indices.iter().flatten().copied().collect();
        self.gather(&corners);
        self.indices = (0..self.indices.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        self.normals =
            self.positions.chunks_exact(3).flat_map(|p| [face_normal(p[1] - p[0], p[2] - p[0]); 3]).collect();
        if !self.morphs.is_empty() {
            self.flat_morphs();
        }
    }

    /// Of each vertex the normal of its triangles, weighted by their areas; +Y where they have none.
    pub fn vertex_normals(&self) -> Vec<Vec3> {
        let mut sums = vec![DVec3::ZERO; self.positions.len()];
        for corners in &self.indices {
            let [a, b, c] = corners.map(|v| self.positions[v as usize].as_dvec3());
            let normal = (b - a).cross(c - a);
            corners.iter().for_each(|&v| sums[v as usize] += normal);
        }
        sums.into_iter().map(|sum| sum.try_normalize().map_or(Vec3::Y, DVec3::as_vec3)).collect()
    }

    /// Tangents from the derivatives of the first texture coordinates, for shapes made by code, whose vertices are split
    /// at seams already: per-triangle dP/du and dP/dv summed at the
    /// vertices, made orthogonal to the normal. Where the coordinates are degenerate, any tangent that is orthogonal.
    pub fn compute_tangents(&mut self) {
        let uv = &self.uv0;
        let mut sums = vec![(Vec3::ZERO, Vec3::ZERO); self.positions.len()];
        for corners in &self.indices {
            let [a, b, c] = corners.map(|v| v as usize);
            let (e1, e2) = (self.positions[b] - self.positions[a], self.positions[c] - self.positions[a]);
            let (d1, d2) = (uv[b] - uv[a], uv[c] - uv[a]);
            // Without the division by the determinant the sum is weighted by the area in the texture; its sign stays.
            let sign = d1.perp_dot(d2).signum();
            let along_u = (e1 * d2.y - e2 * d1.y) * sign;
            let along_v = (e2 * d1.x - e1 * d2.x) * sign;
            for v in [a, b, c] {
                sums[v].0 += along_u;
                sums[v].1 += along_v;
            }
        }
        self.tangents = sums.iter().zip(&self.normals).map(|(&(u, v), &n)| tangent(n, u, v)).collect();
    }

    pub(crate) fn check(&self, materials: &[Material]) -> Result<(), String> {
        let vertices = self.positions.len();
        let lengths =
            [self.normals.len(), self.tangents.len(), self.uv0.len(), self.uv1.len(), self.colors.len()];
        if lengths.iter().any(|&n| n != vertices) {
            return Err(format!("attribute arrays differ in length: {vertices}, {lengths:?}"));
        }
        if self.triangle_materials.len() != self.indices.len() || self.first_masked > self.indices.len() {
            return Err("per-triangle arrays differ in length".into());
        }
        let listed = |empty, length| empty || length == vertices;
        let targets = self.deformation.as_ref().map_or(0, |d| d.weights.len());
        let joints = self.deformation.as_ref().map_or(0, |d| d.joints.len());
        if !listed(self.influences.is_empty(), self.influences.len())
            || !listed(self.morphs.is_empty(), self.morphs.len())
            || self.influences.items().iter().any(|i| i.joint as usize >= joints)
            || self.morphs.items().iter().any(|m| m.target as usize >= targets)
            || self.deformation.as_ref().is_some_and(|d| d.rest.positions.len() != vertices)
        {
            return Err("joints or morph targets do not fit its vertices".into());
        }
        for v in 0..vertices {
            let finite = self.positions[v].is_finite()
                && self.normals[v].is_finite()
                && self.tangents[v].is_finite()
                && self.uv0[v].is_finite()
                && self.uv1[v].is_finite()
                && self.colors[v].is_finite();
            if !finite {
                return Err(format!("vertex {v} is not finite"));
            }
            if (self.normals[v].length() - 1.0).abs() > 1e-2 {
                return Err(format!("normal {v} is not of unit length: {}", self.normals[v]));
            }
        }
        for (t, corners) in self.indices.iter().enumerate() {
            if corners.iter().any(|&v| v as usize >= vertices) {
                return Err(format!("triangle {t} names a vertex past {vertices}"));
            }
            let Some(material) = materials.get(self.triangle_materials[t] as usize) else {
                return Err(format!("triangle {t} names a material past {}", materials.len()));
            };
            if material.is_masked() != (t >= self.first_masked) {
                return Err(format!("triangle {t} is on the wrong side of first_masked"));
            }
        }
        Ok(())
    }
}

/// Unit normal of a triangle by two edges; +Y where it has no area. Squares of tiny and of huge numbers are avoided by powers of two,
/// which change no bit otherwise.
fn face_normal(e1: Vec3, e2: Vec3) -> Vec3 {
    let scaled = |v: Vec3| v / f32::from_bits(v.abs().max_element().to_bits() & 0x7f80_0000);
    scaled(scaled(e1).cross(scaled(e2))).normalize_or(Vec3::Y)
}

fn tangent(normal: Vec3, along_u: Vec3, along_v: Vec3) -> Vec4 {
    let projected = along_u - normal * normal.dot(along_u);
    match projected.try_normalize() {
        // Texture v runs down, the green channel of a normal map up: the bitangent points to smaller v.
        Some(t) => t.extend(if normal.cross(t).dot(along_v) > 0.0 { -1.0 } else { 1.0 }),
        None => normal.any_orthonormal_vector().extend(1.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn face_normals_of_every_size() {
        let (e1, e2) = (Vec3::new(0.3, 0.7, -0.2), Vec3::new(-0.5, 0.1, 0.9));
        let normal = e1.cross(e2).normalize();
        for size in [1e-30, 1e-15, 1.0, 1e6, 1e12] {
            assert!(face_normal(size * e1, size * e2).distance(normal) < 1e-6, "{size}");
        }
        // A sliver, and triangles without area.
        assert!(face_normal(Vec3::X, Vec3::new(1.0, 1e-25, 0.0)).abs_diff_eq(Vec3::Z, 1e-6));
        for e2 in [Vec3::ZERO, e1, -2.0 * e1] {
            assert_eq!(face_normal(e1, e2), Vec3::Y);
        }
    }
}
