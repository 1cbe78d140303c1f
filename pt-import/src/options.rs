//! Options of the importer.

use std::path::PathBuf;

use pt_scene::{AnimationChoice, AnimationEnd, BadTexels, PhysicalSky};

/// Options of [`crate::load`] and [`crate::open`].
#[derive(Clone, Debug, PartialEq)]
pub struct LoadOptions {
    /// Lat-long `.hdr` or `.exr` that becomes the environment, in place of the scene's own.
    pub environment: Option<PathBuf>,
    /// A physical sky that becomes the environment if there is no file, with its sun beside the scene's own lights. Rotation and intensity
    /// are those of the environment, also for the sun.
    pub sky: Option<PhysicalSky>,
    /// Treatment of texels of the environment's file that are negative or not finite.
    pub bad_texels: BadTexels,
    /// Turns the environment about +Y, radians; see [`pt_scene::Environment::rotation`]. Added to the scene's own.
    pub environment_rotation: f32,
    /// Factor on the environment, >= 0.
    pub environment_intensity: f32,
    /// Give a scene without any light [`pt_scene::default_sky`] and [`pt_scene::default_sun`].
    pub default_sky: bool,
    /// Which animations of a glTF file play.
    pub animation: AnimationChoice,
    /// What the animations do after their last key.
    pub animation_end: AnimationEnd,
    /// Time at which the scene is shown at first, seconds; [`pt_scene::Scene::set_time`] goes on from there.
    pub time: f64,
    /// Which of a file's scenes, by name or by index from 0; `None`: its default one.
    pub scene: Option<String>,
    /// Which of a file's material variants (KHR_materials_variants), by name or by index from 0; `None`: no variant.
    pub variant: Option<String>,
    /// Most bytes of geometry (vertices, triangles, copies of instances) that a file may ask for: a small file can name
    /// the same data any number of times.
    pub max_geometry_bytes: u64,
    /// Read buffers and images outside of the folder of the scene file too, by `..`, an absolute path or a symbolic link.
    pub allow_outside: bool,
    /// Folder of textures baked by [`crate::bake::bake()`]; images that it does not hold are decoded.
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
            sky: None,
            bad_texels: BadTexels::default(),
            environment_rotation: 0.0,
            environment_intensity: 1.0,
            default_sky: true,
            animation: AnimationChoice::default(),
            animation_end: AnimationEnd::default(),
            time: 0.0,
            scene: None,
            variant: None,
            max_geometry_bytes: DEFAULT_MAX_GEOMETRY_BYTES,
            allow_outside: false,
            baked: None,
            max_texture_pixels: DEFAULT_MAX_TEXTURE_PIXELS,
        }
    }
}

/// The index of a name or, failing that, the number that the text is. The error says what there is to choose from.
pub(crate) fn named(wanted: &str, names: &[String]) -> Result<usize, String> {
    let by_name = names.iter().position(|name| name == wanted);
    let by_number = || wanted.parse().ok().filter(|&i: &usize| i < names.len());
    by_name.or_else(by_number).ok_or_else(|| match names {
        [] => format!("{wanted:?}; the file has none"),
        _ => {
            let there = match names.len() {
                1 => "there is one, index 0".to_owned(),
                count => format!("there are {count}, by index from 0"),
            };
            let called: Vec<_> = names.iter().map(String::as_str).filter(|name| !name.is_empty()).collect();
            let called =
                if called.is_empty() { String::new() } else { format!(" or by name: {}", called.join(", ")) };
            format!("{wanted:?}; {there}{called}")
        }
    })
}
