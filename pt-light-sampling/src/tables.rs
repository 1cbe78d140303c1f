use crate::EnvironmentQuads;
use crate::lists::LightLists;
use crate::records::LocalLightsPush;
use crate::sampler_tables::{SamplerChoice, SamplerTables};
use crate::statistics::ShadowStatistics;
use pt_core::{Buffer, Device, Frame, Kernel, Location, Result, SceneResources};
use pt_scene::Scene;
use pt_scene::gpu::GpuScene;
use pt_shaders::records::{AliasRecord, LightRecord, LightSampler, LocalLightRecord, SceneRecord};

/// Threads in a row of a dispatch.
const ROW: u32 = 1 << 16;

/// The light lists of a scene on the GPU (`lights.glsl` reads them).
///
/// The environment's texels are not among them: the caller puts the image into the texture table (linear filter, repeating
/// along u, clamped along v, one mip level) and sets `environment_texture`.
pub struct LightTables {
    lists: LightLists,
    lights: Buffer,
    emissives: Buffer,
    emissive_alias: Buffer,
    emissive_lookup: Buffer,
    environment_alias: Buffer,
    quads: Option<QuadBuffers>,
    local_alias: Buffer,
    local_lights: Buffer,
    /// `local_lights` of the last frame, for samplers that reuse its samples.
    previous: Option<Buffer>,
    place: Kernel,
    /// Whether `local_lights` is as the scene was in the last frame.
    placed: bool,
    /// Whether `previous` is as well.
    settled: bool,
    sampler: Option<SamplerTables>,
}

/// The quads of the environment on the device.
struct QuadBuffers {
    quads: Buffer,
    nodes: Buffer,
    cells: Buffer,
}

impl QuadBuffers {
    fn new(device: &Device, quads: &EnvironmentQuads) -> Result<Self> {
        Ok(Self {
            quads: Buffer::from_slice(device, "environment quads", quads.quads())?,
            nodes: Buffer::from_slice(device, "environment quad-tree", quads.nodes())?,
            cells: Buffer::from_slice(device, "cells of environment quads", quads.cells())?,
        })
    }

    fn all(&self) -> [&Buffer; 3] {
        [&self.quads, &self.nodes, &self.cells]
    }
}

impl LightTables {
    /// Lists the scene's lights, uploads the tables and waits.
    ///
    /// # Errors
    /// When the device has no memory left for them (12 bytes a texel of the environment, 104 an emissive triangle, 76 a point or
    /// spot light, 4 a triangle of an instance that emits).
    pub fn new(device: &Device, scene: &Scene) -> Result<Self> {
        let lists = LightLists::new(scene);
        let alias = |name, table: &Option<crate::AliasTable>| {
            Buffer::from_slice(device, name, table.as_ref().map_or(&[][..], crate::AliasTable::entries))
        };
        let room = |name, bytes: usize| Buffer::new(device, name, bytes as u64, Location::Device);
        let lights = room("lights", scene.lights.len() * size_of::<LightRecord>())?;
        lights.write_through_staging(bytemuck::cast_slice(&lists.lights))?;
        let [local_alias, local_lights] = local_buffers(device, &lists)?;
        Ok(Self {
            lights,
            emissives: Buffer::from_slice(device, "emissive triangles", &lists.emissive_records())?,
            emissive_alias: alias("emissive alias", &lists.emissive_alias)?,
            emissive_lookup: Buffer::from_slice(device, "emissive lookup", &lists.emissive_lookup(scene))?,
            environment_alias: alias("environment alias", &lists.environment_alias)?,
            quads: None,
            local_alias,
            local_lights,
            place: Kernel::compute::<LocalLightsPush>(device, &crate::kernels::LOCAL_LIGHTS, &[])?,
            placed: false,
            previous: None,
            settled: false,
            sampler: None,
            lists,
        })
    }

    /// Makes the tables of a light sampler, new ones without any statistics, and attaches all to the scene on the device. `None`: no tables
    /// beyond those that picks by power or uniform picks need, and the environment apart.
    ///
    /// # Errors
    /// When the device has no memory left. A listed environment takes 12 bytes a texel.
    pub fn prepare(
        &mut self,
        device: &Device,
        scene: &Scene,
        gpu: &mut GpuScene,
        choice: Option<SamplerChoice>,
    ) -> Result<()> {
        if self.lists.list_environment(scene, choice.is_some_and(|choice| choice.environment_listed)) {
            let quads = self.lists.environment_quads.as_ref();
            self.quads = quads.map(|quads| QuadBuffers::new(device, quads)).transpose()?;
            [self.local_alias, self.local_lights] = local_buffers(device, &self.lists)?;
            self.placed = false;
        }
        let tables = |choice| SamplerTables::new(device, scene, gpu.clusters(), &self.lists, choice);
        self.sampler = choice.map(tables).transpose()?;
        let bytes = self.local_lights.size();
        let room = || Buffer::new(device, "local lights of the last frame", bytes, Location::Device);
        let reuses = choice.is_some_and(|choice| choice.sampler == LightSampler::RestirDi);
        self.previous = reuses.then(room).transpose()?;
        self.settled = false;
        self.attach(gpu);
        Ok(())
    }

    /// Forgets what the sampler has learned, and waits: the next frame is that of new tables. Lists and trees, which follow from the scene
    /// alone, stay.
    ///
    /// # Errors
    /// When the device fails.
    pub fn forget(&mut self) -> Result<()> {
        self.settled = false;
        self.sampler.as_mut().map_or(Ok(()), SamplerTables::forget)
    }

    /// Tables of the sampler, after [`LightTables::prepare`].
    pub fn sampler(&self) -> Option<&SamplerTables> {
        self.sampler.as_ref()
    }

    /// The same on the host.
    pub fn lists(&self) -> &LightLists {
        &self.lists
    }

    /// Brings the scene on the device and its lights to where they are now. Without change it records nothing; takes no device memory.
    /// Lights may move, change and go dark; their number is that of the scene that the tables were made from.
    ///
    /// # Errors
    /// When the frame can't take the uploads.
    pub fn update(&mut self, frame: &mut Frame<'_>, scene: &Scene, gpu: &mut GpuScene) -> Result<()> {
        if self.lists.update_lights(scene) {
            frame.upload(&self.lights, bytemuck::cast_slice(&self.lists.lights))?;
        }
        let change = self.lists.update_local(scene);
        if let (true, Some(table)) = (change.power, &self.lists.local_alias) {
            frame.upload(&self.local_alias, bytemuck::cast_slice(table.entries()))?;
        }
        if let Some(sampler) = &mut self.sampler {
            sampler.update(frame, &self.lists, change.moved)?;
        }
        self.fill(gpu.record_mut());
        gpu.update(frame, scene)?;
        let changed = change.moved || !std::mem::replace(&mut self.placed, true);
        let settled = std::mem::replace(&mut self.settled, !changed);
        if changed || (!settled && self.previous.is_some()) {
            self.place(frame, gpu)?;
        }
        match &mut self.sampler {
            Some(sampler) => sampler.record(frame, gpu),
            None => Ok(()),
        }
    }

    /// Makes the records of the local lights from the scene on the device.
    fn place(&self, frame: &mut Frame<'_>, gpu: &GpuScene) -> Result<()> {
        let count = self.lists.local.len() as u32;
        if count == 0 {
            return Ok(());
        }
        let width = count.min(ROW);
        let previous = self.previous.as_ref().map_or(0, Buffer::address);
        let push = LocalLightsPush { local_lights: self.local_lights.address(), previous, width, pad: 0 };
        let pass = gpu.bind(frame.pass("local lights", &self.place)).addresses_updated(&self.local_lights);
        let pass = self.previous.iter().fold(pass, |pass, buffer| pass.addresses_written(buffer));
        pass.push(&push).dispatch([width, count.div_ceil(width), 1])
    }

    /// Sets the addresses and counts of lights, emissive triangles and environment, and the environment's size, rotation
    /// and intensity. Leaves `environment_texture` alone.
    pub fn fill(&self, record: &mut SceneRecord) {
        self.lists.fill(record);
        record.lights = self.lights.address();
        record.emissives = self.emissives.address();
        record.emissive_alias = self.emissive_alias.address();
        record.emissive_lookup = self.emissive_lookup.address();
        record.environment_alias = self.environment_alias.address();
        for (address, buffer) in [
            (&mut record.environment_quads, self.quads.as_ref().map(|q| &q.quads)),
            (&mut record.environment_quad_nodes, self.quads.as_ref().map(|q| &q.nodes)),
            (&mut record.environment_quad_cells, self.quads.as_ref().map(|q| &q.cells)),
        ] {
            *address = buffer.map_or(0, Buffer::address);
        }
        record.local_alias = self.local_alias.address();
        record.local_lights = self.local_lights.address();
        record.local_lights_previous = self.previous.as_ref().map_or(0, Buffer::address);
        if let Some(sampler) = &self.sampler {
            sampler.fill(record);
        }
    }

    /// Gives the tables to the scene on the device: passes that bind the scene find the lights there.
    pub fn attach(&self, gpu: &mut GpuScene) {
        self.fill(gpu.record_mut());
        let tables = [
            &self.lights,
            &self.emissives,
            &self.emissive_alias,
            &self.emissive_lookup,
            &self.environment_alias,
            &self.local_alias,
            &self.local_lights,
        ];
        let sampler = self.sampler.iter().flat_map(SamplerTables::buffers);
        let quads = self.quads.iter().flat_map(QuadBuffers::all);
        let tables = tables.into_iter().chain(&self.previous).chain(quads).chain(sampler).cloned().collect();
        let counts =
            self.sampler.iter().filter_map(SamplerTables::statistics).flat_map(ShadowStatistics::counted);
        gpu.set_light_tables(tables, counts.cloned().collect());
    }
}

/// The alias table over the local lights, with room for those that are dark now, and room for their records.
fn local_buffers(device: &Device, lists: &LightLists) -> Result<[Buffer; 2]> {
    let room = |name, bytes: usize| Buffer::new(device, name, bytes as u64, Location::Device);
    let alias = room("local light alias", lists.local.len() * size_of::<AliasRecord>())?;
    if let Some(table) = &lists.local_alias {
        alias.write_through_staging(bytemuck::cast_slice(table.entries()))?;
    }
    Ok([alias, room("local lights", lists.local.len() * size_of::<LocalLightRecord>())?])
}
