//! glTF 2.0 into [`Scene`]. The `gltf` crate parses the JSON into typed structs; everything that follows an index or
//! reads bytes is checked here, because the crate's own accessors panic on files that break the format.

mod accessor;
mod document;
mod images;
mod material_extensions;
mod materials;
mod meshes;
mod nodes;
mod textures;

use std::path::{Path, PathBuf};

pub use textures::MAX_TEXTURE_SIDE;

use crate::{Environment, Scene, SceneError, builtin, default_sky, default_sun};
use document::Document;
use pt_core::phases::Phases;

/// The glTF extensions that are honoured. A file that requires another is refused; one that merely uses another is
/// loaded without it, with a notice.
pub const SUPPORTED_EXTENSIONS: &[&str] = &[
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "MSFT_texture_dds",
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
    /// Folder of textures baked by [`crate::bake`]; images that it does not hold are decoded.
    pub baked: Option<PathBuf>,
    /// Most texels that all images of the scene may have together, at their finest level (four bytes each when they
    /// are not compressed). More is an error; nothing beyond is decoded.
    pub max_texture_pixels: u64,
}

/// [`LoadOptions::max_texture_pixels`] unless it is set: 2 GiB of texels without compression.
pub const DEFAULT_MAX_TEXTURE_PIXELS: u64 = 1 << 29;

impl Default for LoadOptions {
    fn default() -> Self {
        Self {
            environment: None,
            environment_rotation: 0.0,
            environment_intensity: 1.0,
            default_sky: true,
            baked: None,
            max_texture_pixels: DEFAULT_MAX_TEXTURE_PIXELS,
        }
    }
}

/// Loads a scene by the name of a built-in one or, failing that, from a glTF file.
pub fn open(name_or_path: &str, options: &LoadOptions) -> Result<Scene, SceneError> {
    match builtin(name_or_path) {
        Some(scene) => finish(scene, options),
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
///
/// Left for later, with a notice: animation, skins (shown in their bind pose), morph targets (shown undeformed).
pub fn load(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Scene, SceneError> {
    let path = path.as_ref();
    let mut phases = Phases::start();
    let document = Document::read(path)?;
    phases.mark("read and parse");
    let mut scene = Scene {
        name: path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default(),
        ..Scene::default()
    };
    note_unsupported(&document, &mut scene.notices);
    materials::read(&document, options, &mut scene)?;
    phases.mark("textures: read and decode");
    let meshes = meshes::read(&document, &mut scene)?;
    nodes::read(&document, &meshes, &mut scene)?;
    phases.mark("geometry");
    let mut scene = finish(scene, options).map_err(|error| match error {
        SceneError::Inconsistent { what, .. } => SceneError::file(path, what),
        other => other,
    })?;
    phases.mark("environment and checks");
    scene.load_phases = phases.list().to_vec();
    Ok(scene)
}

/// The images of a scene file as its materials use them, for [`crate::bake`].
pub(crate) struct Images<'a>(textures::Uses<'a>);

/// Reads a scene's materials and hands over their images.
pub(crate) fn with_images<R>(
    path: &Path,
    work: impl FnOnce(&Images<'_>) -> Result<R, SceneError>,
) -> Result<R, SceneError> {
    let document = Document::read(path)?;
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

    /// Size from the file's header, which must not exceed the limit, and what the image is used for.
    pub fn header(
        &self,
        index: usize,
        label: &str,
        bytes: &[u8],
        max_texels: u64,
    ) -> Result<([u32; 2], crate::TextureUsage), SceneError> {
        let u = self.0.in_order[index];
        let header = images::Header::read(bytes).map_err(|what| self.0.invalid(u, label, what))?;
        if header.texel_count() > max_texels {
            let what = format!(
                "{}x{} texels are more than the limit of {max_texels}; see --max-texture-pixels",
                header.width, header.height
            );
            return Err(self.0.invalid(u, label, what));
        }
        Ok(([header.width, header.height], u.usage))
    }

    /// The decoded texture.
    pub fn decode(&self, index: usize, label: &str, bytes: &[u8]) -> Result<crate::Texture, SceneError> {
        let u = self.0.in_order[index];
        let invalid = |what: String| self.0.invalid(u, label, what);
        let header = images::Header::read(bytes).map_err(invalid)?;
        let mut texture = self.0.texture(u, label.to_owned(), [header.width, header.height]);
        texture.texels = header.decode(u.usage).map_err(invalid)?;
        Ok(texture)
    }
}

fn note_unsupported(document: &Document, notices: &mut Vec<String>) {
    let root = &document.root;
    for name in root.extensions_used.iter().filter(|name| !SUPPORTED_EXTENSIONS.contains(&name.as_str())) {
        notices.push(format!("extension {name} is ignored"));
    }
    if !root.animations.is_empty() {
        notices.push(format!("{} animation(s) ignored; nodes rest", root.animations.len()));
    }
    if !root.skins.is_empty() {
        notices.push(format!("{} skin(s) ignored; meshes keep their bind pose", root.skins.len()));
    }
    if root.meshes.iter().flat_map(|mesh| &mesh.primitives).any(|primitive| primitive.targets.is_some()) {
        notices.push("morph targets ignored; meshes are undeformed".into());
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
    scene.validate()?;
    Ok(scene)
}
