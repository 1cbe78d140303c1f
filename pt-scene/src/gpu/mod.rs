//! The scene on the device: geometry, materials, textures, acceleration structure.

mod camera;
mod deform;
mod deform_records;
mod effects;
mod light_tables;
mod records;
mod textures;

pub use camera::camera_record;
pub use effects::{effect_records, effect_tree};
pub use light_tables::LightTableSet;

mod kernels {
    include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
}

use crate::opacity::opacity_tables;
use crate::{Clusters, Scene};
use deform::{Change, DeformingMeshes};
use effects::EffectBuffers;
use glam::{UVec3, Vec2, Vec3};
use pt_core::blue_noise::mask_buffer;
use pt_core::frame::{Pass, Uniforms};
use pt_core::phases::{Phase, Phases};
use pt_core::random::RandomSource;
use pt_core::texture::TextureTable;
use pt_core::trace::bench::{Choice, choose};
use pt_core::trace::{
    AccelStructure, BvhQuality, InstancePlacement, MeshGeometry, TraceBackend, TraceVariant,
};
use pt_core::{Buffer, Device, Frame, Location, Result, SceneResources};
use pt_shaders::records::{
    CameraRecord, Culling, FEATURE_CAMERA_VIEWS, FEATURE_MIXED_SIDES, FEATURE_WAVES, InstanceRecord,
    MASK_MIXED_SIDES, MeshRecord, SceneRecord,
};
use std::thread::{self, Scope};

/// A scene whose instances may move from frame to frame, and whose meshes may change their shape; everything else is fixed.
pub struct GpuScene {
    phases: Phases,
    choice: Option<Choice>,
    features: u32,
    accel: AccelStructure,
    textures: TextureTable,
    uniforms: Uniforms<SceneRecord>,
    record: SceneRecord,
    uploaded_record: Option<SceneRecord>,
    instances: Buffer,
    instance_records: Vec<InstanceRecord>,
    placements: Vec<InstancePlacement>,
    masks: Vec<u32>,
    deforming: Option<DeformingMeshes>,
    effects: Option<EffectBuffers>,
    mesh_records: Vec<MeshRecord>,
    mesh_buffer: Buffer,
    index_buffer: Buffer,
    clusters: Clusters,
    cluster_nodes: Buffer,
    bsdf_tables: Buffer,
    cameras: Buffer,
    camera_records: Vec<CameraRecord>,
    /// Reached through addresses; held so that they live as long as the scene.
    tables: Vec<Buffer>,
    /// The same of the lights; another crate fills them.
    light_tables: LightTableSet,
}

/// The scene's meshes as the acceleration structures take them.
pub fn mesh_geometry(scene: &Scene) -> Vec<MeshGeometry<'_>> {
    let geometry = scene.meshes.iter().map(|mesh| MeshGeometry {
        positions: &mesh.positions,
        indices: bytemuck::cast_slice(&mesh.indices),
        first_masked: mesh.first_masked as u32,
        deforms: mesh.deformation.is_some(),
    });
    geometry.collect()
}

/// The scene's instances where they are now.
pub fn placements(scene: &Scene) -> Vec<InstancePlacement> {
    place_all(scene, &records::visibility_masks(scene)).collect()
}

fn place_all<'a>(scene: &'a Scene, masks: &'a [u32]) -> impl Iterator<Item = InstancePlacement> + 'a {
    let place = |(i, &mask): (&crate::Instance, &u32)| InstancePlacement {
        mesh: i.mesh,
        mask,
        world_from_object: i.world_from_object,
    };
    scene.instances.iter().zip(masks).map(place)
}

/// All meshes' arrays of one kind in one buffer, with the byte offset of each mesh.
struct Arena<T> {
    data: Vec<T>,
    offsets: Vec<u64>,
}

impl<T: bytemuck::NoUninit> Arena<T> {
    fn collect<I: IntoIterator<Item = T>>(meshes: impl Iterator<Item = I>) -> Self {
        let (mut data, mut offsets) = (Vec::new(), Vec::new());
        for mesh in meshes {
            offsets.push((data.len() * size_of::<T>()) as u64);
            data.extend(mesh);
        }
        Self { data, offsets }
    }

    fn upload(&self, device: &Device, name: &str) -> Result<Buffer> {
        Buffer::from_slice(device, name, &self.data)
    }
}

/// See [`SceneRecord::near_origin`]: 1/32 m, in scenes smaller than a metre as much less.
fn near_origin(scene: &Scene) -> f32 {
    let size = scene.bounds().map_or(1.0, |bounds| bounds.size().length());
    size.clamp(f32::MIN_POSITIVE, 1.0) / 32.0
}

impl GpuScene {
    /// Uploads the scene and builds its acceleration structures for `backend` (`Auto` measures on this scene).
    pub fn new(device: &Device, scene: &Scene, backend: TraceBackend) -> Result<Self> {
        thread::scope(|threads| Self::upload(threads, device, scene, backend))
    }

    fn upload<'scope>(
        threads: &'scope Scope<'scope, '_>,
        device: &Device,
        scene: &'scope Scene,
        backend: TraceBackend,
    ) -> Result<Self> {
        let mut phases = Phases::start();
        let meshes = &scene.meshes;
        let opacity = Arena::collect(opacity_tables(scene).into_iter());
        if !opacity.data.is_empty() {
            phases.mark("opacity tables");
        }
        let deforming = DeformingMeshes::new(device, scene)?;
        // The vertices of deforming meshes are elsewhere.
        let rigid = |m: &crate::Mesh| if m.deformation.is_none() { m.vertex_count() } else { 0 };
        let positions = Arena::collect(meshes.iter().map(|m| m.positions.iter().copied().take(rigid(m))));
        let vertices = Arena::collect(meshes.iter().map(|m| records::vertices(m).take(rigid(m))));
        let indices = Arena::collect(meshes.iter().map(|m| m.indices.iter().map(|&i| UVec3::from_array(i))));
        let materials = Arena::collect(meshes.iter().map(|m| m.triangle_materials.iter().copied()));
        let colored = |m: &crate::Mesh| if m.is_colored() { m.vertex_count() } else { 0 };
        let colors = Arena::collect(meshes.iter().map(|m| m.colors.iter().copied().take(colored(m))));
        let position_buffer = positions.upload(device, "positions")?;
        let vertex_buffer = vertices.upload(device, "vertices")?;
        let color_buffer = colors.upload(device, "vertex colours")?;
        let index_buffer = indices.upload(device, "indices")?;
        let material_index_buffer = materials.upload(device, "triangle materials")?;

        let opacity_buffer = opacity.upload(device, "opacity")?;

        phases.mark("geometry: upload");
        let geometry = mesh_geometry(scene);
        let masks = records::visibility_masks(scene);
        let choice = match backend {
            TraceBackend::Auto => Some(choose(device, &geometry, &placements(scene))?),
            _ => None,
        };
        let backend = choice.as_ref().map_or(backend, |choice| choice.backend);
        let count = scene.instances.len();
        phases.mark("choice of backend");
        let textures = textures::prepare_all(threads, device, scene);
        let accel =
            AccelStructure::new(device, &geometry, count, backend, BvhQuality::for_loading(&geometry))?;
        phases.mark("BVH");
        let mut mesh_records: Vec<_> = meshes
            .iter()
            .enumerate()
            .map(|(i, mesh)| {
                let mut record = MeshRecord {
                    bvh_nodes: 0,
                    bvh_triangles: 0,
                    positions: position_buffer.address() + positions.offsets[i],
                    positions_prev: position_buffer.address() + positions.offsets[i],
                    vertices: vertex_buffer.address() + vertices.offsets[i],
                    colors: if mesh.is_colored() { color_buffer.address() + colors.offsets[i] } else { 0 },
                    indices: index_buffer.address() + indices.offsets[i],
                    triangle_materials: material_index_buffer.address() + materials.offsets[i],
                    opacity: opacity_buffer.address() + opacity.offsets[i],
                    first_masked: mesh.first_masked as u32,
                    triangle_count: mesh.triangle_count() as u32,
                };
                accel.fill_mesh(i, &mut record);
                record
            })
            .collect();
        if let Some(deforming) = &deforming {
            deforming.fill(&mut mesh_records);
        }
        let mesh_buffer = Buffer::from_slice(device, "meshes", &mesh_records)?;
        let (material_records, lobe_records) = records::materials(&scene.materials, &scene.textures);
        let mixed_sides = masks.iter().any(|mask| mask & MASK_MIXED_SIDES != 0);
        let features =
            records::features(scene, &material_records) | if mixed_sides { FEATURE_MIXED_SIDES } else { 0 };
        let material_buffer = Buffer::from_slice(device, "materials", &material_records)?;
        let lobe_buffer = Buffer::from_slice(device, "lobes", &lobe_records)?;
        let instance_bytes = (scene.instances.len() * size_of::<InstanceRecord>()) as u64;
        let instances = Buffer::new(device, "instances", instance_bytes, Location::Device)?;

        let camera_count = if features & FEATURE_CAMERA_VIEWS != 0 { scene.cameras.len() } else { 1 };
        let camera_bytes = (camera_count * size_of::<CameraRecord>()) as u64;
        let cameras = Buffer::new(device, "cameras", camera_bytes, Location::Device)?;

        let environment = &scene.environment;
        let mut record = SceneRecord {
            instances: instances.address(),
            meshes: mesh_buffer.address(),
            materials: material_buffer.address(),
            lobes: lobe_buffer.address(),
            cameras: cameras.address(),
            near_origin: near_origin(scene),
            environment_texture: scene.textures.len() as u32,
            environment_size: [environment.image.width, environment.image.height].into(),
            environment_rotation: Vec2::new(environment.rotation.cos(), environment.rotation.sin()),
            environment_intensity: if environment.is_black() { 0.0 } else { environment.intensity },
            ..bytemuck::Zeroable::zeroed()
        };
        accel.fill_scene(&mut record);
        let clusters = Clusters::new(scene, Clusters::DEFAULT);
        let cluster_nodes = Buffer::from_slice(device, "clusters", clusters.nodes())?;
        record.clusters = cluster_nodes.address();
        let blue_noise = mask_buffer(device)?;
        record.blue_noise = blue_noise.address();
        phases.mark("clusters");
        let textures = textures::table(device, scene, textures)?;
        phases.mark("textures: mips and upload");
        Ok(Self {
            phases,
            choice,
            features,
            accel,
            textures,
            uniforms: Uniforms::new(device, "scene_uniforms")?,
            record,
            uploaded_record: None,
            instances,
            instance_records: Vec::new(),
            placements: Vec::new(),
            masks,
            deforming,
            effects: EffectBuffers::new(device, &scene.effects)?,
            mesh_records,
            clusters,
            cluster_nodes,
            cameras,
            camera_records: Vec::new(),
            bsdf_tables: Buffer::from_slice(device, "bsdf_tables", &crate::bsdf_tables::packed())?,
            tables: vec![
                position_buffer,
                vertex_buffer,
                color_buffer,
                index_buffer.clone(),
                material_index_buffer,
                opacity_buffer,
                mesh_buffer.clone(),
                material_buffer,
                lobe_buffer,
                blue_noise,
            ],
            light_tables: LightTableSet::default(),
            mesh_buffer,
            index_buffer,
        })
    }

    /// How long the steps of [`GpuScene::new`] took; of mips, which are made beside the acceleration structures, what was left.
    pub fn load_phases(&self) -> &[Phase] {
        self.phases.list()
    }

    /// Bytes of all textures with their mips, and of the environment, on the device.
    pub fn texture_bytes(&self) -> u64 {
        self.textures.bytes()
    }

    /// The backend in use, never `Auto`.
    pub fn backend(&self) -> TraceBackend {
        self.accel.backend()
    }

    /// `FEATURE_*` bits of what the materials, meshes and lights have, for kernels that are specialised.
    pub fn features(&self) -> u32 {
        self.features
    }

    /// What kernels that trace rays through this scene are made for.
    /// White noise, no culling.
    pub fn variant(&self) -> TraceVariant {
        let (random, culling) = (RandomSource::White, Culling::None);
        TraceVariant { backend: self.backend(), random, culling, scene_features: self.features }
    }

    /// What `Auto` measured; `None` when the backend was asked for by name.
    pub fn choice(&self) -> Option<&Choice> {
        self.choice.as_ref()
    }

    /// The record that kernels see, for tables that other crates add.
    pub fn record_mut(&mut self) -> &mut SceneRecord {
        &mut self.record
    }

    /// Sets the buffers that the light addresses of the record point to. A pass whose kernel needs others is refused
    /// ([`pt_core::Error::MissingTable`]).
    pub fn set_light_tables(&mut self, tables: LightTableSet) {
        self.light_tables = tables;
    }

    /// The division of its space into clusters.
    pub fn clusters(&self) -> &Clusters {
        &self.clusters
    }

    /// Uses another division into clusters than the default one; before the first frame.
    pub fn set_clusters(&mut self, device: &Device, clusters: &Clusters) -> Result<()> {
        self.cluster_nodes = Buffer::from_slice(device, "clusters", clusters.nodes())?;
        self.record.clusters = self.cluster_nodes.address();
        self.clusters = clusters.clone();
        Ok(())
    }

    /// Brings the device up to date with the poses of deforming meshes and the instances' transforms; without change it records
    /// nothing. What was there in the frame before is previous afterwards; in the first frame everything has been where it is.
    pub fn update(&mut self, frame: &mut Frame<'_>, scene: &Scene) -> Result<()> {
        let deformed = self.deform(frame, scene)?;
        let mirrored = |i: &crate::Instance| {
            scene.meshes[i.mesh as usize].deformation.as_ref().is_some_and(|d| d.is_mirrored())
        };
        let records = scene.instances.iter().zip(&self.masks).map(|(i, &mask)| {
            let record = records::instance(i, mask);
            InstanceRecord { mirrored: record.mirrored ^ u32::from(mirrored(i)), ..record }
        });
        // The first frame has a top level too, where there are no instances.
        let mut moved = deformed || self.uploaded_record.is_none();
        if !records.clone().eq(self.instance_records.iter().copied()) {
            moved |= !self
                .instance_records
                .iter()
                .map(|r| r.world_from_object)
                .eq(records.clone().map(|r| r.world_from_object));
            self.instance_records.clear();
            self.instance_records.extend(records);
            frame.upload(&self.instances, bytemuck::cast_slice(&self.instance_records))?;
        }
        if moved {
            self.placements.clear();
            self.placements.extend(place_all(scene, &self.masks));
            self.accel.update(frame, &self.placements)?;
        }
        self.update_views(frame, scene)?;
        if let Some(effects) = &mut self.effects {
            effects.update(frame, &scene.effects, &mut self.record)?;
        }
        if let Some(&first) = self.instance_records.first() {
            self.record.first_instance = first;
            self.record.first_mesh = self.mesh_records[first.mesh as usize];
        }
        if self.uploaded_record != Some(self.record) {
            self.uniforms.upload(frame, &self.record)?;
            self.uploaded_record = Some(self.record);
        }
        Ok(())
    }

    /// What surfaces show of their own accord: waves, and the views of cameras.
    fn update_views(&mut self, frame: &mut Frame<'_>, scene: &Scene) -> Result<()> {
        if self.features & FEATURE_WAVES != 0 {
            self.record.time = scene.time as f32;
        }
        if self.features & FEATURE_CAMERA_VIEWS == 0 {
            return Ok(());
        }
        let records: Vec<_> = scene.cameras.iter().map(|c| camera::view_record(&c.at(scene.time))).collect();
        if records != self.camera_records {
            frame.upload(&self.cameras, bytemuck::cast_slice(&records))?;
            self.camera_records = records;
        }
        Ok(())
    }

    /// Moves the vertices of deforming meshes and refits their acceleration structures; whether there was anything to do.
    fn deform(&mut self, frame: &mut Frame<'_>, scene: &Scene) -> Result<bool> {
        let Some(deforming) = &mut self.deforming else { return Ok(false) };
        let change = deforming.update(frame, scene)?;
        if change != Change::None {
            deforming.fill(&mut self.mesh_records);
            frame.upload(&self.mesh_buffer, bytemuck::cast_slice(&self.mesh_records))?;
        }
        if change == Change::Moved {
            let geometry = [deforming.positions().clone(), self.index_buffer.clone()];
            let moved = deforming.moved(scene, &self.mesh_records);
            self.accel.refit(frame, moved, &self.mesh_buffer, &geometry.each_ref())?;
        }
        Ok(change == Change::Moved)
    }

    /// Positions of a mesh that deforms, in the frame recorded last and in the one before it; `None` for a rigid mesh. Waits: for
    /// tests and tools.
    pub fn read_positions(&self, scene: &Scene, mesh: usize) -> Option<Result<[Vec<Vec3>; 2]>> {
        self.deforming.as_ref()?.read(mesh, &self.mesh_records[mesh], scene.meshes[mesh].vertex_count())
    }

    /// The instances as the frame recorded last saw them. Waits: for tests and tools.
    pub fn read_instances(&self) -> Result<Vec<InstanceRecord>> {
        self.instances.read()
    }
}

impl SceneResources for GpuScene {
    fn bind<'f, 'r>(&self, pass: Pass<'f, 'r>) -> Pass<'f, 'r> {
        let pass = pass
            .read("scene_uniforms", self.uniforms.buffer())
            .read_if_used("bsdf_tables", &self.bsdf_tables)
            .textures(&self.textures)
            .addresses(&self.instances)
            .addresses(&self.cluster_nodes)
            .addresses(&self.cameras);
        let missing = light_tables::missing(&self.light_tables, &self.record, pass.kernel());
        let pass = pass.lacks(missing);
        let tables = self.tables.iter().chain(&self.light_tables.buffers);
        let pass = tables.fold(pass, |pass, table| pass.addresses(table));
        let updated = &self.light_tables.updated;
        let pass = updated.iter().fold(pass, |pass, table| pass.addresses_updated(table));
        let pass = match &self.deforming {
            Some(deforming) => deforming.bind(pass),
            None => pass,
        };
        let pass = match &self.effects {
            Some(effects) => effects.bind(pass),
            None => pass,
        };
        self.accel.bind(pass)
    }
}
