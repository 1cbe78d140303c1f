//! Arguments that select the scene and say how it is loaded.

use std::path::PathBuf;

use clap::Args;
use pt_import::LoadOptions;
use pt_scene::{AnimationChoice, AnimationEnd, BadTexels, PhysicalSky};

use super::values::{finite, finite_f64, not_negative, positive_f64};

/// The scene with its environment and its time.
#[derive(Clone, Debug, Args)]
pub struct SceneArgs {
    /// glTF or GLB file, or the name of a built-in scene.
    #[arg(value_name = "SCENE")]
    pub file: String,
    /// How it is loaded.
    #[command(flatten)]
    pub load: LoadArgs,
    /// Time of the first frame in the scene's animation, seconds.
    #[arg(long, value_name = "T", default_value_t = 0.0, value_parser = finite_f64, allow_negative_numbers = true, help_heading = "Scene")]
    pub time: f64,
    /// Frames per second of scene time between successive frames.
    #[arg(long, value_name = "F", default_value_t = 60.0, value_parser = positive_f64, allow_negative_numbers = true, help_heading = "Scene")]
    pub fps: f64,
}

impl SceneArgs {
    /// Options of the importer.
    pub fn load_options(&self) -> LoadOptions {
        LoadOptions { time: self.time, ..self.load.load_options() }
    }
}

/// How a scene is loaded.
#[derive(Clone, Debug, Args)]
pub struct LoadArgs {
    /// Which of the scenes in a glTF file, by name or by index from 0 [default: the file's own choice, or the first]
    #[arg(long, value_name = "NAME|INDEX", help_heading = "Scene")]
    pub gltf_scene: Option<String>,
    /// Which of the material variants in a glTF file (KHR_materials_variants), by name or by index from 0 [default: none]
    #[arg(long, value_name = "NAME|INDEX", help_heading = "Scene")]
    pub variant: Option<String>,
    /// Folder of textures from `pt bake`; images that it does not contain are decoded.
    #[arg(long, value_name = "DIR", help_heading = "Scene")]
    pub baked: Option<PathBuf>,
    /// Read buffers and images that are not beside or below the scene file, too: by paths with .., absolute paths or symbolic links.
    #[arg(long, help_heading = "Scene")]
    pub allow_outside: bool,
    /// Limit on the texels of all images of the scene together.
    #[arg(long, value_name = "N", default_value_t = pt_import::DEFAULT_MAX_TEXTURE_PIXELS, help_heading = "Scene")]
    pub max_texture_pixels: u64,
    /// Limit on the bytes of geometry of the scene; a small file can ask for a lot by repeating the same data.
    #[arg(long, value_name = "N", default_value_t = pt_import::DEFAULT_MAX_GEOMETRY_BYTES, help_heading = "Scene")]
    pub max_geometry_bytes: u64,
    /// Environment: a lat-long .hdr or .exr image.
    #[arg(long, value_name = "F", help_heading = "Scene")]
    pub env: Option<PathBuf>,
    /// Environment: the clear sky of Hosek and Wilkie with its sun, in cd/m2 and lux. Elevation of the sun, 0 to 90 degrees; its azimuth in
    /// degrees, counter-clockwise seen from above: 0 is +X, 90 is -Z; turbidity, 1 to 10 [default: 3]; albedo of the ground, 0 to 1
    /// [default: 0.2]
    #[arg(long, value_name = PhysicalSky::FORM, conflicts_with = "env", allow_hyphen_values = true, help_heading = "Scene")]
    pub sky: Option<PhysicalSky>,
    /// Load an environment with values that are no radiance: negative ones and NaN become 0, infinite ones 65504. A notice says how many
    /// pixels had some.
    #[arg(long, requires = "env", help_heading = "Scene")]
    pub env_clamp: bool,
    /// Rotate the environment, and the sun of a sky, about +Y, in degrees, counter-clockwise seen from above: 90 moves +X to -Z.
    #[arg(long, value_name = "DEG", default_value_t = 0.0, value_parser = finite, allow_negative_numbers = true, help_heading = "Scene")]
    pub env_rotation: f32,
    /// Factor on the radiance of the environment, and on the sun of a sky, 0 or more.
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = not_negative, allow_negative_numbers = true, help_heading = "Scene")]
    pub env_intensity: f32,
    /// Animation of a glTF file to play: a name, an index from 0, all, or none [default: the first, and all others that move only what
    /// no earlier one moves]
    #[arg(long, value_name = "NAME|INDEX|all|none", help_heading = "Scene")]
    pub animation: Option<AnimationChoice>,
    /// What the animations of a glTF file do after their last key: loop starts them again, hold keeps the last pose.
    #[arg(long, value_name = "loop|hold", default_value = "loop", help_heading = "Scene")]
    pub animation_end: AnimationEnd,
}

impl LoadArgs {
    /// Options of the importer, with the scene at time 0.
    pub fn load_options(&self) -> LoadOptions {
        LoadOptions {
            environment: self.env.clone(),
            sky: self.sky,
            bad_texels: BadTexels::clamp_if(self.env_clamp),
            environment_rotation: self.env_rotation.to_radians(),
            environment_intensity: self.env_intensity,
            scene: self.gltf_scene.clone(),
            variant: self.variant.clone(),
            allow_outside: self.allow_outside,
            baked: self.baked.clone(),
            max_texture_pixels: self.max_texture_pixels,
            max_geometry_bytes: self.max_geometry_bytes,
            animation: self.animation.clone().unwrap_or_default(),
            animation_end: self.animation_end,
            ..LoadOptions::default()
        }
    }
}
