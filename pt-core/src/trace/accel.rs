//! What a backend needs to find hits in a scene.

use super::vulkan_as::DriverStructures;
use super::{BvhQuality, InstancePlacement, MeshBvh, MeshGeometry, TopLevel, TraceBackend, TraceError, bvh};
use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::{Error, Result};
use crate::frame::{Frame, Pass};
use obvhs::aabb::Aabb;
use pt_shaders::records::{BvhNode, MeshRecord, SceneRecord};

/// The acceleration structure of a scene for one backend: meshes fixed, instances moving.
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
    top: TopLevel,
    top_nodes: Buffer,
    top_instances: Buffer,
}

struct MeshTree {
    bounds: Option<Aabb>,
    nodes: Buffer,
    triangles: Buffer,
}

impl AccelStructure {
    /// Builds the structures of `meshes` and takes memory for up to `instances` instances.
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
            TraceBackend::RayQuery | TraceBackend::RtPipeline => {
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
            Kind::Compute(trees) => trees.update(frame, placements),
            Kind::Driver(structures) => structures.update(frame, placements),
        }
    }

    /// Declares to a pass what its rays read.
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
        let meshes = meshes
            .iter()
            .map(|m| {
                let tree = MeshBvh::build(m.positions, m.indices, quality)?;
                Ok(MeshTree {
                    bounds: tree.bounds(),
                    nodes: Buffer::from_slice(device, "BVH nodes", &bvh::gpu_nodes(&tree.bvh))?,
                    triangles: Buffer::from_slice(device, "BVH triangles", &tree.triangles)?,
                })
            })
            .collect::<Result<_>>()?;
        // Inner nodes of a tree with single-entry leaves are fewer than its leaves; the root is there in any case.
        let nodes = (instances.max(1) * size_of::<BvhNode>()) as u64;
        Ok(Self {
            meshes,
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

    fn update(&mut self, frame: &mut Frame<'_>, placements: &[InstancePlacement]) -> Result<()> {
        // A lone instance is entered without a top level.
        if placements.len() == 1 {
            return Ok(());
        }
        self.top
            .rebuild(placements.iter().map(|p| (self.meshes[p.mesh as usize].bounds, p.world_from_object)));
        frame.upload(&self.top_nodes, bytemuck::cast_slice(&bvh::gpu_nodes(&self.top.bvh)))?;
        frame.upload(&self.top_instances, bytemuck::cast_slice(&self.top.bvh.primitive_indices))
    }
}
