//! glTF 2.0 into [`Scene`]. The `gltf` crate parses the JSON into typed structs; everything that follows an index or
//! reads bytes is checked here, because the crate's own accessors panic on files that break the format.

mod accessor;
mod animation;
mod check;
mod compression;
mod document;
mod extensions;
mod glb;
mod images;
mod material_extensions;
mod materials;
mod meshes;
mod nodes;
mod notices;
mod tangents;
mod textures;
mod uri;

use std::path::{Path, PathBuf};

pub use extensions::{EXTENSIONS, ExtensionUse, Support, support};
pub use textures::MAX_TEXTURE_SIDE;

use crate::validate::{Flaw, Part};
use crate::{
    AnimationChoice, Environment, Scene, SceneError, Texture, TextureUsage, builtin, default_sky, default_sun,
};
use document::Document;
use nodes::Origins;
use notices::Notices;
use pt_core::phases::Phases;

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
    /// Which of a file's scenes, by name or by index from 0; `None`: its default one.
    pub scene: Option<String>,
    /// Which of a file's material variants (KHR_materials_variants), by name or by index from 0; `None`: no variant.
    pub variant: Option<String>,
    /// Most bytes of geometry (vertices, triangles, copies of instances) that a file may ask for: a small file can name
    /// the same data any number of times.
    pub max_geometry_bytes: u64,
    /// Folder of textures baked by [`crate::bake`]; images that it does not hold are decoded.
    pub baked: Option<PathBuf>,
    /// Most texels that all images of the scene may have together, at their finest level (four bytes each when they
    /// are not compressed). More is an error; nothing beyond is decoded.
    pub max_texture_pixels: u64,
}

/// [`LoadOptions::max_texture_pixels`] unless it is set: 2 GiB of texels without compression.
pub const DEFAULT_MAX_TEXTURE_PIXELS: u64 = 1 << 29;

/// [`LoadOptions::max_geometry_bytes`] unless it is set: 16 GiB.
pub const DEFAULT_MAX_GEOMETRY_BYTES: u64 = 16 << 30;

impl Default for LoadOptions {
    fn default() -> Self {
        Self {
            environment: None,
            environment_rotation: 0.0,
            environment_intensity: 1.0,
            default_sky: true,
            animation: AnimationChoice::default(),
            time: 0.0,
            scene: None,
            variant: None,
            max_geometry_bytes: DEFAULT_MAX_GEOMETRY_BYTES,
            baked: None,
            max_texture_pixels: DEFAULT_MAX_TEXTURE_PIXELS,
        }
    }
}

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
            let names: Vec<_> = crate::BUILTIN.iter().map(|(name, _)| *name).collect();
            let what = format!("neither a file nor a built-in scene ({})", names.join(", "));
            Err(SceneError::file(Path::new(name_or_path), what))
        }
    }
}

/// Loads a scene of a `.gltf` or `.glb` file (told apart by content) with its buffers and images, which may be embedded,
/// or files in the folder of the scene or below.
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
    let images = materials::read(document, options, &mut scene)?;
    phases.mark("textures: read and decode");
    let meshes = meshes::read(document, &mut scene, variant, &mut notices)?;
    let rig = animation::read_rig(document, &options.animation, &mut scene, &mut notices)?;
    let origins = nodes::read(document, &meshes, rig.as_ref(), options, &mut scene, &mut notices)?;
    animation::attach(document, rig, &mut scene)?;
    if scene.instances.is_empty() {
        notices.add("scenes", "no triangle is placed in the scene");
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
    }
}

/// The index of a name or, failing that, the number that the text is. The error says what there is to choose from.
fn named(wanted: &str, names: &[String]) -> Result<usize, String> {
    let by_name = names.iter().position(|name| name == wanted);
    let by_number = || wanted.parse().ok().filter(|&i: &usize| i < names.len());
    by_name.or_else(by_number).ok_or_else(|| match names {
        [] => format!("{wanted:?}; the file has none"),
        _ => {
            format!("{wanted:?}; there are {}, by index from 0 or by name: {}", names.len(), names.join(", "))
        }
    })
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

/// The images of a scene file as its materials use them, for [`crate::bake`].
pub(crate) struct Images<'a>(textures::Uses<'a>);

/// Reads a scene's materials and hands over their images.
pub(crate) fn with_images<R>(
    path: &Path,
    work: impl FnOnce(&Images<'_>) -> Result<R, SceneError>,
) -> Result<R, SceneError> {
    let document = Document::read(path, &LoadOptions::default(), &mut Notices::default())?;
    let (_, uses) = materials::collect(&document)?;
    work(&Images(uses))
}

impl Images<'_> {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.0.in_order.len()
    }

    /// Label and content of the image file.
    pub fn file(&self, index: usize) -> Result<(String, Vec<u8>), SceneError> {
        self.0.file(self.0.in_order[index])
    }

    /// What an image is used for.
    pub fn usage(&self, index: usize) -> TextureUsage {
        self.0.in_order[index].usage
    }

    /// An error in an image.
    pub fn invalid(&self, index: usize, label: &str, what: String) -> SceneError {
        self.0.invalid(self.0.in_order[index], label, what)
    }
}

/// The size of an image file, from its header.
///
/// # Errors
/// No image file, or more texels than `max_texels`.
pub(crate) fn image_size(bytes: &[u8], max_texels: u64) -> Result<[u32; 2], String> {
    let header = images::Header::read(bytes)?;
    header.check(max_texels)?;
    Ok([header.width, header.height])
}

impl Texture {
    /// A texture from the content of an image file: PNG, JPEG, WebP, DDS or KTX2, told apart by the first bytes.
    ///
    /// # Errors
    /// What is wrong, in one line without the file's name. An image of more than `max_texels` texels is refused before
    /// it is decoded.
    pub fn from_bytes(
        name: &str,
        bytes: &[u8],
        usage: TextureUsage,
        max_texels: u64,
    ) -> Result<Self, String> {
        let header = images::Header::read(bytes)?;
        header.check(max_texels)?;
        let size = [header.width, header.height];
        Ok(Self { texels: header.decode(usage)?, ..Self::rgba8(name, size, usage, Vec::new()) })
    }
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

/// What every scene goes through: the environment asked for, light where there is none, the invariants.
fn finish(
    mut scene: Scene,
    options: &LoadOptions,
    refusal: impl Fn(&Scene, Flaw) -> SceneError,
) -> Result<Scene, SceneError> {
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
    match scene.check() {
        Ok(()) => Ok(scene),
        Err(flaw) => Err(refusal(&scene, flaw)),
    }
}
