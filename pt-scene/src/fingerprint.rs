use crate::{Environment, Scene, Texels};

impl Scene {
    /// Hash of everything that an image of the scene depends on, where its instances are now; of its cameras those that surfaces show: 32 hexadecimal
    /// digits. Scenes with different content have different fingerprints; a file moved or renamed keeps its own.
    pub fn fingerprint(&self) -> String {
        let mut hash = Hash(blake3::Hasher::new());
        self.materials.iter().for_each(|material| hash.text(material));
        self.instances
            .iter()
            .for_each(|i| hash.text(&(i.mesh, i.world_from_object, i.world_from_object_prev)));
        self.lights.iter().for_each(|light| hash.text(light));
        self.shown_cameras().for_each(|camera| hash.text(&camera.at(self.time)));
        if self.materials.iter().any(|material| material.waves.is_some()) {
            hash.text(&self.time);
        }
        if !self.effects.is_empty() {
            let crate::Effects { particles, sprites, beams, fog, time, time_prev } = &self.effects;
            hash.text(&(particles, sprites, beams, fog));
            hash.text(&self.effects.is_animated().then_some((time, time_prev)));
        }
        hash.environment(&self.environment);
        self.portals.iter().for_each(|portal| hash.text(portal));
        for texture in &self.textures {
            hash.text(&(texture.width, texture.height, texture.usage, texture.sampler));
            match &texture.texels {
                Texels::Rgba8(texels) => hash.words(texels),
                Texels::Rgba16(texels) => hash.words(texels),
                Texels::Blocks { format, levels } => {
                    hash.text(format);
                    levels.iter().for_each(|level| hash.words(level));
                }
            }
        }
        for mesh in &self.meshes {
            hash.words(&mesh.positions);
            hash.words(&mesh.normals);
            hash.words(&mesh.tangents);
            hash.words(&mesh.uv0);
            hash.words(&mesh.uv1);
            hash.words(&mesh.colors);
            hash.words(&mesh.indices);
            hash.words(&mesh.triangle_materials);
        }
        hash.0.finalize().to_hex()[..32].to_owned()
    }
}

impl Environment {
    /// Hash of its image, rotation and intensity: 16 hexadecimal digits.
    pub fn fingerprint(&self) -> String {
        let mut hash = Hash(blake3::Hasher::new());
        hash.environment(self);
        hash.0.finalize().to_hex()[..16].to_owned()
    }
}

/// Lengths stand before what has them, so that no two scenes give the same bytes.
struct Hash(blake3::Hasher);

impl Hash {
    fn words<T: bytemuck::NoUninit>(&mut self, values: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(values);
        self.0.update(&(bytes.len() as u64).to_le_bytes()).update(bytes);
    }

    fn environment(&mut self, environment: &Environment) {
        self.text(&(environment.rotation, environment.intensity));
        self.text(&(environment.image.width, environment.image.height));
        self.words(&environment.image.texels);
    }

    /// `Debug` writes floats exactly.
    fn text(&mut self, value: &dyn std::fmt::Debug) {
        self.words(format!("{value:?}").as_bytes());
    }
}

#[cfg(test)]
mod tests {
    use crate::builtin;

    #[test]
    fn every_part_counts() {
        let scene = builtin("cornell").unwrap();
        let print = scene.fingerprint();
        assert_eq!(print, builtin("cornell").unwrap().fingerprint());
        assert_eq!(print.len(), 32);
        let changes: [fn(&mut crate::Scene); 7] = [
            |s| s.materials[0].roughness += 1e-6,
            |s| s.meshes[0].positions[0].x += 1e-6,
            |s| s.instances[0].world_from_object.translation.y += 1.0,
            |s| s.environment.intensity = 2.0,
            |s| {
                s.portals
                    .push(crate::Portal { corner: glam::Vec3::ZERO, edges: [glam::Vec3::X, glam::Vec3::Y] })
            },
            |s| s.meshes[0].triangle_materials[0] += 1,
            |s| s.effects = builtin("effects").unwrap().effects,
        ];
        for change in changes {
            let mut other = scene.clone();
            change(&mut other);
            assert_ne!(print, other.fingerprint());
        }
    }

    #[test]
    fn the_low_byte_of_16_bits_counts() {
        let print = |low: u16| {
            let texels = vec![0x1200 | low; 4];
            let texture = crate::Texture::rgba16("wide", [1, 1], crate::TextureUsage::Data, texels);
            crate::Scene { textures: vec![texture], ..crate::Scene::default() }.fingerprint()
        };
        assert_ne!(print(1), print(2));
    }
}
