//! Deforming meshes on the device: one kernel moves all their vertices to the pose of the frame.

use super::deform_records::{DeformPush, DeformVertex, DeltaRecord, InfluenceRecord, JointRecord};
use super::{kernels, records};
use crate::{Mesh, Scene};
use glam::{Vec3, Vec4};
use pt_core::frame::Pass;
use pt_core::trace::MovedMesh;
use pt_core::{Buffer, Device, Frame, Kernel, Location, Result};
use pt_shaders::records::MeshRecord;

/// Threads per row of the launch: devices must support only 65,535 workgroups per row.
const ROW: u32 = 1 << 20;

/// Vertices of all meshes that deform, one behind the other. Positions are kept twice, of this frame and of the last one that moved
/// them: what was current is previous in the next frame, to the bit.
pub(super) struct DeformingMeshes {
    kernel: Kernel,
    /// Indices of the meshes, and the first vertex of each.
    meshes: Vec<(usize, u64)>,
    /// Vertices at rest, displacements, joints of vertices: fixed.
    rest: [Buffer; 3],
    joint_buffer: Buffer,
    weight_buffer: Buffer,
    positions: [Buffer; 2],
    records: Buffer,
    count: u32,
    /// Which of `positions` is of this frame.
    current: usize,
    /// The pose that they are in; without one until the first frame.
    joints: Vec<JointRecord>,
    weights: Vec<f32>,
    posed: bool,
    /// Whether this frame's positions are others than the last one's.
    moved: bool,
    moved_meshes: Vec<MovedMesh>,
}

/// What [`DeformingMeshes::update`] found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Change {
    /// Nothing.
    None,
    /// The vertices rest since the last frame.
    Settled,
    /// The vertices are elsewhere.
    Moved,
}

impl DeformingMeshes {
    /// Uploads what the kernel reads; `None` when no mesh deforms.
    pub(super) fn new(device: &Device, scene: &Scene) -> Result<Option<Self>> {
        let (mut vertices, mut deltas, mut influences) = (Vec::new(), Vec::new(), Vec::new());
        let (mut joint_count, mut weight_count) = (0, 0);
        let (mut meshes, mut positions, mut vertex_records) = (Vec::new(), Vec::new(), Vec::new());
        for (index, mesh) in scene.meshes.iter().enumerate() {
            let Some(deformation) = &mesh.deformation else { continue };
            meshes.push((index, positions.len() as u64));
            positions.extend_from_slice(&mesh.positions);
            vertex_records.extend(records::vertices(mesh));
            let rest = &deformation.rest;
            for v in 0..rest.positions.len() {
                vertices.push(DeformVertex {
                    position: rest.positions[v],
                    first_delta: deltas.len() as u32,
                    normal: rest.normals[v],
                    first_influence: influences.len() as u32,
                    tangent: rest.tangents[v],
                });
                deltas.extend(mesh.morphs.get(v).iter().map(|d| DeltaRecord {
                    target: weight_count + d.target,
                    position: d.position,
                    normal: d.normal,
                    tangent: d.tangent,
                }));
                influences.extend(
                    mesh.influences
                        .get(v)
                        .iter()
                        .map(|i| InfluenceRecord { joint: joint_count + i.joint, weight: i.weight }),
                );
            }
            joint_count += deformation.joints.len() as u32;
            weight_count += deformation.weights.len() as u32;
        }
        if meshes.is_empty() {
            return Ok(None);
        }
        vertices.push(DeformVertex {
            first_delta: deltas.len() as u32,
            first_influence: influences.len() as u32,
            ..bytemuck::Zeroable::zeroed()
        });
        let joint_bytes = u64::from(joint_count) * size_of::<JointRecord>() as u64;
        Ok(Some(Self {
            kernel: Kernel::compute::<DeformPush>(device, &kernels::DEFORM, &[])?,
            rest: [
                Buffer::from_slice(device, "vertices at rest", &vertices)?,
                Buffer::from_slice(device, "morph targets", &deltas)?,
                Buffer::from_slice(device, "joints of vertices", &influences)?,
            ],
            joint_buffer: Buffer::new(device, "joints", joint_bytes, Location::Device)?,
            weight_buffer: Buffer::new(
                device,
                "morph weights",
                u64::from(weight_count) * 4,
                Location::Device,
            )?,
            positions: [
                Buffer::from_slice(device, "deformed positions", &positions)?,
                Buffer::from_slice(device, "deformed positions", &positions)?,
            ],
            records: Buffer::from_slice(device, "deformed vertices", &vertex_records)?,
            count: positions.len() as u32,
            meshes,
            current: 0,
            joints: Vec::new(),
            weights: Vec::new(),
            posed: false,
            moved: false,
            moved_meshes: Vec::new(),
        }))
    }

    /// Sets the addresses of the vertices of all deforming meshes, now and in the last frame.
    pub(super) fn fill(&self, records: &mut [MeshRecord]) {
        let previous = if self.moved { 1 - self.current } else { self.current };
        for &(mesh, first) in &self.meshes {
            let offset = first * size_of::<Vec3>() as u64;
            records[mesh].positions = self.positions[self.current].address() + offset;
            records[mesh].positions_prev = self.positions[previous].address() + offset;
            records[mesh].vertices =
                self.records.address() + first * size_of::<pt_shaders::records::VertexRecord>() as u64;
        }
    }

    /// Takes the scene's pose; records the kernel when it is another than in the last frame.
    pub(super) fn update(&mut self, frame: &mut Frame<'_>, scene: &Scene) -> Result<Change> {
        let joints = poses(scene).flat_map(|d| &d.joints).map(joint_record);
        let weights = poses(scene).flat_map(|d| &d.weights).copied();
        let same = joints.clone().eq(self.joints.iter().copied())
            && weights.clone().eq(self.weights.iter().copied());
        if self.posed && same {
            return Ok(if std::mem::replace(&mut self.moved, false) {
                Change::Settled
            } else {
                Change::None
            });
        }
        self.joints.clear();
        self.joints.extend(joints);
        self.weights.clear();
        self.weights.extend(weights);
        // In the first frame nothing was anywhere else before.
        self.moved = std::mem::replace(&mut self.posed, true);
        if self.moved {
            self.current = 1 - self.current;
        }
        frame.upload(&self.joint_buffer, bytemuck::cast_slice(&self.joints))?;
        frame.upload(&self.weight_buffer, bytemuck::cast_slice(&self.weights))?;
        let positions = &self.positions[self.current];
        let push = DeformPush {
            vertices: self.rest[0].address(),
            deltas: self.rest[1].address(),
            influences: self.rest[2].address(),
            joints: self.joint_buffer.address(),
            weights: self.weight_buffer.address(),
            positions: positions.address(),
            records: self.records.address(),
            count: self.count,
            width: self.count.min(ROW),
        };
        let read = self.rest.iter().chain([&self.joint_buffer, &self.weight_buffer]);
        let pass = read.fold(frame.pass("deform", &self.kernel), |pass, buffer| pass.addresses(buffer));
        pass.addresses_written(positions).addresses_written(&self.records).push(&push).dispatch([
            push.width,
            self.count.div_ceil(push.width.max(1)),
            1,
        ])?;
        Ok(Change::Moved)
    }

    /// The meshes with their new addresses and bounds, for the acceleration structures.
    pub(super) fn moved(&mut self, scene: &Scene, records: &[MeshRecord]) -> &[MovedMesh] {
        self.moved_meshes.clear();
        for &(mesh, _) in &self.meshes {
            let bounds = scene.meshes[mesh].deformation.as_ref().and_then(|d| d.bounds());
            let bounds = bounds.map_or((Vec3::ZERO, Vec3::ZERO), |b| (b.min, b.max));
            let MeshRecord { positions, indices, .. } = records[mesh];
            self.moved_meshes.push(MovedMesh { mesh: mesh as u32, positions, indices, bounds });
        }
        &self.moved_meshes
    }

    /// This frame's positions.
    pub(super) fn positions(&self) -> &Buffer {
        &self.positions[self.current]
    }

    /// Positions of a mesh in this frame and in the last one, where its record says that they are; `None` for a rigid mesh. Waits.
    pub(super) fn read(
        &self,
        mesh: usize,
        record: &MeshRecord,
        vertices: usize,
    ) -> Option<Result<[Vec<Vec3>; 2]>> {
        let (_, first) = *self.meshes.iter().find(|(m, _)| *m == mesh)?;
        let in_first = |at: u64| at == self.positions[0].address() + first * size_of::<Vec3>() as u64;
        let part = |all: Vec<Vec3>| all[first as usize..first as usize + vertices].to_vec();
        let read = |at: u64| self.positions[usize::from(!in_first(at))].read().map(part);
        Some(read(record.positions).and_then(|now| Ok([now, read(record.positions_prev)?])))
    }

    /// Declares to a pass what it reads of the vertices.
    pub(super) fn bind<'f, 'r>(&self, pass: Pass<'f, 'r>) -> Pass<'f, 'r> {
        self.positions.iter().chain([&self.records]).fold(pass, |pass, buffer| pass.addresses(buffer))
    }
}

fn poses(scene: &Scene) -> impl Iterator<Item = &crate::animation::Deformation> + Clone {
    scene.meshes.iter().filter_map(|mesh: &Mesh| mesh.deformation.as_deref())
}

fn joint_record(joint: &glam::Affine3A) -> JointRecord {
    let (m, t) = (joint.matrix3.transpose(), joint.translation);
    let rows: [Vec4; 3] = [m.x_axis.extend(t.x), m.y_axis.extend(t.y), m.z_axis.extend(t.z)];
    JointRecord { rows }
}
