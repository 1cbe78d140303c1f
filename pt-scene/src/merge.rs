use glam::{Affine3A, Vec3, Vec3A, Vec4};

use crate::{Instance, Material, Mesh, Scene};

impl Scene {
    /// Puts everything that stands still into one mesh in world space, called `name`: a static world, whose one BVH has no
    /// overlapping parts. Instances that move, and those that transmit light (shadow rays pass them by as a whole), stay.
    /// Meshes that no instance uses any more are dropped. Triangles are stored once per instance afterwards.
    pub fn merge_static(&mut self, name: &str) {
        let stays = |i: &Instance| {
            let mesh = &self.meshes[i.mesh as usize];
            !i.is_static(mesh) || i.transmits(mesh, &self.materials)
        };
        let (kept, merged): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.instances).into_iter().partition(stays);
        let mut world = Mesh { name: name.into(), ..Mesh::default() };
        let mut masked = Vec::new();
        for instance in &merged {
            append(&mut world, &mut masked, &self.meshes[instance.mesh as usize], instance);
        }
        world.first_masked = world.indices.len();
        for (index, material) in masked {
            world.indices.push(index);
            world.triangle_materials.push(material);
        }
        let mut meshes = std::mem::take(&mut self.meshes).into_iter().map(Some).collect::<Vec<_>>();
        let mut renamed = vec![None; meshes.len()];
        if !merged.is_empty() {
            self.meshes.push(world);
            self.instances.push(Instance::new(name, 0, Affine3A::IDENTITY));
        }
        for mut instance in kept {
            let old = instance.mesh as usize;
            if let Some(mesh) = meshes[old].take() {
                renamed[old] = Some(self.meshes.len() as u32);
                self.meshes.push(mesh);
            }
            instance.mesh = renamed[old].unwrap_or_default();
            self.instances.push(instance);
        }
    }
}

impl Mesh {
    /// Whether light passes through all of it (KHR_materials_transmission).
    pub fn transmits(&self, materials: &[Material]) -> bool {
        let mut used = self.triangle_materials.iter();
        !self.triangle_materials.is_empty() && used.all(|&m| materials[m as usize].transmits())
    }
}

/// Adds a mesh where its instance puts it; its masked triangles go to `masked`, to stand behind all others.
fn append(world: &mut Mesh, masked: &mut Vec<([u32; 3], u32)>, mesh: &Mesh, instance: &Instance) {
    let world_from_object = &instance.world_from_object;
    let first = world.positions.len() as u32;
    let linear = world_from_object.matrix3;
    let normals = linear.inverse().transpose();
    let mirrored = linear.determinant() < 0.0;
    let direction = |matrix: glam::Mat3A, v: Vec3| Vec3::from((matrix * Vec3A::from(v)).normalize_or_zero());
    world.positions.extend(mesh.positions.iter().map(|&p| world_from_object.transform_point3(p)));
    world.normals.extend(mesh.normals.iter().map(|&n| direction(normals, n)));
    // A mirrored frame has its bitangent on the other side of cross(normal, tangent).
    let sign = if mirrored { -1.0 } else { 1.0 };
    let tangent = |t: &Vec4| direction(linear, t.truncate()).extend(t.w * sign);
    world.tangents.extend(mesh.tangents.iter().map(tangent));
    world.uv0.extend(&mesh.uv0);
    world.uv1.extend(&mesh.uv1);
    world.colors.extend(&mesh.colors);
    for (i, index) in mesh.indices.iter().enumerate() {
        let material = instance.material_at(mesh, i);
        let [a, b, c] = index.map(|v| v + first);
        // The front face stays the front face.
        let index = if mirrored { [a, c, b] } else { [a, b, c] };
        if i < mesh.first_masked {
            world.indices.push(index);
            world.triangle_materials.push(material);
        } else {
            masked.push((index, material));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn merging_changes_no_triangle_in_space() {
        let before = crate::builtin("gallery").unwrap_or_else(|| panic!("the gallery is built in"));
        let mut after = before.clone();
        // What moves and what transmits is left; here everything else is one mesh already, so mirror and merge again.
        after.instances[0].world_from_object = Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0));
        let mirrored = after.clone();
        after.merge_static("world");
        after.validate().unwrap();
        let area = |scene: &Scene| -> f64 {
            let instance = &scene.instances[0];
            let mesh = &scene.meshes[instance.mesh as usize];
            let at = |v: u32| instance.world_from_object.transform_point3(mesh.positions[v as usize]);
            mesh.indices
                .iter()
                .map(|&[a, b, c]| f64::from((at(b) - at(a)).cross(at(c) - at(a)).length()))
                .sum()
        };
        assert!((area(&after) / area(&mirrored) - 1.0).abs() < 1e-5);
        // Front faces: geometric and shading normals keep their agreement when the winding follows the mirror.
        let mesh = &after.meshes[0];
        let agree = |&[a, b, c]: &[u32; 3]| {
            let [p, q, r] = [a, b, c].map(|v| mesh.positions[v as usize]);
            (q - p).cross(r - p).dot(mesh.normals[a as usize]) >= -1e-9
        };
        let share =
            mesh.indices.iter().filter(|index| agree(index)).count() as f64 / mesh.indices.len() as f64;
        assert!(share > 0.99, "only {share} of the triangles face the way their normals do");
        assert_eq!(after.statistics().instanced_triangles, mirrored.statistics().instanced_triangles);
        assert_eq!(after.statistics().masked_triangles, mirrored.statistics().masked_triangles);
    }
}
