use crate::Scene;

impl Scene {
    /// Hash of everything that an image of the scene depends on, cameras excepted, where its instances are now: 32 hexadecimal
    /// digits. Scenes with different content have different fingerprints; a file moved or renamed keeps its own.
    pub fn fingerprint(&self) -> String {
        let mut hash = blake3::Hasher::new();
        // Lengths stand before what has them, so that no two scenes give the same bytes. `Debug` writes floats exactly.
        let mut text = |value: &dyn std::fmt::Debug| {
            let text = format!("{value:?}");
            hash.update(&(text.len() as u64).to_le_bytes()).update(text.as_bytes());
        };
        self.materials.iter().for_each(|material| text(material));
        self.instances.iter().for_each(|i| text(&(i.mesh, i.world_from_object, i.world_from_object_prev)));
        self.lights.iter().for_each(|light| text(light));
        let environment = &self.environment;
        text(&(environment.rotation, environment.intensity, environment.image.width, environment.image.height));
        for texture in &self.textures {
            text(&(texture.width, texture.height, texture.srgb, texture.sampler));
            hash.update(&texture.texels);
        }
        let mut words = |bytes: &[u8]| {
            hash.update(&(bytes.len() as u64).to_le_bytes()).update(bytes);
        };
        words(bytemuck::cast_slice(&environment.image.texels));
        for mesh in &self.meshes {
            words(bytemuck::cast_slice(&mesh.positions));
            words(bytemuck::cast_slice(&mesh.normals));
            words(bytemuck::cast_slice(&mesh.tangents));
            words(bytemuck::cast_slice(&mesh.uv0));
            words(bytemuck::cast_slice(&mesh.uv1));
            words(bytemuck::cast_slice(&mesh.colors));
            words(bytemuck::cast_slice(&mesh.indices));
            words(bytemuck::cast_slice(&mesh.triangle_materials));
        }
        hash.finalize().to_hex()[..32].to_owned()
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
        let changes: [fn(&mut crate::Scene); 5] = [
            |s| s.materials[0].roughness += 1e-6,
            |s| s.meshes[0].positions[0].x += 1e-6,
            |s| s.instances[0].world_from_object.translation.y += 1.0,
            |s| s.environment.intensity = 2.0,
            |s| s.meshes[0].triangle_materials[0] += 1,
        ];
        for change in changes {
            let mut other = scene.clone();
            change(&mut other);
            assert_ne!(print, other.fingerprint());
        }
    }
}
