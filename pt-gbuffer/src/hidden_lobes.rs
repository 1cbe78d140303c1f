//! Lobes that mirrors and glass lose in the frame.

use crate::GbufferParams;
use glam::Vec3;
use pt_scene::{Material, Scene, one_line};
use std::collections::BTreeSet;

/// Metalness from which a smooth metal is a mirror, as in reflect_refract.trace.
const MIRROR_METALLIC: f32 = 0.99;
/// Lobes that [`crate::ReflectRefract`] leaves out, as [`pt_scene::Lobes::present`] calls them.
const LEFT_OUT: [&str; 3] = ["clearcoat", "sheen", "iridescence"];
/// What bounce rays leave out too.
const DISPERSION: &str = "dispersion";
/// Most materials that the notice names.
const MOST_NAMED: usize = 4;

/// A notice about the materials of the scene that [`crate::ReflectRefract`] replaces by what they show, without the lobes that they have besides;
/// `None` when there are none.
///
/// A texture can only lower roughness and metalness: a material counts whose factors alone make it a mirror or glass.
pub fn hidden_lobes(scene: &Scene, params: &GbufferParams) -> Option<String> {
    let mut hidden: Vec<_> = scene
        .materials
        .iter()
        .enumerate()
        .filter_map(|(index, material)| Some((index, material, left_out(material, params)?)))
        .collect();
    if hidden.is_empty() {
        return None;
    }
    let placed = placed_materials(scene);
    hidden.retain(|(index, ..)| placed.contains(&(*index as u32)));
    let named =
        hidden.iter().take(MOST_NAMED).map(|(_, material, lobes)| format!("{} ({lobes})", material.name));
    let more = hidden.len().saturating_sub(MOST_NAMED);
    let names = named.chain((more > 0).then(|| format!("{more} more"))).collect::<Vec<_>>().join(", ");
    let what = "the real-time frame shows reflection and refraction of mirrors and glass without these lobes; pt reference has them";
    (!hidden.is_empty()).then(|| one_line(&format!("{names}: {what}")))
}

fn is_replaced(material: &Material, params: &GbufferParams) -> bool {
    if params.reflect_refract == 0 || material.unlit {
        return false;
    }
    let is_black = material.base_color.truncate() == Vec3::ZERO && material.transmission == 0.0;
    let is_coat = is_black && material.specular > 0.0;
    let is_metal = material.metallic >= MIRROR_METALLIC && material.metallic_roughness_texture.is_none();
    if is_metal || is_coat {
        return material.roughness < params.mirror_roughness;
    }
    material.transmission > 0.0 && material.roughness <= params.glass_roughness
}

/// The names of the lobes that are not shown.
fn left_out(material: &Material, params: &GbufferParams) -> Option<String> {
    let lobes = material.lobes.as_ref()?;
    let replaced = is_replaced(material, params);
    let is_left_out = |name: &&str| match *name {
        // Colours part nowhere in the frame, neither in the G-buffer nor in bounce rays.
        DISPERSION => material.is_solid() && !material.unlit,
        name => replaced && LEFT_OUT.contains(&name),
    };
    let names: Vec<_> = lobes.present().filter(is_left_out).collect();
    (!names.is_empty()).then(|| names.join(", "))
}

/// Indices of the materials of all triangles that are placed in the scene.
fn placed_materials(scene: &Scene) -> BTreeSet<u32> {
    let mut placed = BTreeSet::new();
    let mut meshes = BTreeSet::new();
    for instance in &scene.instances {
        match instance.material {
            Some(material) => {
                placed.insert(material);
            }
            None if meshes.insert(instance.mesh) => {
                placed.extend(&scene.meshes[instance.mesh as usize].triangle_materials);
            }
            None => {}
        }
    }
    placed
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Affine3A;
    use pt_scene::{Instance, Lobes, Mesh};

    fn with(material: Material, lobes: Lobes) -> Material {
        Material { lobes: Some(Box::new(lobes)), ..material }
    }

    fn coated(material: Material) -> Material {
        with(material, Lobes { clearcoat: 1.0, ..Lobes::default() })
    }

    /// A triangle of each material, the last of which is not placed.
    fn scene(materials: Vec<Material>) -> Scene {
        let mut scene = Scene::default();
        for material in 0..materials.len() as u32 {
            scene.meshes.push(Mesh { triangle_materials: vec![material], ..Mesh::default() });
            scene.instances.push(Instance::new("", material, Affine3A::IDENTITY));
        }
        scene.instances.pop();
        scene.materials = materials;
        scene
    }

    fn mirror(name: &str) -> Material {
        Material::metal(name, Vec3::ONE, 0.0)
    }

    #[test]
    fn mirrors_and_glass_with_other_lobes_are_named() {
        let params = GbufferParams::default();
        let film = Lobes { iridescence: 1.0, sheen_color: Vec3::ONE, ..Lobes::default() };
        let unlit = Material { unlit: true, ..coated(mirror("unlit")) };
        let anisotropic = with(mirror("brushed"), Lobes { anisotropy_strength: 1.0, ..Lobes::default() });
        let materials = vec![
            coated(mirror("car")),
            coated(Material::metal("rough", Vec3::ONE, 0.3)),
            Material::solid("plain glass", 1.5),
            with(Material::solid("soap\nbubble", 1.3), film.clone()),
            coated(Material::diffuse("wood", Vec3::ONE)),
            anisotropic,
            unlit,
            coated(Material { roughness: 0.0, ..Material::diffuse("lacquer", Vec3::ZERO) }),
            coated(mirror("not placed")),
        ];
        let notice = hidden_lobes(&scene(materials.clone()), &params).unwrap();
        let names = notice.split(": ").next().unwrap();
        assert_eq!(names, "car (clearcoat), soap bubble (sheen, iridescence), lacquer (clearcoat)");
        assert!(notice.contains("real-time frame") && !notice.contains('\n'), "{notice}");

        // Colours do not part in bounce rays either.
        let prism = with(Material::solid("prism", 1.5), Lobes { dispersion: 2.0, ..Lobes::default() });
        for reflect_refract in [0, 2] {
            let params = GbufferParams { reflect_refract, ..params.clone() };
            let notice = hidden_lobes(&scene(vec![prism.clone(), mirror("last")]), &params).unwrap();
            assert!(notice.starts_with("prism (dispersion): "), "{notice}");
        }

        // Regular surfaces show all lobes.
        let regular = GbufferParams { reflect_refract: 0, ..params.clone() };
        assert_eq!(hidden_lobes(&scene(materials.clone()), &regular), None);
        let rough = GbufferParams { mirror_roughness: 0.0, glass_roughness: 0.0, ..params.clone() };
        let notice = hidden_lobes(&scene(materials), &rough).unwrap();
        assert!(notice.starts_with("soap"), "smooth glass is glass: {notice}");
        assert_eq!(hidden_lobes(&scene(vec![mirror("plain"), mirror("last")]), &params), None);
    }

    #[test]
    fn the_notice_stays_short() {
        let materials = (0..8).map(|i| coated(mirror(&format!("m{i}")))).collect();
        let notice = hidden_lobes(&scene(materials), &GbufferParams::default()).unwrap();
        assert!(notice.contains("m3 (clearcoat), 3 more: "), "{notice}");
    }
}
