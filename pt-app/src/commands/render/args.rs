//! What `pt render` takes.

use super::output::Output;
use super::post_args::PostArgs;
use crate::args::values::assignment;
use crate::args::{CameraArgs, DeviceArgs, SceneArgs};
use clap::Args;
use pt_image::atomic_file::check_writable;
use pt_image::image_file::{ImageSize, OutputFormat};
use std::path::PathBuf;
use std::str::FromStr;

/// `pt render`
#[derive(Clone, Debug, Args)]
pub struct RenderArgs {
    /// Image to write: PNG (tone-mapped, sRGB) or EXR (linear scene radiance before exposure); may be repeated. A run of # in the name
    /// stands for the number of the frame, from 0, and every frame is written.
    #[arg(short, long, value_name = "OUT.{png,exr}", required = true, help_heading = "Output")]
    pub output: Vec<PathBuf>,
    /// Further channels for an EXR: all, or a list of names.
    #[arg(long, value_name = "all|A,B", help_heading = "Output")]
    pub aov: Option<AovSelection>,
    /// Write GPU times per pass and the counters of allocations and pipelines to this JSON file.
    #[arg(long, value_name = "F.json", help_heading = "Output")]
    pub timings: Option<PathBuf>,

    /// What is rendered.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The view.
    #[command(flatten)]
    pub camera: CameraArgs,

    /// Image size in pixels, each side 1 to 16384.
    #[arg(long, value_name = "WxH", default_value = "1280x720", help_heading = "Frame")]
    pub size: ImageSize,
    /// Frames to render; the last one is written, or all of them (see --output).
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..), help_heading = "Frame")]
    pub frames: u32,
    /// Write the mean of all frames instead of the last one.
    #[arg(long, help_heading = "Frame")]
    pub accumulate: bool,
    /// Seed of all random numbers; another seed gives independent noise.
    #[arg(long, value_name = "S", default_value_t = 0, help_heading = "Frame")]
    pub seed: u64,
    /// What happens to the frame after it is traced.
    #[command(flatten)]
    pub post: PostArgs,
    /// Parameters to start from: the name of a built-in profile or a TOML file.
    #[arg(long, value_name = "NAME|FILE", help_heading = "Frame")]
    pub profile: Option<String>,
    /// Set one parameter, after the profile; may be repeated.
    #[arg(long = "set", value_name = "stage.key=value", value_parser = assignment, help_heading = "Frame")]
    pub set: Vec<String>,

    /// Where it runs.
    #[command(flatten)]
    pub device: DeviceArgs,
}

impl RenderArgs {
    /// Checks all outputs before rendering begins.
    ///
    /// # Errors
    /// An unknown extension, a folder that is missing or not writable, a directory, AOVs without an EXR.
    pub fn check_outputs(&self) -> anyhow::Result<Vec<Output>> {
        let outputs: Vec<_> = self.output.iter().map(|path| Output::new(path)).collect::<Result<_, _>>()?;
        if self.aov.is_some() && outputs.iter().all(|output| output.format() != OutputFormat::Exr) {
            anyhow::bail!("--aov needs an EXR output, {} is a PNG", self.output[0].display());
        }
        if let Some(timings) = &self.timings {
            check_writable(timings)?;
        }
        Ok(outputs)
    }
}

/// Which channels besides the image go into an EXR.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AovSelection {
    /// Every channel there is.
    All,
    /// These, in this order.
    Named(Vec<String>),
}

impl FromStr for AovSelection {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        if text == "all" {
            return Ok(Self::All);
        }
        let names: Vec<_> = text.split(',').map(|name| name.trim().to_owned()).collect();
        if names.iter().any(String::is_empty) {
            return Err("expected all, or names separated by commas".into());
        }
        Ok(Self::Named(names))
    }
}
