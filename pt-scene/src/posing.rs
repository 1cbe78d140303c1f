//! Meshes in their current pose, on the CPU.

use glam::{Affine3A, Mat3A, Vec3, Vec3A};
use std::sync::Arc;

use crate::animation::{Deformation, DeformedVertices, Influence, MorphDelta, Skin, VertexLists};
use crate::{Bounds, Mesh};

impl Deformation {
    /// Of a mesh that is at rest, hung on `node` of a rig.
    pub fn new(mesh: &Mesh, node: u32, skin: Option<Arc<Skin>>, weights: &[f32]) -> Self {
        let joints = skin.as_ref().map_or(0, |s| s.joints.len());
        let mut boxes = vec![None; joints.max(1)];
        let mut grow = |b: usize, p: Vec3| {
            if let Some(bounds) = boxes.get_mut(b) {
                *bounds = Some(bounds.map_or(Bounds { min: p, max: p }, |old: Bounds| include(old, p)));
            }
        };
        let mut reach = vec![Bounds { min: Vec3::ZERO, max: Vec3::ZERO }; weights.len()];
        for (v, &p) in mesh.positions.iter().enumerate() {
            if skin.is_none() {
                grow(0, p);
            }
            mesh.influences.get(v).iter().for_each(|i| grow(i.joint as usize, p));
            for delta in mesh.morphs.get(v) {
                if let Some(bounds) = reach.get_mut(delta.target as usize) {
                    *bounds = include(*bounds, delta.position);
                }
            }
        }
        Self {
            rest: DeformedVertices {
                positions: mesh.positions.clone(),
                normals: mesh.normals.clone(),
                tangents: mesh.tangents.clone(),
            },
            node,
            skin,
            joints: vec![Affine3A::IDENTITY; joints],
            weights: weights.to_vec(),
            boxes,
            reach,
        }
    }
}

fn include(bounds: Bounds, point: Vec3) -> Bounds {
    Bounds { min: bounds.min.min(point), max: bounds.max.max(point) }
}

impl Mesh {
    /// The vertices in the present pose; `None` for a rigid mesh. The mesh itself keeps the pose that it was last given by
    /// [`crate::Scene::pose_meshes`].
    pub fn deformed(&self) -> Option<DeformedVertices> {
        let deformation = self.deformation.as_ref()?;
        let rest = &deformation.rest;
        let mut out = rest.clone();
        for v in 0..rest.positions.len() {
            let (mut position, mut normal) = (rest.positions[v], rest.normals[v]);
            let mut tangent = rest.tangents[v].truncate();
            for delta in self.morphs.get(v) {
                let weight = deformation.weights[delta.target as usize];
                position += weight * delta.position;
                normal += weight * delta.normal;
                tangent += weight * delta.tangent;
            }
            let influences = self.influences.get(v);
            if !influences.is_empty() {
                let m = blend(influences, &deformation.joints);
                position = m.transform_point3(position);
                normal = (cofactors(&m.matrix3) * Vec3A::from(normal)).into();
                tangent = m.transform_vector3(tangent);
            }
            out.positions[v] = position;
            out.normals[v] = normal.try_normalize().unwrap_or(rest.normals[v]);
            let tangent = tangent.try_normalize().unwrap_or(rest.tangents[v].truncate());
            out.tangents[v] = tangent.extend(rest.tangents[v].w);
        }
        Some(out)
    }

    /// Shows the mesh in its present pose: what reads vertices on the CPU sees it so.
    pub fn pose(&mut self) {
        if let Some(DeformedVertices { positions, normals, tangents }) = self.deformed() {
            (self.positions, self.normals, self.tangents) = (positions, normals, tangents);
        }
    }

    /// Differences of the flat normals that the morph targets of a flat-shaded mesh give its triangles (glTF 2.0, section 3.7.2.2).
    pub fn flat_morphs(&mut self) {
        let mut lists = VertexLists::default();
        for (t, corners) in self.indices.iter().enumerate() {
            let corners = corners.map(|v| v as usize);
            let mut targets: Vec<u32> =
                corners.iter().flat_map(|&v| self.morphs.get(v)).map(|delta| delta.target).collect();
            targets.sort_unstable();
            targets.dedup();
            let delta = |v: usize, target: u32| {
                let none =
                    MorphDelta { target, position: Vec3::ZERO, normal: Vec3::ZERO, tangent: Vec3::ZERO };
                self.morphs.get(v).iter().find(|d| d.target == target).copied().unwrap_or(none)
            };
            let normals: Vec<Vec3> = targets
                .iter()
                .map(|&target| {
                    let [a, b, c] = corners.map(|v| self.positions[v] + delta(v, target).position);
                    let flat = self.normals[corners[0]];
                    (b - a).cross(c - a).normalize_or(flat) - flat
                })
                .collect();
            debug_assert_eq!(corners, [3 * t, 3 * t + 1, 3 * t + 2]);
            for v in corners {
                lists.push(targets.iter().zip(&normals).map(|(&target, &normal)| MorphDelta {
                    normal,
                    tangent: Vec3::ZERO,
                    ..delta(v, target)
                }));
            }
        }
        self.morphs = lists;
    }
}

fn blend(influences: &[Influence], joints: &[Affine3A]) -> Affine3A {
    let zero = Affine3A { matrix3: Mat3A::ZERO, translation: Vec3A::ZERO };
    influences.iter().fold(zero, |sum, i| {
        let m = joints[i.joint as usize];
        Affine3A {
            matrix3: sum.matrix3 + m.matrix3 * i.weight,
            translation: sum.translation + m.translation * i.weight,
        }
    })
}

/// The inverse transpose but for a positive factor: takes normals along, whatever the scale. A matrix that mirrors keeps them on their
/// side, as an instance's does.
fn cofactors(m: &Mat3A) -> Mat3A {
    let c = Mat3A::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
    if c.x_axis.dot(m.x_axis) < 0.0 { c * -1.0 } else { c }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;
    use glam::Vec4;

    /// Four vertices along +X; the first two belong to joint 0, the last to joint 1, the third to both.
    fn mesh() -> Mesh {
        let mut mesh = Mesh {
            positions: (0..4).map(|i| Vec3::X * i as f32).collect(),
            normals: vec![Vec3::Y; 4],
            tangents: vec![Vec4::new(1.0, 0.0, 0.0, -1.0); 4],
            ..Mesh::default()
        };
        let one = |joint| Influence { joint, weight: 1.0 };
        let half = |joint| Influence { joint, weight: 0.5 };
        mesh.influences.push([one(0)]);
        mesh.influences.push([one(0)]);
        mesh.influences.push([half(0), half(1)]);
        mesh.influences.push([one(1)]);
        for v in 0..4 {
            let up = MorphDelta { target: 1, position: Vec3::Y, normal: Vec3::X, tangent: Vec3::ZERO };
            mesh.morphs.push((v == 3).then_some(up));
        }
        mesh
    }

    fn posed(joints: [Affine3A; 2], weights: [f32; 2]) -> (Mesh, DeformedVertices) {
        let mut mesh = mesh();
        let skin = Skin { joints: vec![0, 1], inverse_bind: vec![Affine3A::IDENTITY; 2] };
        let mut deformation = Deformation::new(&mesh, 0, Some(Arc::new(skin)), &[0.0, 0.0]);
        deformation.joints = joints.to_vec();
        deformation.weights = weights.to_vec();
        mesh.deformation = Some(Box::new(deformation));
        let vertices = mesh.deformed().unwrap();
        (mesh, vertices)
    }

    #[test]
    fn targets_come_before_joints() {
        let turn = Affine3A::from_quat(Quat::from_rotation_z(std::f32::consts::FRAC_PI_2));
        let (_, v) = posed([Affine3A::IDENTITY, turn], [0.0, 2.0]);
        // (3, 0, 0) is lifted to (3, 2, 0) and turned to (-2, 3, 0); the third vertex is half way between (2, 0, 0) and (0, 2, 0).
        assert!(v.positions[3].abs_diff_eq(Vec3::new(-2.0, 3.0, 0.0), 1e-5));
        assert!(v.positions[2].abs_diff_eq(Vec3::new(1.0, 1.0, 0.0), 1e-5));
        assert_eq!(v.positions[1], Vec3::X);
        let lifted = Vec3::new(2.0, 1.0, 0.0).normalize();
        assert!(v.normals[3].abs_diff_eq(Vec3::new(-lifted.y, lifted.x, 0.0), 1e-5), "{}", v.normals[3]);
        assert!(v.tangents[3].abs_diff_eq(Vec4::new(0.0, 1.0, 0.0, -1.0), 1e-5));
    }

    #[test]
    fn normals_follow_uneven_and_mirroring_joints() {
        let squeeze = Affine3A::from_mat3(glam::Mat3::from_cols(Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Z));
        let (_, v) = posed([squeeze, squeeze], [0.0; 2]);
        // A shear along +X leaves the plane y = 0, and so its normal, where it is.
        assert!(v.normals[0].abs_diff_eq(Vec3::Y, 1e-6));
        let mirror = Affine3A::from_scale(Vec3::new(1.0, 1.0, -1.0));
        let (mesh, v) = posed([mirror, mirror], [0.0; 2]);
        assert!(v.normals[0].abs_diff_eq(Vec3::Y, 1e-6));
        assert!(mesh.deformation.unwrap().is_mirrored());
    }

    #[test]
    fn bounds_hold_every_vertex() {
        let far = Affine3A::from_scale_rotation_translation(
            Vec3::new(0.2, 3.0, 1.0),
            Quat::from_rotation_y(0.7),
            Vec3::new(1e4, 0.0, 5.0),
        );
        for weights in [[0.0, 0.0], [0.0, 1.5], [3.0, -2.0]] {
            let (mesh, v) = posed([Affine3A::IDENTITY, far], weights);
            let bounds = mesh.deformation.unwrap().bounds().unwrap();
            for p in v.positions {
                assert!(p.cmpge(bounds.min).all() && p.cmple(bounds.max).all(), "{p} outside {bounds:?}");
            }
        }
    }

    #[test]
    fn lists_are_joined_and_selected() {
        let mut lists = VertexLists::default();
        lists.append(&VertexLists::<u32>::default(), 3, 2);
        assert_eq!((lists.is_empty(), lists.len()), (true, 0));
        let mut other = VertexLists::default();
        other.push([1, 2]);
        other.push([]);
        other.push([3]);
        lists.append(&other, 2, 3);
        assert_eq!(
            (lists.len(), lists.get(2), lists.get(4), lists.get(9)),
            (5, &[1, 2][..], &[3][..], &[][..])
        );
        let selected = lists.select(&[4, 2, 4]);
        assert_eq!(selected.items(), [3, 1, 2, 3]);
        assert_eq!(selected.get(1), [1, 2]);
    }

    #[test]
    fn flat_normals_of_targets_are_differences() {
        let mut mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            normals: vec![Vec3::Z; 3],
            tangents: vec![Vec4::X; 3],
            indices: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        for v in 0..3 {
            let lift = MorphDelta {
                target: 0,
                position: Vec3::new(0.0, -1.0, 1.0),
                normal: Vec3::ZERO,
                tangent: Vec3::ZERO,
            };
            mesh.morphs.push((v == 2).then_some(lift));
        }
        mesh.flat_morphs();
        // The third vertex goes to (0, 0, 1): the triangle then faces -Y.
        for v in 0..3 {
            let [delta] = mesh.morphs.get(v) else { panic!("vertex {v} has no target") };
            assert!((Vec3::Z + delta.normal).abs_diff_eq(Vec3::NEG_Y, 1e-6));
        }
        assert_eq!(mesh.morphs.get(0)[0].position, Vec3::ZERO);
    }
}
