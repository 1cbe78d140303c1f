//! Arguments that `pt render` and `pt capture` share: scene, camera, size, knobs, device.

use super::values::assignment;
use super::{CameraArgs, DeviceArgs, PostArgs, SceneArgs};
use crate::params::{FrameParams, check_frame, resolve};
use anyhow::Result;
use clap::Args;
use pt_image::image_file::ImageSize;

/// Scene, camera, size, knobs and device of a frame.
#[derive(Clone, Debug, Args)]
pub struct FrameArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The camera.
    #[command(flatten)]
    pub camera: CameraArgs,

    /// Image size in pixels, each side 1 to 16384.
    #[arg(long, value_name = "WxH", default_value = "1280x720", help_heading = "Frame")]
    pub size: ImageSize,
    /// Average all frames instead of showing the last one; without a denoiser, unless a profile or --set denoise.variant asks for one.
    #[arg(long, help_heading = "Frame")]
    pub accumulate: bool,
    /// Show the scene at --time in all frames; histories and the eye go on as in a sequence.
    #[arg(long, help_heading = "Frame")]
    pub hold: bool,
    /// Seed of all random numbers; another seed gives independent noise.
    #[arg(long, value_name = "S", default_value_t = 0, help_heading = "Frame")]
    pub seed: u64,
    /// Flags for post-processing.
    #[command(flatten)]
    pub post: PostArgs,
    /// Initial values of the knobs: the name of a built-in profile, or a TOML file.
    #[arg(long, value_name = "NAME|FILE", help_heading = "Frame")]
    pub profile: Option<String>,
    /// Set one knob; overrides the profile and the flags above; may be repeated.
    #[arg(long = "set", value_name = "stage.key=value", value_parser = assignment, help_heading = "Frame")]
    pub set: Vec<String>,

    /// Device and trace backend.
    #[command(flatten)]
    pub device: DeviceArgs,
}

impl FrameArgs {
    /// The knobs: those of the profile, then the flags, then the assignments.
    ///
    /// # Errors
    /// An unknown profile, key or value; knobs that do not fit to `--accumulate`.
    pub fn params(&self) -> Result<FrameParams> {
        let sets = [&self.post.sets[..], &self.set].concat();
        let params = resolve(self.profile.as_deref(), &sets, self.accumulate)?;
        check_frame(&params, self.accumulate)?;
        Ok(params)
    }

    /// Size of the picture in pixels.
    pub fn output_size(&self) -> [u32; 2] {
        self.size.into()
    }

    /// Time of frame `index`, seconds. With `--accumulate` and `--hold` all frames show the same time.
    pub fn time(&self, index: u32) -> f64 {
        let shown = if self.accumulate || self.hold { 0.0 } else { f64::from(index) / self.scene.fps };
        self.scene.time + shown
    }

    /// Seconds between frames for eye adaptation; `None` with `--accumulate`.
    pub fn time_step(&self) -> Option<f32> {
        (!self.accumulate).then_some((1.0 / self.scene.fps) as f32)
    }
}
