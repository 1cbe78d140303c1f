//! Tangents where a file has none: MikkTSpace (Mikkelsen 2008, "Simulation of Wrinkled Surfaces Revisited"), as glTF asks.

use std::collections::BTreeMap;

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec2, Vec3, Vec4};

use pt_scene::{Material, Mesh};

/// The set of texture coordinates that the material's tangents follow; `None` where nothing of it depends on tangents.
pub(crate) fn needed(material: &Material) -> Option<u32> {
    let lobes = material.lobes.as_deref();
    let anisotropy = lobes.filter(|l| l.anisotropy_strength > 0.0);
    material
        .normal_texture
        .or(lobes.and_then(|l| l.clearcoat_normal_texture))
        .or(anisotropy.and_then(|l| l.anisotropy_texture))
        .map(|texture| texture.uv_set)
        .or(anisotropy.map(|_| 0))
}

/// Fills the tangents. Along the texture's u where `uv_set` says which, with vertices split where triangles of one vertex
/// disagree; else any direction in the surface.
pub(crate) fn compute(mesh: &mut Mesh, uv_set: Option<u32>) {
    mesh.tangents = mesh.normals.iter().map(|n| n.any_orthonormal_vector().extend(1.0)).collect();
    let uv = match uv_set {
        Some(0) => &mesh.uv0,
        Some(_) => &mesh.uv1,
        None => return,
    };
    let mut corners = Corners { mesh, uv, tangents: vec![None; 3 * mesh.indices.len()] };
    let Ok(()) = generate_tangents(&mut corners) else { return };
    let tangents = corners.tangents;
    assign(mesh, &tangents);
}

struct Corners<'a> {
    mesh: &'a Mesh,
    uv: &'a [Vec2],
    /// Three for each triangle; `None` where the texture coordinates give no direction.
    tangents: Vec<Option<Vec4>>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.indices[face][corner] as usize
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.indices.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.positions[self.vertex(face, corner)].to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.normals[self.vertex(face, corner)].to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.uv[self.vertex(face, corner)].to_array()
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        let direction = space.and_then(|s| Vec3::from_array(s.tangent()).try_normalize().zip(Some(s)));
        // The algorithm has v up, glTF has it down.
        let tangent =
            direction.map(|(t, s)| t.extend(if s.is_orientation_preserving() { -1.0 } else { 1.0 }));
        self.tangents[3 * face + corner] = tangent;
    }
}

/// Gives every corner its tangent. A vertex keeps the first one; for each other one it is doubled.
fn assign(mesh: &mut Mesh, tangents: &[Option<Vec4>]) {
    let mut taken = vec![false; mesh.positions.len()];
    let mut copies = BTreeMap::new();
    let mut sources: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    let mut added = Vec::new();
    for (corner, tangent) in mesh.indices.iter_mut().flatten().zip(tangents) {
        let Some(tangent) = tangent else { continue };
        let v = *corner as usize;
        if !std::mem::replace(&mut taken[v], true) {
            mesh.tangents[v] = *tangent;
        } else if mesh.tangents[v] != *tangent {
            let bits = tangent.to_array().map(f32::to_bits);
            *corner = *copies.entry((v, bits)).or_insert_with(|| {
                sources.push(v as u32);
                added.push(*tangent);
                sources.len() as u32 - 1
            });
        }
    }
    if !added.is_empty() {
        let kept = mesh.tangents.len();
        mesh.gather(&sources);
        mesh.tangents.splice(kept.., added);
    }
}
