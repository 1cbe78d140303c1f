use crate::lists::LightLists;
use pt_core::{Buffer, Device, Result};
use pt_scene::Scene;
use pt_shaders::records::SceneRecord;

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
        Ok(Self {
            lights: Buffer::from_slice(device, "lights", &lists.lights)?,
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

    /// All buffers, for `Pass::addresses`.
    pub fn buffers(&self) -> [&Buffer; 5] {
        [&self.lights, &self.emissives, &self.emissive_alias, &self.emissive_lookup, &self.environment_alias]
    }
}
