//! Arguments that select the camera.

use super::values::{finite, numbers};
use clap::Args;
use std::path::PathBuf;
use std::str::FromStr;

/// Degrees.
pub const DEFAULT_VFOV: f32 = 50.0;

/// Camera arguments.
#[derive(Clone, Debug, Args)]
pub struct CameraArgs {
    /// Camera of the scene, by name or by index from 0 in the list of cameras of the file [default: the first, or one that frames the scene]
    #[arg(long, value_name = "NAME|INDEX", conflicts_with = "look", help_heading = "Camera")]
    pub camera: Option<CameraChoice>,
    /// Eye and target point instead of a camera of the scene, in scene units, +Y up.
    #[arg(long, value_name = "EX,EY,EZ,TX,TY,TZ", allow_hyphen_values = true, help_heading = "Camera")]
    pub look: Option<LookAt>,
    /// Vertical field of view of --look, degrees, between 0 and 180.
    #[arg(long, value_name = "DEG", default_value_t = DEFAULT_VFOV, value_parser = field_of_view, allow_negative_numbers = true, requires = "look", help_heading = "Camera")]
    pub vfov: f32,
    /// Way of the camera from a file that `pt view` has recorded, instead of a camera of the scene.
    #[arg(long, value_name = "F.json", conflicts_with_all = ["camera", "look"], help_heading = "Camera")]
    pub camera_path: Option<PathBuf>,
}

impl Default for CameraArgs {
    fn default() -> Self {
        Self { camera: None, look: None, vfov: DEFAULT_VFOV, camera_path: None }
    }
}

/// A camera of the scene, by index from 0 (digits only) or by name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CameraChoice {
    /// Index from 0.
    Index(usize),
    /// Name.
    Name(String),
}

impl FromStr for CameraChoice {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse() {
            Ok(index) => Ok(Self::Index(index)),
            Err(_) if text.is_empty() => Err("expected a name or an index from 0".into()),
            Err(_) => Ok(Self::Name(text.into())),
        }
    }
}

/// A view from one point to another, scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LookAt {
    /// Position of the camera.
    pub eye: [f32; 3],
    /// Target point; never equal to `eye`.
    pub target: [f32; 3],
}

impl FromStr for LookAt {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let [ex, ey, ez, tx, ty, tz] = numbers(text, "six finite numbers EX,EY,EZ,TX,TY,TZ", finite)?;
        let (eye, target) = ([ex, ey, ez], [tx, ty, tz]);
        if eye == target {
            return Err("eye and target are the same point".into());
        }
        Ok(Self { eye, target })
    }
}

fn field_of_view(text: &str) -> Result<f32, String> {
    finite(text)
        .ok()
        .filter(|&value| value > 0.0 && value < 180.0)
        .ok_or_else(|| "expected degrees between 0 and 180, both excluded".into())
}
