//! Reads glTF 2.0 files, with their compressed forms, into [`Scene`]; bakes textures ahead of time.
//!
//! The `gltf` crate parses the JSON into typed structs. Everything that follows an index or reads bytes is checked here,
//! because the crate's own accessors panic on files that break the format.
//!
//! The feature `codecs` (on by default) decodes Draco, meshopt and Basis Universal and encodes baked textures. Without it
//! a file that needs one of them is refused by name. Programs of single stages are built without.
#![deny(missing_docs)]

mod accessor;
mod animation;
#[cfg(feature = "codecs")]
pub mod bake;
#[cfg_attr(
    not(feature = "codecs"),
    allow(dead_code, reason = "only the encoder of baked textures needs all of it")
)]
mod baked_folder;
pub mod bmfr;
mod check;
#[cfg(feature = "codecs")]
mod compression;
mod dds;
mod deformation;
mod document;
mod effect_extras;
mod extensions;
mod glb;
mod images;
#[cfg(feature = "codecs")]
mod ktx2;
mod material_extensions;
mod material_extras;
mod materials;
mod meshes;
mod nodes;
mod notices;
mod options;
mod reader;
#[cfg_attr(
    not(feature = "codecs"),
    allow(dead_code, reason = "only the encoder of baked textures needs all of it")
)]
mod scene_images;
mod specular_glossiness;
mod tangents;
mod textures;
mod transforms;
mod uri;

pub use baked_folder::{BakedFolder, Quality};
pub use dds::DdsTexture;
pub use extensions::{EXTENSIONS, support};
pub use options::{DEFAULT_MAX_GEOMETRY_BYTES, DEFAULT_MAX_TEXTURE_PIXELS, LoadOptions};
pub use scene_images::decode_texture;

use std::path::Path;

use document::Document;
use nodes::Origins;
use notices::Notices;
use options::named;
use pt_core::phases::Phases;
use pt_core::settings::close_to;
use pt_scene::glam::Quat;
use pt_scene::{
    AnimationChoice, BUILTIN, Environment, Flaw, LightKind, Part, PhysicalSky, Scene, SceneError, Support,
    builtin, default_sky, default_sun,
};

/// Loads a scene by the name of a built-in one or, failing that, from a glTF file.
pub fn open(name_or_path: &str, options: &LoadOptions) -> Result<Scene, SceneError> {
    match builtin(name_or_path) {
        Some(scene) if options.scene.is_some() || options.variant.is_some() => {
            let what = "a built-in scene has no further scenes or variants to choose from";
            Err(SceneError::Inconsistent { scene: scene.name, what: what.into() })
        }
        Some(scene) => match &options.animation {
            AnimationChoice::Index(_) | AnimationChoice::Name(_) => {
                let what = "a built-in scene has no animations to choose from";
                Err(SceneError::Inconsistent { scene: scene.name, what: what.into() })
            }
            _ => finish(scene, options, |scene, flaw| scene.inconsistent(&flaw)),
        },
        None if Path::new(name_or_path).exists() || Path::new(name_or_path).components().count() > 1 => {
            load(name_or_path, options)
        }
        None => {
            let names: Vec<_> = BUILTIN.iter().map(|(name, _)| *name).collect();
            let path = Path::new(name_or_path);
            let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
            let what = match path.extension() {
                Some(_) if names.contains(&stem) => {
                    format!("no such file; the built-in scene is called {stem}")
                }
                Some(_) => "no such file".into(),
                None => {
                    let hint = close_to(name_or_path, names.iter().copied());
                    format!("neither a file nor a built-in scene{hint} (there are {})", names.join(", "))
                }
            };
            Err(SceneError::file(Path::new(name_or_path), what))
        }
    }
}

/// Loads a scene of a `.gltf` or `.glb` file (told apart by content) with its buffers and images, which may be embedded,
/// or files in the folder of the scene or below; elsewhere only with [`LoadOptions::allow_outside`].
pub fn load(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Scene, SceneError> {
    let path = path.as_ref();
    let mut notices = Notices::default();
    let mut phases = Phases::start();
    let document = Document::read(path, options, &mut notices)?;
    phases.mark("read and parse");
    fill(path, &document, notices, phases, options)
}

/// Loads a scene from the bytes of a `.gltf` or `.glb` file that embeds its buffers and images: no file is opened, unless
/// the options name an environment. `name` stands for the file in messages.
pub fn load_bytes(bytes: Vec<u8>, name: &str, options: &LoadOptions) -> Result<Scene, SceneError> {
    let path = Path::new(name);
    let mut notices = Notices::default();
    let mut phases = Phases::start();
    let document = Document::parse(bytes, path, None, options, &mut notices)?;
    phases.mark("read and parse");
    fill(path, &document, notices, phases, options)
}

fn fill(
    path: &Path,
    document: &Document,
    mut notices: Notices,
    mut phases: Phases,
    options: &LoadOptions,
) -> Result<Scene, SceneError> {
    let root = &document.root;
    let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let scene_names = root.scenes.iter().enumerate();
    let mut scene = Scene {
        name,
        scenes: scene_names.map(|(i, s)| s.name.clone().unwrap_or_else(|| format!("scenes[{i}]"))).collect(),
        variants: variants(document)?,
        extensions: extensions::uses(&root.extensions_used, &root.extensions_required),
        ..Scene::default()
    };
    let variant = options.variant.as_ref().map(|wanted| named(wanted, &scene.variants)).transpose();
    let variant = variant.map_err(|what| {
        document.invalid("extensions.KHR_materials_variants", format!("no variant {what}"))
    })?;
    note_unsupported(&scene, &mut notices);
    let (images, views) = materials::read(document, options, &mut scene)?;
    phases.mark("textures: read and decode");
    let meshes = meshes::read(document, &mut scene, variant, &mut notices)?;
    let rig = animation::read_rig(document, options, &mut scene, &mut notices)?;
    let origins = nodes::read(document, &meshes, rig.as_ref(), options, &mut scene, &mut notices)?;
    animation::attach(document, rig, &mut scene)?;
    material_extras::find_cameras(document, &mut scene, &views)?;
    if scene.instances.is_empty() {
        notices.add("scenes", "no triangle is placed in the scene");
    }
    let lights = root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
    if lights.is_some_and(|lights| !lights.lights.is_empty()) && scene.lights.is_empty() {
        notices.add("extensions.KHR_lights_punctual.lights", "no light is placed in the scene");
    }
    phases.mark("geometry");
    scene.notices.splice(0..0, notices.into_lines());
    let mut scene = finish(scene, options, |scene, flaw| {
        let at = path_of(document, &origins, &images, scene, flaw.part);
        document.invalid(at, flaw.what)
    })?;
    phases.mark("environment and checks");
    scene.load_phases = phases.list().to_vec();
    Ok(scene)
}

/// JSON path of what a part of the scene was read from.
fn path_of(document: &Document, origins: &Origins, images: &[usize], scene: &Scene, part: Part) -> String {
    match part {
        Part::Mesh(mesh) => {
            let instance = scene.instances.iter().position(|i| i.mesh as usize == mesh);
            let node = instance.and_then(|i| document.root.nodes.get(origins.instances[i]));
            let mesh = node.and_then(|node| node.mesh);
            mesh.map_or("meshes".into(), |mesh| format!("meshes[{}]", mesh.value()))
        }
        Part::Instance(i) => format!("nodes[{}]", origins.instances[i]),
        Part::Material(i) => format!("materials[{i}]"),
        Part::Texture(i) => format!("images[{}]", images[i]),
        Part::Light(i) => match origins.lights.get(i) {
            Some(node) => format!("nodes[{node}].extensions.KHR_lights_punctual"),
            None => "default light".into(),
        },
        Part::Camera(i) => format!("nodes[{}].camera", origins.cameras[i]),
        Part::Environment => "environment".into(),
        Part::Effects => "effects".into(),
    }
}

/// Names of the material variants.
fn variants(document: &Document) -> Result<Vec<String>, SceneError> {
    #[derive(serde::Deserialize)]
    struct Variants {
        variants: Vec<Variant>,
    }
    #[derive(serde::Deserialize)]
    struct Variant {
        name: String,
    }
    let others = document.root.extensions.as_ref().map(|e| &e.others);
    let variants = document.extension::<Variants>(others, "KHR_materials_variants", "")?;
    Ok(variants.map_or(Vec::new(), |v| v.variants.into_iter().map(|v| v.name).collect()))
}

fn note_unsupported(scene: &Scene, notices: &mut Notices) {
    for extension in scene.extensions.iter().filter(|e| e.support == Support::Ignored) {
        notices.add("extensionsUsed", format!("extension {} is ignored", extension.name));
    }
    for (what, names) in [("scenes", &scene.scenes), ("variants", &scene.variants)] {
        if names.iter().enumerate().any(|(i, name)| names[..i].contains(name)) {
            notices.add(what, "names are not unique; a name stands for the first of its bearers");
        }
    }
}

/// The sky in place of the scene's environment, and its sun, which turns and shines with it.
fn add_sky(scene: &mut Scene, sky: &PhysicalSky, options: &LoadOptions) {
    let suns = scene.lights.iter().filter(|light| light.kind == LightKind::Directional).count();
    if suns > 0 {
        scene
            .notices
            .push(format!("directional lights of the scene itself beside the sun of the sky: {suns}"));
    }
    scene.environment = sky.environment();
    let mut sun = sky.sun();
    sun.direction = Quat::from_rotation_y(options.environment_rotation) * sun.direction;
    sun.intensity *= options.environment_intensity;
    scene.lights.push(sun);
}

/// What every scene goes through: the environment asked for, light where there is none, the invariants.
fn finish(
    mut scene: Scene,
    options: &LoadOptions,
    refusal: impl Fn(&Scene, Flaw) -> SceneError,
) -> Result<Scene, SceneError> {
    if let Some(file) = &options.environment {
        let (environment, notices) = Environment::read(file, options.bad_texels)?;
        scene.environment = environment;
        scene.notices.extend(notices);
    } else if let Some(sky) = &options.sky {
        add_sky(&mut scene, sky, options);
    } else if options.default_sky && scene.is_unlit() {
        scene.environment = default_sky();
        scene.lights.push(default_sun());
        let why = match scene.materials.iter().find(|material| material.is_emissive()) {
            Some(m) => format!("no triangle with the emissive material {} is left in the scene", m.name),
            None => "no lights in the scene".into(),
        };
        scene.notices.push(format!("{why}: default sky and sun added"));
    }
    scene.environment.rotation += options.environment_rotation;
    scene.environment.intensity *= options.environment_intensity;
    scene.limit_radiance();
    scene.set_time(options.time, options.time);
    scene.pose_meshes();
    match scene.check() {
        Ok(()) => Ok(scene),
        Err(flaw) => Err(refusal(&scene, flaw)),
    }
}
