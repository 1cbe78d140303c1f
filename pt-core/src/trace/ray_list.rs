//! Triangles on the device and kernels that trace a list of rays through them, for `pt bench trace`, `auto` and tests.

use super::push::RayListPush;
use super::{AccelStructure, BvhQuality, InstancePlacement, MeshGeometry, MovedMesh, TraceBackend};
use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::Result;
use crate::frame::{Frame, Uniforms};
use crate::kernel::Kernel;
use crate::kernels;
use crate::texture::TextureTable;
use glam::{Affine3A, Vec3, Vec4};
use pt_shaders::records::{
    FEATURE_INSTANCES, FEATURE_SKY, Hit, InstanceRecord, MeshRecord, NONE, Ray, SceneRecord,
};

/// The query: nearest hit or occlusion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Query {
    /// The nearest hit.
    Closest,
    /// Whether there is any; `Hit::instance` is 0 or [`NONE`].
    Occluded,
}

/// What masked triangles are to the rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coverage {
    /// Covered everywhere, as all others.
    Opaque,
    /// By alpha (MASK, BLEND); needs [`RayScene::set_materials`] when there are any.
    AlphaTest,
}

/// What rays can see.
#[derive(Clone, Copy, Debug)]
pub struct Visibility {
    /// Instances with `mask & instance mask != 0`.
    pub mask: u32,
    /// Seed of the numbers that decide which BLEND triangles a ray meets.
    pub seed: u32,
}

/// A scene without materials, traced with one backend.
pub struct RayScene {
    accel: AccelStructure,
    record: SceneRecord,
    uniforms: Uniforms<SceneRecord>,
    mesh_records: Vec<MeshRecord>,
    meshes: Buffer,
    instances: Buffer,
    taken: Buffer,
    geometry: Vec<Buffer>,
    textures: TextureTable,
    closest: Kernel,
    occluded: Kernel,
}

impl RayScene {
    /// Uploads `meshes` and takes memory for `instances` instances; [`RayScene::place`] comes next.
    ///
    /// # Errors
    /// As [`AccelStructure::new`].
    pub fn new(
        device: &Device,
        meshes: &[MeshGeometry],
        instances: usize,
        backend: TraceBackend,
        coverage: Coverage,
    ) -> Result<Self> {
        let [closest, occluded] = match coverage {
            Coverage::Opaque => [&kernels::RAY_LIST_CLOSEST_OPAQUE, &kernels::RAY_LIST_OCCLUDED_OPAQUE],
            Coverage::AlphaTest => [&kernels::RAY_LIST_CLOSEST, &kernels::RAY_LIST_OCCLUDED],
        };
        // A sky is a matter of materials.
        let without = if instances == 1 { FEATURE_SKY | FEATURE_INSTANCES } else { FEATURE_SKY };
        let constants = [("scene_features", (!without).into())];
        let accel = AccelStructure::new(device, meshes, instances, backend, BvhQuality::for_loading(meshes))?;
        let mut geometry = Vec::new();
        let mut mesh_records = Vec::new();
        for (index, mesh) in meshes.iter().enumerate() {
            let positions = Buffer::from_slice(device, "positions", mesh.positions)?;
            let indices = Buffer::from_slice(device, "indices", mesh.indices)?;
            let mut record = MeshRecord {
                positions: positions.address(),
                positions_prev: positions.address(),
                indices: indices.address(),
                first_masked: mesh.first_masked,
                triangle_count: mesh.indices.len() as u32,
                ..bytemuck::Zeroable::zeroed()
            };
            accel.fill_mesh(index, &mut record);
            mesh_records.push(record);
            geometry.extend([positions, indices]);
        }
        let size = (instances * size_of::<InstanceRecord>()) as u64;
        let instance_table = Buffer::new(device, "instances", size, Location::Device)?;
        let mesh_table = Buffer::from_slice(device, "meshes", &mesh_records)?;
        let mut record = SceneRecord {
            instances: instance_table.address(),
            meshes: mesh_table.address(),
            environment_texture: NONE,
            ..bytemuck::Zeroable::zeroed()
        };
        accel.fill_scene(&mut record);
        Ok(Self {
            accel,
            record,
            uniforms: Uniforms::new(device, "scene_uniforms")?,
            mesh_records,
            meshes: mesh_table,
            instances: instance_table,
            taken: Buffer::new(device, "taken rays", 4, Location::Device)?,
            geometry,
            textures: TextureTable::new(device, &[])?,
            closest: Kernel::trace::<RayListPush>(device, closest, backend, &constants)?,
            occluded: Kernel::trace::<RayListPush>(device, occluded, backend, &constants)?,
        })
    }

    /// Adds what coverage reads: `materials` (a `MaterialRecord` table) and, for each mesh, tables of `VertexRecord`, vertex
    /// colours and material indices. [`RayScene::place`] comes next.
    ///
    /// # Errors
    /// When the device fails to take the mesh table.
    pub fn set_materials(&mut self, materials: &Buffer, meshes: &[[Buffer; 3]]) -> Result<()> {
        self.record.materials = materials.address();
        self.geometry.push(materials.clone());
        for (record, [vertices, colors, triangle_materials]) in self.mesh_records.iter_mut().zip(meshes) {
            record.vertices = vertices.address();
            record.colors = colors.address();
            record.triangle_materials = triangle_materials.address();
            self.geometry.extend([vertices.clone(), colors.clone(), triangle_materials.clone()]);
        }
        self.meshes.write_through_staging(bytemuck::cast_slice(&self.mesh_records))
    }

    /// Moves the instances for the traces that follow.
    ///
    /// # Errors
    /// As [`AccelStructure::update`].
    pub fn place(&mut self, frame: &mut Frame<'_>, placements: &[InstancePlacement]) -> Result<()> {
        self.accel.update(frame, placements)?;
        let records: Vec<_> = placements.iter().map(instance_record).collect();
        frame.upload(&self.instances, bytemuck::cast_slice(&records))?;
        // Where there is none, its mask hides the first one.
        self.record.first_instance = records.first().copied().unwrap_or_else(bytemuck::Zeroable::zeroed);
        let first_mesh = self.mesh_records.get(self.record.first_instance.mesh as usize);
        self.record.first_mesh = first_mesh.copied().unwrap_or_else(bytemuck::Zeroable::zeroed);
        self.uniforms.upload(frame, &self.record)
    }

    /// Gives meshes that deform new vertices, for the traces that follow; [`RayScene::place`] comes next. `moved` holds the index
    /// and the positions of every mesh that deforms.
    ///
    /// # Errors
    /// As [`AccelStructure::refit`].
    pub fn deform(&mut self, frame: &mut Frame<'_>, moved: &[(u32, &[Vec3])]) -> Result<()> {
        let mut meshes = Vec::new();
        let mut geometry = Vec::new();
        for &(mesh, vertices) in moved {
            let [positions, indices] = [0, 1].map(|part| &self.geometry[2 * mesh as usize + part]);
            frame.upload(positions, bytemuck::cast_slice(vertices))?;
            let low = vertices.iter().copied().reduce(Vec3::min).unwrap_or_default();
            let high = vertices.iter().copied().reduce(Vec3::max).unwrap_or_default();
            let (positions_at, indices_at) = (positions.address(), indices.address());
            geometry.extend([positions, indices]);
            meshes.push(MovedMesh {
                mesh,
                positions: positions_at,
                indices: indices_at,
                bounds: (low, high),
            });
        }
        self.accel.refit(frame, &meshes, &self.meshes, &geometry)
    }

    /// Traces the first `count` rays of `rays` (a `Ray` table, `width` a row of the launch) into `hits` (a `Hit` table).
    ///
    /// # Errors
    /// When the pass can't be recorded.
    pub fn trace(
        &self,
        frame: &mut Frame<'_>,
        query: Query,
        rays: &Buffer,
        hits: &Buffer,
        [count, width]: [u32; 2],
        visibility: Visibility,
    ) -> Result<()> {
        let (name, kernel) = match query {
            Query::Closest => ("closest hits", &self.closest),
            Query::Occluded => ("occlusion", &self.occluded),
        };
        debug_assert!(rays.size() >= u64::from(count) * size_of::<Ray>() as u64);
        debug_assert!(hits.size() >= u64::from(count) * size_of::<Hit>() as u64);
        let Visibility { mask, seed } = visibility;
        frame.upload(&self.taken, &[0; 4])?;
        let [rays_at, hits_at, taken] = [rays, hits, &self.taken].map(Buffer::address);
        let push = RayListPush { rays: rays_at, hits: hits_at, taken, count, width, mask, seed };
        let pass = frame.pass(name, kernel).read("scene_uniforms", self.uniforms.buffer()).push(&push);
        let pass = if kernel.reflection().textures { pass.textures(&self.textures) } else { pass };
        let tables = self.geometry.iter().chain([&self.meshes, &self.instances, rays]);
        let pass = tables.fold(self.accel.bind(pass), |pass, table| pass.addresses(table));
        pass.addresses_written(hits).addresses_updated(&self.taken).dispatch([
            width,
            count.div_ceil(width),
            1,
        ])
    }
}

fn instance_record(placement: &InstancePlacement) -> InstanceRecord {
    let world_from_object = rows(&placement.world_from_object);
    InstanceRecord {
        world_from_object,
        object_from_world: rows(&placement.world_from_object.inverse()),
        world_from_object_prev: world_from_object,
        mesh: placement.mesh,
        mask: placement.mask,
        mirrored: u32::from(placement.world_from_object.matrix3.determinant() < 0.0),
        material: NONE,
    }
}

fn rows(transform: &Affine3A) -> [Vec4; 3] {
    let (m, t) = (transform.matrix3.transpose(), transform.translation);
    [m.x_axis.extend(t.x), m.y_axis.extend(t.y), m.z_axis.extend(t.z)]
}
