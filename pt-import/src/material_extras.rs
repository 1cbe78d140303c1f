//! What a material's `extras` may ask for: its kind (`pt_kind`), the camera whose view it shows (`pt_camera`), its waves (`pt_wave_slope`,
//! `pt_wave_length`).

use gltf::json::material::Material as JsonMaterial;
use pt_core::settings::close_to;
use pt_scene::{Camera, Material, MaterialKind, Scene, SceneError, Shows, Waves};
use pt_shaders::NamedEnum;
use serde::Deserialize;

use crate::document::Document;

/// The extras of a material that mean something here.
#[derive(Default)]
pub(crate) struct Extras {
    pub kind: Option<MaterialKind>,
    camera: Option<CameraChoice>,
    wave_slope: Option<f32>,
    wave_length: Option<f32>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
enum CameraChoice {
    Index(usize),
    Name(String),
}

/// A material that shows the view of a camera, which is looked up when the nodes have placed the cameras.
pub(crate) struct View {
    material: usize,
    choice: CameraChoice,
}

/// Reads the extras of the material at the JSON path `at`.
pub(crate) fn read(document: &Document, material: &JsonMaterial, at: &str) -> Result<Extras, SceneError> {
    // Other programs put whatever they like there.
    let object = material.extras.as_ref().and_then(|extras| serde_json::from_str(extras.get()).ok());
    let Some(serde_json::Value::Object(object)) = object else { return Ok(Extras::default()) };
    let at = |key: &str| format!("{at}.extras.{key}");
    let kind = match object.get("pt_kind") {
        None => None,
        Some(value) => Some(kind(value).map_err(|what| document.invalid(at("pt_kind"), what))?),
    };
    let camera = match object.get("pt_camera") {
        None => None,
        Some(value) => Some(CameraChoice::deserialize(value).map_err(|_| {
            document.invalid(at("pt_camera"), "expected the name of a camera, or its index from 0")
        })?),
    };
    if kind == Some(MaterialKind::Camera) && camera.is_none() {
        let what = "the kind camera needs the camera whose view it shows: its name, or its index from 0";
        return Err(document.invalid(at("pt_camera"), what));
    }
    let number = |key: &str| match object.get(key) {
        None => Ok(None),
        Some(value) => value
            .as_f64()
            .map(|x| Some(x as f32))
            .ok_or_else(|| document.invalid(at(key), "expected a number")),
    };
    let (wave_slope, wave_length) = (number("pt_wave_slope")?, number("pt_wave_length")?);
    Ok(Extras { kind, camera, wave_slope, wave_length })
}

fn kind(value: &serde_json::Value) -> Result<MaterialKind, String> {
    let Some(name) = value.as_str() else { return Err("expected the name of a kind of material".into()) };
    MaterialKind::from_name(name)
        .map_err(|error| format!("{error}{}", close_to(name, MaterialKind::NAMES.iter().copied())))
}

impl Extras {
    /// The material that `extras` make of the one of the file, number `index`.
    pub fn apply(self, material: Material, index: usize, views: &mut Vec<View>) -> Material {
        let mut material = material.with_kind(self.kind.unwrap_or(MaterialKind::Regular));
        if let Shows::Camera(_) = material.shows {
            views.extend(self.camera.map(|choice| View { material: index, choice }));
        }
        if let Some(waves) = &mut material.waves {
            *waves = Waves {
                slope: self.wave_slope.unwrap_or(waves.slope),
                length: self.wave_length.unwrap_or(waves.length),
            };
        }
        material
    }
}

/// Gives materials the cameras that they ask for.
pub(crate) fn find_cameras(document: &Document, scene: &mut Scene, views: &[View]) -> Result<(), SceneError> {
    for View { material, choice } in views {
        let is_it = |camera: &Camera| match choice {
            CameraChoice::Index(index) => camera.index == Some(*index),
            CameraChoice::Name(name) => camera.name == *name,
        };
        let Some(found) = scene.cameras.iter().position(is_it) else {
            let (wanted, closest) = match choice {
                CameraChoice::Index(index) => (index.to_string(), String::new()),
                CameraChoice::Name(name) => {
                    (format!("{name:?}"), close_to(name, scene.cameras.iter().map(|c| c.name.as_str())))
                }
            };
            let what = format!("the scene has no camera {wanted}{closest}; it has {}", scene.cameras.len());
            return Err(document.invalid(format!("materials[{material}].extras.pt_camera"), what));
        };
        scene.materials[*material].shows = Shows::Camera(found as u32);
    }
    Ok(())
}
