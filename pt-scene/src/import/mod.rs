//! glTF 2.0 into [`Scene`]. The `gltf` crate parses the JSON into typed structs; everything that follows an index or
//! reads bytes is checked here, because the crate's own accessors panic on files that break the format.

mod accessor;
mod animation;
mod document;
mod materials;
mod meshes;
mod nodes;

use std::path::{Path, PathBuf};

pub use materials::MAX_TEXTURE_SIDE;

use crate::{AnimationChoice, Environment, Scene, SceneError, builtin, default_sky, default_sun};
use document::Document;

/// The glTF extensions that are honoured. A file that requires another is refused; one that merely uses another is
/// loaded without it, with a notice.
pub const SUPPORTED_EXTENSIONS: &[&str] = &[
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// What [`load`] and [`open`] do besides reading the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadOptions {
    /// Lat-long `.hdr` or `.exr` that becomes the environment, in place of the scene's own.
    pub environment: Option<PathBuf>,
    /// Turns the environment about +Y, radians; see [`Environment::rotation`]. Added to the scene's own.
    pub environment_rotation: f32,
    /// Factor on the environment, >= 0.
    pub environment_intensity: f32,
    /// Give a scene without any light [`default_sky`] and [`default_sun`].
    pub default_sky: bool,
    /// Which animations of a glTF file play.
    pub animation: AnimationChoice,
    /// Time at which the scene is shown at first, seconds; [`Scene::set_time`] goes on from there.
    pub time: f64,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self {
            environment: None,
            environment_rotation: 0.0,
            environment_intensity: 1.0,
            default_sky: true,
            animation: AnimationChoice::default(),
            time: 0.0,
        }
    }
}

/// Loads a scene by the name of a built-in one or, failing that, from a glTF file.
pub fn open(name_or_path: &str, options: &LoadOptions) -> Result<Scene, SceneError> {
    match builtin(name_or_path) {
        Some(scene) => match &options.animation {
            AnimationChoice::Index(_) | AnimationChoice::Name(_) => {
                let what = "a built-in scene has no animations to choose from";
                Err(SceneError::Inconsistent { scene: scene.name, what: what.into() })
            }
            _ => finish(scene, options),
        },
        None if Path::new(name_or_path).exists() || Path::new(name_or_path).components().count() > 1 => {
            load(name_or_path, options)
        }
        None => {
            let names: Vec<_> = crate::BUILTIN.iter().map(|(name, _)| *name).collect();
            let what = format!("neither a file nor a built-in scene ({})", names.join(", "));
            Err(SceneError::file(Path::new(name_or_path), what))
        }
    }
}

/// Loads the default scene of a `.gltf` or `.glb` file (told apart by content) with its buffers and images, which
/// may be embedded, or files in the folder of the scene or below.
pub fn load(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Scene, SceneError> {
    let path = path.as_ref();
    let document = Document::read(path)?;
    let mut scene = Scene {
        name: path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default(),
        ..Scene::default()
    };
    note_unsupported(&document, &mut scene.notices);
    materials::read(&document, &mut scene)?;
    let meshes = meshes::read(&document, &mut scene)?;
    let rig = animation::read_rig(&document, &options.animation, &mut scene)?;
    nodes::read(&document, &meshes, rig.as_ref(), &mut scene)?;
    animation::attach(&document, rig, &mut scene)?;
    finish(scene, options).map_err(|error| match error {
        SceneError::Inconsistent { what, .. } => SceneError::file(path, what),
        other => other,
    })
}

fn note_unsupported(document: &Document, notices: &mut Vec<String>) {
    let root = &document.root;
    for name in root.extensions_used.iter().filter(|name| !SUPPORTED_EXTENSIONS.contains(&name.as_str())) {
        notices.push(format!("extension {name} is ignored"));
    }
}

/// What every scene goes through: the environment asked for, light where there is none, the invariants.
fn finish(mut scene: Scene, options: &LoadOptions) -> Result<Scene, SceneError> {
    if let Some(file) = &options.environment {
        scene.environment = Environment::load(file)?;
    } else if options.default_sky && scene.is_unlit() {
        scene.environment = default_sky();
        scene.lights.push(default_sun());
        scene.notices.push("no lights in the scene: default sky and sun added".into());
    }
    scene.environment.rotation += options.environment_rotation;
    scene.environment.intensity *= options.environment_intensity;
    scene.set_time(options.time, options.time);
    scene.pose_meshes();
    scene.validate()?;
    Ok(scene)
}
