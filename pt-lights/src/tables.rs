use crate::lists::LightLists;
use pt_core::{Buffer, Device, Frame, Location, Result};
use pt_scene::Scene;
use pt_scene::gpu::GpuScene;
use pt_shaders::records::{LightRecord, SceneRecord};

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
}

impl LightTables {
    /// Lists the scene's lights, uploads the tables and waits.
    ///
    /// # Errors
    /// When the device has no memory left for them (12 bytes a texel of the environment, 24 an emissive triangle, 4 a triangle
    /// of an instance that emits).
    pub fn new(device: &Device, scene: &Scene) -> Result<Self> {
        let lists = LightLists::new(scene);
        let entries = |table: &Option<_>| table.as_ref().map_or(&[][..], crate::AliasTable::entries).to_vec();
        // Room for lights that are dark now.
        let bytes = (scene.lights.len() * size_of::<LightRecord>()) as u64;
        let lights = Buffer::new(device, "lights", bytes, Location::Device)?;
        lights.write_through_staging(bytemuck::cast_slice(&lists.lights))?;
        Ok(Self {
            lights,
            emissives: Buffer::from_slice(device, "emissive triangles", &lists.emissive_records())?,
            emissive_alias: Buffer::from_slice(device, "emissive alias", &entries(&lists.emissive_alias))?,
            emissive_lookup: Buffer::from_slice(device, "emissive lookup", &lists.emissive_lookup(scene))?,
            environment_alias: Buffer::from_slice(
                device,
                "environment alias",
                &entries(&lists.environment_alias),
            )?,
            lists,
        })
    }

    /// The same on the host.
    pub fn lists(&self) -> &LightLists {
        &self.lists
    }

    /// Brings the punctual lights to where the scene has them now, and their counts into `record`, which the scene's next update
    /// uploads. Without change it records nothing; takes no device memory. Lights may move, change and go dark; their
    /// number is that of the scene that the tables were made from.
    ///
    /// # Errors
    /// When the upload can't be recorded.
    pub fn update(&mut self, frame: &mut Frame<'_>, scene: &Scene, record: &mut SceneRecord) -> Result<()> {
        if self.lists.update_lights(scene) {
            frame.upload(&self.lights, bytemuck::cast_slice(&self.lists.lights))?;
        }
        self.fill(record);
        Ok(())
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
        ];
        gpu.set_light_tables(tables.map(Buffer::clone).to_vec());
    }
}
