//! The acceleration structures of a scene, for each backend.

use super::refit::Refit;
use super::vulkan_as::DriverStructures;
use super::{
    BvhQuality, InstancePlacement, Leaf, MeshBvh, MeshGeometry, MovedMesh, TopLevel, TraceBackend,
    TraceError, bvh,
};
use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::{Error, Result};
use crate::frame::{Frame, Pass};
use obvhs::aabb::Aabb;
use pt_shaders::records::{BvhNode, MeshRecord, SceneRecord};

/// The acceleration structure of a scene for one backend. Instances move, and so do the vertices of meshes that were declared as
/// deforming; the triangles themselves do not change.
pub struct AccelStructure {
    backend: TraceBackend,
    meshes: usize,
    capacity: usize,
    kind: Kind,
}

enum Kind {
    Compute(Box<Trees>),
    Driver(DriverStructures),
}

/// Trees of the compute backend.
struct Trees {
    meshes: Vec<MeshTree>,
    refit: Option<Refit>,
    top: TopLevel,
    top_nodes: Buffer,
    top_instances: Buffer,
}

struct MeshTree {
    bounds: Option<Aabb>,
    deforms: bool,
    nodes: Buffer,
    triangles: Buffer,
}

impl AccelStructure {
    /// Builds the structures of `meshes` and takes memory for up to `instances` instances. With one, there is no top level for the compute backend: its
    /// kernels are made without `FEATURE_INSTANCES`.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for `Auto` (see [`super::choose`]) and for a backend that the device lacks, [`Error::Trace`]
    /// for geometry that can't be built.
    pub fn new(
        device: &Device,
        meshes: &[MeshGeometry],
        instances: usize,
        backend: TraceBackend,
        quality: BvhQuality,
    ) -> Result<Self> {
        backend.check(device)?;
        let kind = match backend {
            TraceBackend::Auto => {
                return Err(Error::Unsupported(
                    "an acceleration structure needs a definite backend, not auto".into(),
                ));
            }
            TraceBackend::Compute => Kind::Compute(Box::new(Trees::new(device, meshes, instances, quality)?)),
            TraceBackend::RayQuery | TraceBackend::RtPipeline | TraceBackend::RtReorder => {
                for mesh in meshes {
                    super::check_indices(mesh.positions, mesh.indices)?;
                }
                Kind::Driver(DriverStructures::new(device, meshes, instances)?)
            }
        };
        Ok(Self { backend, meshes: meshes.len(), capacity: instances, kind })
    }

    /// The backend that it serves.
    pub fn backend(&self) -> TraceBackend {
        self.backend
    }

    /// Sets the addresses of mesh `index` that the backend's traversal reads.
    pub fn fill_mesh(&self, index: usize, record: &mut MeshRecord) {
        if let Kind::Compute(trees) = &self.kind {
            record.bvh_nodes = trees.meshes[index].nodes.address();
            record.bvh_triangles = trees.meshes[index].triangles.address();
        }
    }

    /// Sets the addresses of the top level that the backend's traversal reads.
    pub fn fill_scene(&self, record: &mut SceneRecord) {
        match &self.kind {
            Kind::Compute(trees) => {
                record.tlas_nodes = trees.top_nodes.address();
                record.tlas_instances = trees.top_instances.address();
            }
            Kind::Driver(structures) => record.tlas = structures.address(),
        }
    }

    /// Moves the instances for the passes that follow in this and later frames. Takes no memory.
    ///
    /// # Errors
    /// [`Error::Trace`] for more instances than announced, or one of an unknown mesh.
    pub fn update(&mut self, frame: &mut Frame<'_>, placements: &[InstancePlacement]) -> Result<()> {
        super::check_instances(placements, self.meshes)?;
        if placements.len() > self.capacity {
            let (instances, capacity) = (placements.len(), self.capacity);
            return Err(TraceError::Capacity { instances, capacity }.into());
        }
        match &mut self.kind {
            Kind::Compute(_) if self.capacity == 1 => Ok(()),
            Kind::Compute(trees) => trees.update(frame, placements),
            Kind::Driver(structures) => structures.update(frame, placements),
        }
    }

    /// Fits the structures of all deforming meshes to new vertices, for the passes that follow in this and later frames;
    /// [`Self::update`] comes next. Takes no memory.
    ///
    /// `moved` lists every mesh that deforms, `meshes` is the `MeshRecord` table that holds the same addresses on the
    /// device, `geometry` are the buffers of positions and indices.
    ///
    /// # Errors
    /// When the passes can't be recorded.
    pub fn refit(
        &mut self,
        frame: &mut Frame<'_>,
        moved: &[MovedMesh],
        meshes: &Buffer,
        geometry: &[&Buffer],
    ) -> Result<()> {
        match &mut self.kind {
            Kind::Compute(trees) => trees.refit(frame, moved, meshes, geometry),
            Kind::Driver(structures) => structures.refit(frame, moved, geometry),
        }
    }

    /// Declares to a pass the resources that its rays read.
    pub fn bind<'f, 'r>(&self, pass: Pass<'f, 'r>) -> Pass<'f, 'r> {
        match &self.kind {
            Kind::Compute(trees) => {
                let meshes = trees.meshes.iter().flat_map(|m| [&m.nodes, &m.triangles]);
                meshes.chain([&trees.top_nodes, &trees.top_instances]).fold(pass, |pass, b| pass.addresses(b))
            }
            Kind::Driver(structures) => structures.buffers().fold(pass, |pass, b| pass.traces(b)),
        }
    }
}

impl Trees {
    fn new(device: &Device, meshes: &[MeshGeometry], instances: usize, quality: BvhQuality) -> Result<Self> {
        let mut deforming = Vec::new();
        let meshes = meshes
            .iter()
            .zip(0..)
            .map(|(m, index)| {
                let tree = MeshBvh::build(m.positions, m.indices, quality, Leaf::of(device))?;
                if m.deforms {
                    deforming.push((index, tree.bvh.clone()));
                }
                Ok(MeshTree {
                    bounds: tree.bounds(),
                    deforms: m.deforms,
                    nodes: Buffer::from_slice(device, "BVH nodes", &bvh::gpu_nodes(&tree.bvh))?,
                    triangles: Buffer::from_slice(device, "BVH triangles", &tree.triangles)?,
                })
            })
            .collect::<Result<_>>()?;
        let refit = Refit::new(device, deforming.iter().map(|(index, tree)| (*index, tree)))?;
        // Inner nodes of a tree with single-entry leaves are fewer than its leaves; the root is there in any case.
        let nodes = (instances.max(1) * size_of::<BvhNode>()) as u64;
        Ok(Self {
            meshes,
            refit,
            top: TopLevel::default(),
            top_nodes: Buffer::new(device, "top-level BVH nodes", nodes, Location::Device)?,
            top_instances: Buffer::new(
                device,
                "top-level BVH instances",
                instances as u64 * 4,
                Location::Device,
            )?,
        })
    }

    fn refit(
        &mut self,
        frame: &mut Frame<'_>,
        moved: &[MovedMesh],
        meshes: &Buffer,
        geometry: &[&Buffer],
    ) -> Result<()> {
        for m in moved {
            let tree = &mut self.meshes[m.mesh as usize];
            tree.bounds = tree.bounds.map(|_| Aabb::new(m.bounds.0.into(), m.bounds.1.into()));
        }
        let Some(refit) = &self.refit else { return Ok(()) };
        let deforming = self.meshes.iter().filter(|m| m.deforms).flat_map(|m| [&m.nodes, &m.triangles]);
        refit.record(frame, meshes, geometry, deforming)
    }

    fn update(&mut self, frame: &mut Frame<'_>, placements: &[InstancePlacement]) -> Result<()> {
        self.top
            .rebuild(placements.iter().map(|p| (self.meshes[p.mesh as usize].bounds, p.world_from_object)))?;
        frame.upload(&self.top_nodes, bytemuck::cast_slice(&bvh::gpu_nodes(&self.top.bvh)))?;
        frame.upload(&self.top_instances, bytemuck::cast_slice(&self.top.bvh.primitive_indices))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Recorder;
    use crate::rng::random4;
    use crate::test_support::TestDevice;
    use glam::{UVec3, Vec3};
    use pt_shaders::records::BvhTriangle;

    /// Box of each child slot, decoded from the node's grid, and the size of the grid's steps.
    fn decode(words: &[u64; 10], slot: u32) -> (Vec3, Vec3, Vec3) {
        let float = |bits: u64| f32::from_bits(bits as u32);
        let origin = Vec3::new(float(words[0]), float(words[0] >> 32), float(words[1]));
        let byte = |word: usize, slot: u32| (words[word] >> (8 * slot)) as u8;
        let step = |axis: u32| f32::from_bits(u32::from(byte(1, 4 + axis)) << 23);
        let step = Vec3::new(step(0), step(1), step(2));
        let plane = |offset: usize| Vec3::from_array([3, 5, 7].map(|w| f32::from(byte(w + offset, slot))));
        (origin + step * plane(0), origin + step * plane(1), step)
    }

    /// Checks the boxes below a node against its triangles, `size` a leaf, and returns the bounds of these.
    fn check(
        nodes: &[BvhNode],
        triangles: &[BvhTriangle],
        size: usize,
        corners: &[[Vec3; 3]],
        node: usize,
    ) -> (Vec3, Vec3) {
        let words = &nodes[node].words;
        let (inner, leaf) = ((words[1] >> 56) as u8, (words[2] >> 28 & 0xf | words[2] >> 60 << 4) as u8);
        let base = [words[2] as usize & 0xfff_ffff, (words[2] >> 32) as usize & 0xfff_ffff];
        let mut all = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for slot in (0..8).filter(|slot| (inner | leaf) >> slot & 1 == 1) {
            let before = |set: u8| (set & ((1u8 << slot) - 1)).count_ones() as usize;
            let (low, high) = if leaf >> slot & 1 == 1 {
                let of_leaf = &triangles[(base[1] + before(leaf)) * size..][..size];
                of_leaf.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), t| {
                    let [a, b, c] = corners[t.triangle as usize];
                    assert_eq!([t.v0, t.e1, t.e2], [a, b - a, c - a], "triangle {}", t.triangle);
                    (low.min(a.min(b).min(c)), high.max(a.max(b).max(c)))
                })
            } else {
                check(nodes, triangles, size, corners, base[0] + before(inner))
            };
            let (box_low, box_high, step) = decode(words, slot);
            // The traversal widens boxes by more than that.
            let slack = step * 1e-4;
            assert!(
                box_low.cmple(low + slack).all() && box_high.cmpge(high - slack).all(),
                "node {node} is too small"
            );
            let loose = step * 1.001;
            assert!(
                box_low.cmpge(low - loose).all() && box_high.cmple(high + loose).all(),
                "node {node} is too large"
            );
            all = (all.0.min(low), all.1.max(high));
        }
        all
    }

    #[test]
    fn refitted_boxes_hold_their_triangles_closely() {
        let device = TestDevice::open();
        for leaf in [Leaf::Triangle, Leaf::Pair] {
            refitted_boxes_hold(&device.with_gpu_traversal(leaf == Leaf::Pair), leaf);
        }
    }

    fn refitted_boxes_hold(device: &Device, leaf: Leaf) {
        let random = |i: u32| Vec3::from_slice(&random4([i, 0], 0, 0, 0)[..3]);
        // One triangle has no extent along y, one none at all; the others share an edge in twos.
        let pair =
            |t: u32| [UVec3::new(4 * t, 4 * t + 1, 4 * t + 2), UVec3::new(4 * t + 2, 4 * t + 1, 4 * t + 3)];
        let indices: Vec<_> =
            [UVec3::new(0, 1, 2), UVec3::splat(3)].into_iter().chain((1..1000).flat_map(pair)).collect();
        let at = |twist: f32| -> Vec<Vec3> {
            let vertex = |i: u32| {
                let p = 10.0 * random(i / 4) + random(i);
                let p = glam::Quat::from_rotation_y(twist * p.y) * p + Vec3::X * 100.0 * twist;
                if i < 3 { p.with_y(2.0) } else { p }
            };
            (0..4000).map(vertex).collect()
        };
        let rest = at(0.0);
        let mesh = MeshGeometry { positions: &rest, indices: &indices, first_masked: 2000, deforms: true };
        let mut accel =
            AccelStructure::new(device, &[mesh], 1, TraceBackend::Compute, BvhQuality::Medium).unwrap();
        let moved = at(0.4);
        let positions = Buffer::from_slice(device, "positions", &moved).unwrap();
        let index_buffer = Buffer::from_slice(device, "indices", &indices).unwrap();
        let mut record = MeshRecord {
            positions: positions.address(),
            indices: index_buffer.address(),
            ..bytemuck::Zeroable::zeroed()
        };
        accel.fill_mesh(0, &mut record);
        let table = Buffer::from_slice(device, "meshes", &[record]).unwrap();
        let mut recorder = Recorder::new(device).unwrap();
        let mut frame = recorder.begin().unwrap();
        let work = MovedMesh {
            mesh: 0,
            positions: positions.address(),
            indices: index_buffer.address(),
            bounds: (Vec3::ZERO, Vec3::ONE),
        };
        accel.refit(&mut frame, &[work], &table, &[&positions, &index_buffer]).unwrap();
        frame.submit().unwrap();
        recorder.finish().unwrap();
        let Kind::Compute(trees) = &accel.kind else { panic!("another backend") };
        let nodes: Vec<BvhNode> = trees.meshes[0].nodes.read().unwrap();
        let triangles: Vec<BvhTriangle> = trees.meshes[0].triangles.read().unwrap();
        let corners: Vec<_> = indices.iter().map(|i| i.to_array().map(|v| moved[v as usize])).collect();
        let size = leaf.triangles() as usize;
        assert!(triangles.len() < 1900 * size || leaf == Leaf::Triangle, "too few have a partner");
        let (low, high) = check(&nodes, &triangles, size, &corners, 0);
        assert_eq!(low, moved.iter().copied().reduce(Vec3::min).unwrap());
        assert_eq!(high, moved.iter().copied().reduce(Vec3::max).unwrap());
    }
}
