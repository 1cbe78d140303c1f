use glam::{Vec3, Vec4};
use gltf::json::material::{self, AlphaMode as JsonAlpha};
use gltf::json::validation::Checked;

use crate::baked_folder::BakedFolder;
use crate::document::Document;
use crate::material_extensions;
use crate::material_extras::{self, View};
use crate::options::LoadOptions;
use crate::specular_glossiness;
use crate::textures::Uses;
use pt_scene::{AlphaMode, Material, MaterialKind, Scene, SceneError, TextureUsage};

/// Fills materials (one per glTF material, then the default material) and the textures that they use. Returns the images of the
/// textures, and the materials that show the views of cameras.
pub(crate) fn read(
    document: &Document,
    options: &LoadOptions,
    scene: &mut Scene,
) -> Result<(Vec<usize>, Vec<View>), SceneError> {
    let (materials, mut uses, views) = collect(document)?;
    scene.materials = materials;
    let baked = options.baked.as_deref().map(BakedFolder::open).transpose()?;
    scene.textures = uses.load(baked.as_ref(), options.max_texture_pixels)?;
    scene.notices.append(&mut uses.notices);
    if uses.occlusion {
        scene
            .notices
            .push("occlusion textures are ignored: traced light is occluded by the geometry itself".into());
    }
    if scene.materials.iter().filter_map(|m| m.lobes.as_ref()).any(|lobes| lobes.dispersion > 0.0) {
        scene.notices.push("dispersion: the real-time frame bends all colours alike".into());
    }
    Ok((uses.in_order.iter().map(|u| u.image).collect(), views))
}

/// The materials, the images that they use, and those materials that show the views of cameras.
pub(crate) fn collect(document: &Document) -> Result<(Vec<Material>, Uses<'_>, Vec<View>), SceneError> {
    let (mut uses, mut views) = (Uses::new(document), Vec::new());
    let mut materials = Vec::with_capacity(document.root.materials.len() + 1);
    for (i, m) in document.root.materials.iter().enumerate() {
        let at = format!("materials[{i}]");
        let extras = material_extras::read(document, m, &at)?;
        let material = material(&mut uses, m, extras.kind, &at)?;
        materials.push(extras.apply(material, i, &mut views));
    }
    materials.push(Material { name: "default".into(), ..Material::default() });
    Ok((materials, uses, views))
}

/// The material as the file has it. `kind`: what it becomes, which decides on the use of its texture.
fn material(
    uses: &mut Uses<'_>,
    m: &material::Material,
    kind: Option<MaterialKind>,
    at: &str,
) -> Result<Material, SceneError> {
    let pbr = &m.pbr_metallic_roughness;
    let alpha_mode = match m.alpha_mode {
        Checked::Valid(JsonAlpha::Opaque) => AlphaMode::Opaque,
        Checked::Valid(JsonAlpha::Mask) => AlphaMode::Mask { cutoff: m.alpha_cutoff.map_or(0.5, |c| c.0) },
        Checked::Valid(JsonAlpha::Blend) => AlphaMode::Blend,
        Checked::Invalid => return Err(uses.document.invalid(format!("{at}.alphaMode"), "unknown mode")),
    };
    let (color, data) = (TextureUsage::Color, TextureUsage::Data);
    let becomes =
        Material { alpha_mode, ..Material::default() }.with_kind(kind.unwrap_or(MaterialKind::Regular));
    let base_color = if becomes.is_masked() { TextureUsage::Cutout } else { color };
    let surface = match specular_glossiness::read(uses, m, base_color, at)? {
        Some(surface) => surface,
        None => Material {
            base_color: Vec4::from_array(pbr.base_color_factor.0),
            base_color_texture: uses.info(&pbr.base_color_texture, base_color, at)?,
            metallic: pbr.metallic_factor.0,
            roughness: pbr.roughness_factor.0,
            metallic_roughness_texture: uses.info(&pbr.metallic_roughness_texture, data, at)?,
            ..Material::default()
        },
    };
    let (normal_texture, normal_scale) = uses.normal(&m.normal_texture, at)?;
    let mut out = Material {
        name: m.name.clone().unwrap_or_else(|| at.to_string()),
        normal_texture,
        normal_scale,
        emissive: Vec3::from_array(m.emissive_factor.0),
        emissive_texture: uses.info(&m.emissive_texture, color, at)?,
        alpha_mode,
        double_sided: m.double_sided,
        ..surface
    };
    uses.occlusion |= m.occlusion_texture.is_some();
    if let Some(extensions) = &m.extensions {
        material_extensions::apply(uses, &mut out, extensions, at)?;
    }
    Ok(out)
}
