//! Vertices that move on their own: morph targets, then linear blend skinning (glTF 2.0, sections 3.7.2.2 and 3.7.3).
//! The CPU twin of `deform.comp`.

use glam::{Affine3A, Vec3, Vec3A, Vec4};
use std::sync::Arc;

use super::Pose;
use crate::Bounds;

/// A list of items for each vertex.
#[derive(Clone, Debug, PartialEq)]
pub struct VertexLists<T> {
    /// Where the items of each vertex start; one more than there are vertices.
    first: Vec<u32>,
    items: Vec<T>,
}

impl<T> Default for VertexLists<T> {
    fn default() -> Self {
        Self { first: vec![0], items: Vec::new() }
    }
}

impl<T: Copy> VertexLists<T> {
    /// Number of vertices that have lists.
    pub fn len(&self) -> usize {
        self.first.len() - 1
    }

    /// Whether no vertex has any item.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    /// The items of a vertex; none of one past the end.
    pub fn get(&self, vertex: usize) -> &[T] {
        match (self.first.get(vertex), self.first.get(vertex + 1)) {
            (Some(&first), Some(&end)) => &self.items[first as usize..end as usize],
            _ => &[],
        }
    }

    /// All items, vertex by vertex.
    pub fn items(&self) -> &[T] {
        &self.items
    }

    /// Adds the list of the next vertex.
    pub fn push(&mut self, items: impl IntoIterator<Item = T>) {
        self.items.extend(items);
        self.first.push(self.items.len() as u32);
    }

    /// Lists for every corner's vertex, in the order of the corners.
    pub fn select(&self, corners: &[u32]) -> Self {
        let mut lists = Self::default();
        corners.iter().for_each(|&v| lists.push(self.get(v as usize).iter().copied()));
        lists
    }

    /// Adds another mesh's lists behind those of `before` vertices; `after` are the vertices of the other mesh.
    pub fn append(&mut self, other: &Self, before: usize, after: usize) {
        if self.is_empty() && other.is_empty() {
            return;
        }
        while self.len() < before {
            self.push([]);
        }
        (0..after).for_each(|v| self.push(other.get(v).iter().copied()));
    }
}

/// A joint that moves a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Influence {
    /// Index into the joints of the skin.
    pub joint: u32,
    /// Share, above 0; all of a vertex sum up to 1.
    pub weight: f32,
}

/// What a morph target of weight 1 adds to a vertex. Those of a vertex stand in the order of the targets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MorphDelta {
    /// Index of the target.
    pub target: u32,
    /// Added to the position, metres.
    pub position: Vec3,
    /// Added to the normal.
    pub normal: Vec3,
    /// Added to the tangent's direction.
    pub tangent: Vec3,
}

/// The joints of skinned meshes.
#[derive(Clone, Debug, PartialEq)]
pub struct Skin {
    /// Nodes of the rig.
    pub joints: Vec<u32>,
    /// From the space of the mesh to that of each joint.
    pub inverse_bind: Vec<Affine3A>,
}

/// How a mesh deforms: its vertices at rest, and the pose that it takes now.
#[derive(Clone, Debug, PartialEq)]
pub struct Deformation {
    /// Vertices at rest, object space.
    pub rest: DeformedVertices,
    /// Node of the rig that carries the mesh; its morph weights apply.
    pub node: u32,
    /// Its joints; `None`: morph targets only.
    pub skin: Option<Arc<Skin>>,
    /// World-from-mesh transform of each joint now. A skinned mesh is so put into the world, its instances stand at the origin.
    pub joints: Vec<Affine3A>,
    /// Weights of the morph targets now.
    pub weights: Vec<f32>,
    /// Bounds at rest of the vertices that each joint moves; of all vertices where there are no joints.
    pub(crate) boxes: Vec<Option<Bounds>>,
    /// Bounds of the displacements of each target.
    pub(crate) reach: Vec<Bounds>,
}

/// The vertex data that deformation changes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DeformedVertices {
    /// Metres.
    pub positions: Vec<Vec3>,
    /// Unit normals.
    pub normals: Vec<Vec3>,
    /// Unit tangents with the bitangent's sign.
    pub tangents: Vec<Vec4>,
}

impl Deformation {
    /// Takes joints and weights from a pose of the rig.
    pub fn set_pose(&mut self, pose: &Pose) {
        if let Some(skin) = &self.skin {
            let joints = skin.joints.iter().zip(&skin.inverse_bind);
            self.joints.clear();
            self.joints
                .extend(joints.map(|(&joint, &inverse_bind)| pose.world[joint as usize] * inverse_bind));
        }
        if let Some(weights) = pose.weights.get(self.node as usize) {
            self.weights.clone_from(weights);
        }
    }

    /// Whether the pose turns the mesh inside out, as a mirroring instance does.
    pub fn is_mirrored(&self) -> bool {
        self.joints.first().is_some_and(|m| m.matrix3.determinant() < 0.0)
    }

    /// A box round all vertices in the present pose, in the space of the mesh's instances. Not the smallest: a vertex is a mean of
    /// where its joints would put it, so it lies in the bounds of these.
    pub fn bounds(&self) -> Option<Bounds> {
        let (mut low, mut high) = (Vec3::ZERO, Vec3::ZERO);
        for (reach, &weight) in self.reach.iter().zip(&self.weights) {
            let (a, b) = (reach.min * weight, reach.max * weight);
            low += a.min(b);
            high += a.max(b);
        }
        let still = [Affine3A::IDENTITY];
        let joints = if self.skin.is_some() { &self.joints[..] } else { &still };
        let boxes = self.boxes.iter().zip(joints).filter_map(|(bounds, m)| {
            let bounds = (*bounds)?;
            let (min, max) = (bounds.min + low, bounds.max + high);
            let (center, half) = (0.5 * (min + max), 0.5 * (max - min));
            let extent = m.matrix3.abs() * Vec3A::from(half);
            // Rounding grows with what is added up, not with the sum.
            let sum = m.matrix3.abs() * Vec3A::from(min.abs().max(max.abs())) + m.translation.abs();
            let extent = Vec3::from(extent + 4e-6 * sum.max_element());
            let center = m.transform_point3(center);
            Some(Bounds { min: center - extent, max: center + extent })
        });
        boxes.reduce(|a, b| Bounds { min: a.min.min(b.min), max: a.max.max(b.max) })
    }
}
