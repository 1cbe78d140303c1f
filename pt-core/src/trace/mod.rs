//! Four backends trace rays behind one GLSL interface (`trace.glsl`); [`TraceBackend`] selects one.
//!
//! * compute: our two-level wide BVH traversed in GLSL, on every device;
//! * ray-query: `VK_KHR_ray_query` in compute kernels;
//! * rt-pipeline: `VK_KHR_ray_tracing_pipeline`;
//! * rt-reorder: the same with `VK_NV_ray_tracing_invocation_reorder`.
//!
//! All backends find the same hit: instance, triangle of its mesh, and barycentrics and t computed by one GLSL function.

mod accel;
pub mod bench;
mod bench_rays;
pub mod bvh;
mod leaves;
pub mod native;
mod push;
pub mod ray_list;
mod refit;
mod variant;
mod vulkan_as;

pub use crate::backend::TraceBackend;
pub use accel::AccelStructure;
pub use bench::{CLEARLY_FASTER, Choice, choose};
pub use bench_rays::{NativeRays, RayKind};
pub use bvh::{BvhQuality, MeshBvh, TopLevel};
pub use leaves::Leaf;
pub use native::NativeScene;
pub use variant::TraceVariant;

pub use crate::error::TraceError;
use glam::{Affine3A, UVec3, Vec3};

/// Triangles of one mesh, object space, metres.
#[derive(Clone, Copy, Debug)]
pub struct MeshGeometry<'a> {
    /// Vertex positions.
    pub positions: &'a [Vec3],
    /// Vertices of each triangle.
    pub indices: &'a [UVec3],
    /// Triangles from here on get the alpha test; the number of triangles when none does.
    pub first_masked: u32,
    /// Whether its vertices will move ([`AccelStructure::refit`]).
    pub deforms: bool,
}

/// New vertices of a mesh that deforms.
#[derive(Clone, Copy, Debug)]
pub struct MovedMesh {
    /// Index of the mesh.
    pub mesh: u32,
    /// Device address of its positions.
    pub positions: u64,
    /// Device address of its indices.
    pub indices: u64,
    /// Smallest and largest corner of a box, object space, that holds all its positions.
    pub bounds: (Vec3, Vec3),
}

/// A mesh placed in the world.
#[derive(Clone, Copy, Debug)]
pub struct InstancePlacement {
    /// Index of the mesh.
    pub mesh: u32,
    /// Visibility mask, 8 bits: a ray sees the instance when `ray mask & mask != 0`.
    pub mask: u32,
    /// Invertible.
    pub world_from_object: Affine3A,
}

fn check_indices(positions: &[Vec3], indices: &[UVec3]) -> Result<(), TraceError> {
    let vertices = positions.len();
    let outside = indices.iter().enumerate().find(|(_, i)| i.max_element() as usize >= vertices);
    outside.map_or(Ok(()), |(triangle, i)| {
        Err(TraceError::VertexIndex { triangle, vertex: i.max_element(), vertices })
    })
}

fn check_instances(instances: &[InstancePlacement], meshes: usize) -> Result<(), TraceError> {
    if instances.len() >= 1 << 24 {
        return Err(TraceError::TooManyInstances(instances.len()));
    }
    match instances.iter().enumerate().find(|(_, i)| i.mesh as usize >= meshes) {
        Some((instance, i)) => Err(TraceError::UnknownMesh { instance, mesh: i.mesh, meshes }),
        None => Ok(()),
    }
}
