//! Arguments of `pt render`.

use crate::aov::AovSelection;
use crate::args::FrameArgs;
use crate::output::Output;
use clap::Args;
use pt_image::atomic_file::check_writable;
use pt_image::image_file::OutputFormat;
use std::path::PathBuf;

/// `pt render`
#[derive(Clone, Debug, Args)]
pub struct RenderArgs {
    /// Image to write: PNG (tone-mapped, sRGB) or EXR (linear scene radiance before exposure); may be repeated. With a run of # in the
    /// name every frame is written, and its number (from 0) replaces the #.
    #[arg(short, long, value_name = "OUT.{png,exr}", required = true, help_heading = "Output")]
    pub output: Vec<PathBuf>,
    /// More images for the EXR: `all` channels, or a list of NAME (channel) and STAGE.NAME (private image of a stage).
    #[arg(long, value_name = "all|A,B", help_heading = "Output")]
    pub aov: Option<AovSelection>,
    /// Write GPU times per pass and the counters of allocations and pipelines to this JSON file.
    #[arg(long, value_name = "F.json", help_heading = "Output")]
    pub timings: Option<PathBuf>,

    /// Scene, camera, size, knobs and device.
    #[command(flatten)]
    pub frame: FrameArgs,
    /// Number of frames to render. The last one is written, or all of them (see --output).
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..), help_heading = "Frame")]
    pub frames: u32,
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
