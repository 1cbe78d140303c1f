//! KHR_materials_pbrSpecularGlossiness, which Khronos has archived: the surface that older files describe in place of
//! metallic-roughness.

use glam::{Vec3, Vec4};
use gltf::json::material::Material as JsonMaterial;
use gltf::json::texture::Info;
use serde::Deserialize;

use crate::material_extensions::parse;
use crate::textures::Uses;
use pt_scene::{Material, SceneError, TextureUsage};

const NAME: &str = "KHR_materials_pbrSpecularGlossiness";

/// Reflectance at normal incidence of the index of refraction 1.5, which `specular_color` multiplies.
const DIELECTRIC_F0: f32 = 0.04;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct SpecularGlossiness {
    diffuse_factor: [f32; 4],
    diffuse_texture: Option<Info>,
    specular_factor: [f32; 3],
    glossiness_factor: f32,
    specular_glossiness_texture: Option<Info>,
}

impl Default for SpecularGlossiness {
    fn default() -> Self {
        Self {
            diffuse_factor: [1.0; 4],
            diffuse_texture: None,
            specular_factor: [1.0; 3],
            glossiness_factor: 1.0,
            specular_glossiness_texture: None,
        }
    }
}

/// The surface that the extension gives a material; `None` for a material without it.
///
/// It becomes a dielectric of index of refraction 1.5 with a specular colour, as KHR_materials_specular describes it.
///
/// Exact: the diffuse colour and alpha with their texture (base colour, metallic 0); the reflectance at normal incidence, the
/// specular colour with its texture (`specular_color` is specular / 0.04, the reflectance of the index 1.5) and at grazing incidence,
/// 1; the roughness of a material without texture, 1 - glossiness.
///
/// Approximated: the roughness of a texture, 1 - glossinessFactor x A, is rounded to 8 bits. The diffuse light is weighted by
/// 1 - max(F) of each direction, as everywhere in glTF 2.0; the extension weights it by 1 - max(specular) besides.
pub(crate) fn read(
    uses: &mut Uses<'_>,
    material: &JsonMaterial,
    base_color: TextureUsage,
    at: &str,
) -> Result<Option<Material>, SceneError> {
    let Some(extensions) = &material.extensions else { return Ok(None) };
    let at = format!("{at}.extensions");
    let Some(x) = parse::<SpecularGlossiness>(uses, extensions, NAME, &at)? else { return Ok(None) };
    let at = format!("{at}.{NAME}");
    if !(0.0..=1.0).contains(&x.glossiness_factor) {
        let what = format!("{} is not in 0..1", x.glossiness_factor);
        return Err(uses.document.invalid(format!("{at}.glossinessFactor"), what));
    }
    let metallic_roughness_texture =
        uses.roughness(&x.specular_glossiness_texture, x.glossiness_factor, &at)?;
    Ok(Some(Material {
        base_color: Vec4::from_array(x.diffuse_factor),
        base_color_texture: uses.info(&x.diffuse_texture, base_color, &at)?,
        metallic: 0.0,
        roughness: if metallic_roughness_texture.is_some() { 1.0 } else { 1.0 - x.glossiness_factor },
        metallic_roughness_texture,
        specular_color: Vec3::from_array(x.specular_factor) / DIELECTRIC_F0,
        specular_color_texture: uses.info(&x.specular_glossiness_texture, TextureUsage::Color, &at)?,
        ..Material::default()
    }))
}
