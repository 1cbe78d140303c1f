//! KHR_materials_*: what the `gltf` crate knows as types, the others from their JSON.

use glam::Vec3;
use gltf::json::extensions::material::Material as Extensions;
use gltf::json::material::NormalTexture;
use gltf::json::texture::Info;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::textures::Uses;
use pt_scene::{Lobes, Material, SceneError, TextureUsage};

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Clearcoat {
    clearcoat_factor: f32,
    clearcoat_texture: Option<Info>,
    clearcoat_roughness_factor: f32,
    clearcoat_roughness_texture: Option<Info>,
    clearcoat_normal_texture: Option<NormalTexture>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Sheen {
    sheen_color_factor: [f32; 3],
    sheen_color_texture: Option<Info>,
    sheen_roughness_factor: f32,
    sheen_roughness_texture: Option<Info>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Anisotropy {
    anisotropy_strength: f32,
    anisotropy_rotation: f32,
    anisotropy_texture: Option<Info>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Iridescence {
    iridescence_factor: f32,
    iridescence_texture: Option<Info>,
    iridescence_ior: f32,
    iridescence_thickness_minimum: f32,
    iridescence_thickness_maximum: f32,
    iridescence_thickness_texture: Option<Info>,
}

#[derive(Deserialize)]
#[serde(default)]
struct Dispersion {
    dispersion: f32,
}

/// The extensions' defaults are those of [`Lobes`].
macro_rules! defaults {
    ($($name:ident { $($json:ident: $lobe:ident),*; $($texture:ident),* })*) => { $(
        impl Default for $name {
            fn default() -> Self {
                let l = Lobes::default();
                Self { $($json: l.$lobe.into(),)* $($texture: None,)* }
            }
        }
    )* };
}

defaults! {
    Clearcoat { clearcoat_factor: clearcoat, clearcoat_roughness_factor: clearcoat_roughness;
        clearcoat_texture, clearcoat_roughness_texture, clearcoat_normal_texture }
    Sheen { sheen_color_factor: sheen_color, sheen_roughness_factor: sheen_roughness;
        sheen_color_texture, sheen_roughness_texture }
    Anisotropy { anisotropy_strength: anisotropy_strength, anisotropy_rotation: anisotropy_rotation; anisotropy_texture }
    Iridescence { iridescence_factor: iridescence, iridescence_ior: iridescence_ior,
        iridescence_thickness_minimum: iridescence_thickness_min,
        iridescence_thickness_maximum: iridescence_thickness_max;
        iridescence_texture, iridescence_thickness_texture }
    Dispersion { dispersion: dispersion; }
}

/// Reads all material extensions of one material into `out`.
pub(crate) fn apply(
    uses: &mut Uses<'_>,
    out: &mut Material,
    e: &Extensions,
    at: &str,
) -> Result<(), SceneError> {
    let at = format!("{at}.extensions");
    let (color, data) = (TextureUsage::Color, TextureUsage::Data);
    out.unlit = e.unlit.is_some();
    if let Some(strength) = &e.emissive_strength {
        out.emissive *= strength.emissive_strength.0;
    }
    if let Some(ior) = &e.ior {
        // The extension's special value 0 (always total reflection) stands for an infinite index.
        out.ior = if ior.ior.0 == 0.0 { 1e6 } else { ior.ior.0 };
    }
    if let Some(transmission) = &e.transmission {
        out.transmission = transmission.transmission_factor.0;
        out.transmission_texture = uses.info(&transmission.transmission_texture, data, &at)?;
    }
    if let Some(volume) = &e.volume {
        out.thickness = volume.thickness_factor.0;
        out.thickness_texture = uses.info(&volume.thickness_texture, data, &at)?;
        out.attenuation_color = Vec3::from_array(volume.attenuation_color.0);
        let distance = volume.attenuation_distance.0;
        out.attenuation_distance = if distance == f32::MAX { f32::INFINITY } else { distance };
    }
    if let Some(specular) = &e.specular {
        out.specular = specular.specular_factor.0;
        out.specular_texture = uses.info(&specular.specular_texture, data, &at)?;
        out.specular_color = Vec3::from_array(specular.specular_color_factor.0);
        out.specular_color_texture = uses.info(&specular.specular_color_texture, color, &at)?;
    }
    let lobes = lobes(uses, e, &at)?;
    out.lobes = (lobes != Lobes::default()).then(|| Box::new(lobes));
    Ok(())
}

fn lobes(uses: &mut Uses<'_>, e: &Extensions, at: &str) -> Result<Lobes, SceneError> {
    let (color, data) = (TextureUsage::Color, TextureUsage::Data);
    let mut l = Lobes::default();
    if let Some(x) = parse::<Clearcoat>(uses, e, "KHR_materials_clearcoat", at)? {
        l.clearcoat = x.clearcoat_factor;
        l.clearcoat_texture = uses.info(&x.clearcoat_texture, data, at)?;
        l.clearcoat_roughness = x.clearcoat_roughness_factor;
        l.clearcoat_roughness_texture = uses.info(&x.clearcoat_roughness_texture, data, at)?;
        (l.clearcoat_normal_texture, l.clearcoat_normal_scale) =
            uses.normal(&x.clearcoat_normal_texture, at)?;
    }
    if let Some(x) = parse::<Sheen>(uses, e, "KHR_materials_sheen", at)? {
        l.sheen_color = x.sheen_color_factor.into();
        l.sheen_color_texture = uses.info(&x.sheen_color_texture, color, at)?;
        l.sheen_roughness = x.sheen_roughness_factor;
        l.sheen_roughness_texture = uses.info(&x.sheen_roughness_texture, color, at)?;
    }
    if let Some(x) = parse::<Anisotropy>(uses, e, "KHR_materials_anisotropy", at)? {
        l.anisotropy_strength = x.anisotropy_strength;
        l.anisotropy_rotation = x.anisotropy_rotation;
        l.anisotropy_texture = uses.info(&x.anisotropy_texture, data, at)?;
    }
    if let Some(x) = parse::<Iridescence>(uses, e, "KHR_materials_iridescence", at)? {
        l.iridescence = x.iridescence_factor;
        l.iridescence_texture = uses.info(&x.iridescence_texture, data, at)?;
        l.iridescence_ior = x.iridescence_ior;
        l.iridescence_thickness_min = x.iridescence_thickness_minimum;
        l.iridescence_thickness_max = x.iridescence_thickness_maximum;
        l.iridescence_thickness_texture = uses.info(&x.iridescence_thickness_texture, data, at)?;
    }
    if let Some(x) = parse::<Dispersion>(uses, e, "KHR_materials_dispersion", at)? {
        l.dispersion = x.dispersion;
    }
    Ok(l)
}

/// An extension of a material that the JSON crate has no type for.
pub(crate) fn parse<T: DeserializeOwned>(
    uses: &Uses<'_>,
    e: &Extensions,
    name: &str,
    at: &str,
) -> Result<Option<T>, SceneError> {
    let value = e.others.get(name).map(|value| T::deserialize(value)).transpose();
    value.map_err(|error| uses.document.invalid(format!("{at}.{name}"), error))
}
