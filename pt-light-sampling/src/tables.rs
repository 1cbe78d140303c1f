use crate::EnvironmentQuads;
use crate::lists::LightLists;
use crate::records::LocalLightsPush;
use crate::sampler_tables::{SamplerChoice, SamplerTables};
use crate::statistics::ShadowStatistics;
use crate::table::Table;
use pt_core::{Buffer, Device, Error, Frame, Kernel, Result, SceneResources};
use pt_scene::gpu::{GpuScene, LightTableSet};
use pt_scene::{MAX_PORTALS, Portal, Scene};
use pt_shaders::records::{
    AliasRecord, LightCandidateRecord, LightRecord, LightSampler, LightTablesRecord, LocalLightRecord,
    PortalRecord, SceneRecord,
};

/// Threads in a row of a dispatch.
const ROW: u32 = 1 << 16;

/// The light lists of a scene on the GPU (`lights.glsl` reads them).
///
/// The environment's texels are not among them: the caller puts the image into the texture table (linear filter, repeating
/// along u, clamped along v, one mip level) and sets `environment_texture`.
pub struct LightTables {
    lists: LightLists,
    /// Most punctual lights that there may be.
    room: usize,
    lights: Table,
    emissives: Buffer,
    emissive_alias: Buffer,
    emissive_lookup: Buffer,
    environment_alias: Buffer,
    portals: Buffer,
    portal_count: u32,
    quads: Option<QuadBuffers>,
    local_alias: Table,
    local_lights: Table,
    /// What choices read of `local_lights`.
    light_candidates: Table,
    place: Kernel,
    /// Whether `local_lights` is as the scene was in the last frame.
    placed: bool,
    keeps_last: bool,
    /// Whether the tables of a sampler were made, as `keeps_last` says.
    prepared: bool,
    /// What the last frame read, if there was one with these tables. Other tables may have been attached to the scene since.
    last: Option<LightTablesRecord>,
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
    /// When the device has no memory left for them (12 bytes a texel of the environment, 136 an emissive triangle, 108 a point or
    /// spot light, 4 a triangle of an instance that emits).
    pub fn new(device: &Device, scene: &Scene) -> Result<Self> {
        Self::with_room(device, scene, scene.lights.len())
    }

    /// As [`LightTables::new`], with room for that many punctual lights, of which more may appear later. The place of a light that vanishes
    /// is free one frame later, so two frames together should have no more lights than that.
    ///
    /// # Errors
    /// As [`LightTables::new`].
    pub fn with_room(device: &Device, scene: &Scene, room: usize) -> Result<Self> {
        let room = room.max(scene.lights.len());
        let lists = LightLists::new(scene);
        let alias = |name, table: &Option<crate::AliasTable>| {
            Buffer::from_slice(device, name, table.as_ref().map_or(&[][..], crate::AliasTable::entries))
        };
        let table = |name, bytes: usize| Table::new(device, name, bytes, false);
        let lights = table("lights", room * size_of::<LightRecord>())?;
        lights.now().write_through_staging(bytemuck::cast_slice(&lists.lights))?;
        let [local_alias, local_lights, light_candidates] = local_tables(device, &lists, room)?;
        let portals = portals(scene);
        Ok(Self {
            room,
            lights,
            emissives: Buffer::from_slice(device, "emissive triangles", &lists.emissive_records())?,
            emissive_alias: alias("emissive alias", &lists.emissive_alias)?,
            emissive_lookup: Buffer::from_slice(device, "emissive lookup", &lists.emissive_lookup(scene))?,
            environment_alias: alias("environment alias", &lists.environment_alias)?,
            portals: Buffer::from_slice(device, "portals", &portals)?,
            portal_count: portals.len() as u32,
            quads: None,
            local_alias,
            local_lights,
            light_candidates,
            place: Kernel::compute::<LocalLightsPush>(device, &crate::kernels::LOCAL_LIGHTS, &[])?,
            placed: false,
            keeps_last: false,
            prepared: false,
            last: None,
            sampler: None,
            lists,
        })
    }

    /// Whether the tables that [`LightTables::prepare`] makes keep those of the last frame, so that kernels with gradient pixels
    /// (`lights/light_tables.glsl`) can take its light samples again. What that costs: see [`LightTables::prepare`].
    pub fn keep_last_frame(&mut self, keeps: bool) {
        self.prepared &= self.keeps_last == keeps;
        self.keeps_last = keeps;
    }

    /// Makes the tables of a light sampler, new ones without any statistics, and attaches all to the scene on the device. `None`: no tables
    /// beyond those that picks by power or uniform picks need, and the environment apart.
    ///
    /// With [`LightTables::keep_last_frame`] there is a second copy of what changes: 172 bytes a local light; 104 a light for the light tree; 20 a
    /// cluster and 4 an entry for lists; 4 an entry of dense statistics or 8 of sparse ones, and 24 x (1 + [`MAX_SUBSETS`](pt_shaders::records::MAX_SUBSETS)) a cluster.
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
            [self.local_alias, self.local_lights, self.light_candidates] =
                local_tables(device, &self.lists, self.room)?;
        }
        let (keeps, most) = (self.keeps_last, self.most_local_lights());
        let tables =
            |choice| SamplerTables::new(device, scene, gpu.clusters(), &self.lists, choice, most, keeps);
        self.sampler = choice.map(tables).transpose()?;
        self.lights.keep_last(device, keeps)?;
        self.local_alias.keep_last(device, keeps)?;
        self.light_candidates.keep_last(device, keeps)?;
        let reuses = choice.is_some_and(|choice| choice.sampler == LightSampler::RestirDi);
        self.local_lights.keep_last(device, keeps || reuses)?;
        (self.placed, self.prepared, self.last) = (false, true, None);
        self.attach(gpu);
        Ok(())
    }

    /// Forgets what the sampler has learned, and waits: the next frame is that of new tables. Lists and trees, which follow from the scene
    /// alone, stay.
    ///
    /// # Errors
    /// When the device fails.
    pub fn forget(&mut self) -> Result<()> {
        self.last = None;
        self.sampler.as_mut().map_or(Ok(()), SamplerTables::forget)
    }

    /// Tables of the sampler, after [`LightTables::prepare`].
    pub fn sampler(&self) -> Option<&SamplerTables> {
        self.sampler.as_ref()
    }

    /// Most local lights that there may be.
    fn most_local_lights(&self) -> usize {
        self.lists.first_positional() + self.room
    }

    /// The same on the host.
    pub fn lists(&self) -> &LightLists {
        &self.lists
    }

    /// Brings the scene on the device and its lights to where they are now. Without change it records nothing; takes no device memory.
    /// Lights may move, change and go dark; punctual ones may also appear and vanish ([`Light::id`](pt_scene::Light::id) tells which is which), as
    /// long as there is [room](LightTables::with_room). The emissive triangles are those of the scene that the tables were made from.
    ///
    /// # Errors
    /// When the frame can't take the uploads, or when there are more lights than room.
    pub fn update(&mut self, frame: &mut Frame<'_>, scene: &Scene, gpu: &mut GpuScene) -> Result<()> {
        let changed = self.lists.update_lights(scene);
        let lights = self.lists.lights.len();
        if lights > self.room {
            return Err(Error::TooManyLights { lights, room: self.room });
        }
        if changed {
            frame.upload(self.lights.replace(), bytemuck::cast_slice(&self.lists.lights))?;
        }
        let change = self.lists.update_local(scene);
        if let (true, Some(table)) = (change.power, &self.lists.local_alias) {
            frame.upload(self.local_alias.replace(), bytemuck::cast_slice(table.entries()))?;
        }
        if let Some(sampler) = &mut self.sampler {
            sampler.update(frame, &self.lists, change.moved)?;
        }
        let moved = change.moved || self.lists.deforms || !std::mem::replace(&mut self.placed, true);
        if moved {
            self.local_lights.replace();
            self.light_candidates.replace();
        }
        let record = gpu.record_mut();
        self.fill(record);
        record.light_tables_previous = record.light_tables;
        if let Some(last) = self.last.replace(record.light_tables) {
            record.light_tables_previous = last;
            if let Some(sampler) = &self.sampler {
                sampler.fill_last(&mut record.light_tables_previous);
            }
        }
        gpu.update(frame, scene)?;
        if moved {
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
        let (local_lights, light_candidates) = (self.local_lights.address(), self.light_candidates.address());
        let push = LocalLightsPush { local_lights, light_candidates, width, count };
        let pass = gpu.bind(frame.pass("local lights", &self.place));
        let pass = pass.addresses_updated(self.local_lights.now());
        pass.addresses_updated(self.light_candidates.now()).push(&push).dispatch([
            width,
            count.div_ceil(width),
            1,
        ])
    }

    /// Sets the addresses and counts of lights, emissive triangles and environment, and the environment's size, rotation
    /// and intensity. Leaves `environment_texture` alone.
    pub fn fill(&self, record: &mut SceneRecord) {
        // Tables of another sampler that were there before are gone.
        record.light_tables = bytemuck::Zeroable::zeroed();
        self.lists.fill(record);
        self.lists.fill_counts(&mut record.light_tables);
        record.most_local_lights = self.most_local_lights() as u32;
        record.light_tables.lights = self.lights.address();
        record.light_tables.local_alias = self.local_alias.address();
        record.light_tables.local_lights = self.local_lights.address();
        record.light_tables.light_candidates = self.light_candidates.address();
        record.emissives = self.emissives.address();
        record.emissive_alias = self.emissive_alias.address();
        record.emissive_lookup = self.emissive_lookup.address();
        record.environment_alias = self.environment_alias.address();
        record.portals = self.portals.address();
        record.portal_count = self.portal_count;
        for (address, buffer) in [
            (&mut record.environment_quads, self.quads.as_ref().map(|q| &q.quads)),
            (&mut record.environment_quad_nodes, self.quads.as_ref().map(|q| &q.nodes)),
            (&mut record.environment_quad_cells, self.quads.as_ref().map(|q| &q.cells)),
        ] {
            *address = buffer.map_or(0, Buffer::address);
        }
        if let Some(sampler) = &self.sampler {
            sampler.fill(record);
        }
    }

    /// Gives the tables to the scene on the device: passes that bind the scene find the lights there. What a pass needs and the tables do not
    /// have is refused when it is recorded, as [`Error::MissingTable`].
    pub fn attach(&self, gpu: &mut GpuScene) {
        let record = gpu.record_mut();
        self.fill(record);
        // Until `update` brings the tables to where the lights are, kernels are refused.
        record.light_tables_previous = bytemuck::Zeroable::zeroed();
        let emissives = [&self.emissives, &self.emissive_alias, &self.emissive_lookup];
        let fixed = emissives.into_iter().chain([&self.environment_alias, &self.portals]);
        let replaced = [&self.lights, &self.local_alias, &self.local_lights, &self.light_candidates]
            .into_iter()
            .flat_map(Table::copies);
        let sampler = self.sampler.iter().flat_map(SamplerTables::buffers);
        let quads = self.quads.iter().flat_map(QuadBuffers::all);
        let tables = fixed.chain(replaced).chain(quads).chain(sampler).cloned().collect();
        let counts =
            self.sampler.iter().filter_map(SamplerTables::statistics).flat_map(ShadowStatistics::counted);
        gpu.set_light_tables(LightTableSet {
            buffers: tables,
            updated: counts.cloned().collect(),
            environment_listed: self.lists.environment_quads.is_some(),
            keeps_last_lights: self.local_lights.copies().len() > 1,
            keeps_last_choices: self.keeps_last && self.prepared,
        });
    }
}

/// The portals of a scene that samplers look at.
fn portals(scene: &Scene) -> Vec<PortalRecord> {
    let usable = scene.portals.iter().filter(|portal| portal.has_area()).take(MAX_PORTALS);
    let record = |&Portal { corner, edges: [edge1, edge2] }: &Portal| PortalRecord { corner, edge1, edge2 };
    usable.map(record).collect()
}

/// The alias table over the local lights and their records, with room for `room` punctual lights and for those that are dark now.
fn local_tables(device: &Device, lists: &LightLists, room: usize) -> Result<[Table; 3]> {
    let most = lists.first_positional() + room;
    let alias = Table::new(device, "local light alias", most * size_of::<AliasRecord>(), false)?;
    if let Some(table) = &lists.local_alias {
        alias.now().write_through_staging(bytemuck::cast_slice(table.entries()))?;
    }
    let lights = Table::new(device, "local lights", most * size_of::<LocalLightRecord>(), false)?;
    let bytes = most * size_of::<LightCandidateRecord>();
    Ok([alias, lights, Table::new(device, "light candidates", bytes, false)?])
}
