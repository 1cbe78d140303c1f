//! Arguments of `pt render`.

use crate::aov::AovSelection;
use crate::args::FrameArgs;
use crate::args::values::named;
use crate::frame::Oracle;
use crate::inputs::Inputs;
use crate::interrupt;
use crate::output::Output;
use crate::params::FrameParams;
use anyhow::bail;
use clap::Args;
use pt_image::atomic_file::check_writable;
use pt_image::image_file::OutputFormat;
use pt_shaders::records::Background;
use std::path::PathBuf;

/// `pt render`
#[derive(Clone, Debug, Args)]
#[command(after_help = interrupt::HELP)]
pub struct RenderArgs {
    /// Image to write: PNG or JPEG (tone-mapped, sRGB) or EXR (linear scene radiance before exposure); may be repeated. With a run of # in
    /// the name every frame is written, and its number (from 0) replaces the #.
    #[arg(short, long, value_name = "OUT.{png,jpg,exr}", required = true, help_heading = "Output")]
    pub output: Vec<PathBuf>,
    /// More images for the EXR: `all` channels, or a list of NAME (channel) and STAGE.NAME (private image of a stage).
    #[arg(long, value_name = "all|A,B", help_heading = "Output")]
    pub aov: Option<AovSelection>,
    /// Write GPU times per pass and the counters of allocations and pipelines to this JSON file. Beyond 2048 frames it holds a uniform
    /// sample of that many.
    #[arg(long, value_name = "F.json", help_heading = "Output")]
    pub timings: Option<PathBuf>,

    /// Replace the output of stages by ground truth: lights and indirect by the mean of many runs on the same surfaces; denoise (the composite of the
    /// denoised light), interleave (the flat frame) and taa (the anti-aliased frame) by path traced radiance; the exposure and the curve of
    /// tonemap by those of the path traced frame. What is left is the error that the other stages add.
    #[arg(long, value_name = "STAGE,...", value_delimiter = ',', value_parser = named::<Oracle>(), conflicts_with = "accumulate", help_heading = "Frame")]
    pub oracle: Vec<Oracle>,
    /// Samples per pixel, or runs of the lighting, of the ground truth of --oracle.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..), help_heading = "Frame")]
    pub oracle_spp: u32,

    /// Scene, camera, size, knobs and device.
    #[command(flatten)]
    pub frame: FrameArgs,
    /// Number of frames to render. The last one is written, or all of them (see --output), or with --accumulate their mean: each frame
    /// is then a sample per pixel.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..), help_heading = "Frame")]
    pub frames: u32,
}

impl RenderArgs {
    /// Checks all outputs before rendering begins.
    ///
    /// # Errors
    /// An unknown extension, a folder that is missing or not writable, a directory, AOVs without an EXR.
    pub fn check_outputs(&self) -> anyhow::Result<Vec<Output>> {
        let outputs: Vec<_> =
            self.output.iter().map(|path| Output::new(path)).collect::<anyhow::Result<_>>()?;
        if self.aov.is_some() && outputs.iter().all(|output| output.format() != OutputFormat::Exr) {
            bail!("--aov needs an EXR output, {} is none; add -o NAME.exr", self.output[0].display());
        }
        if let Some(timings) = &self.timings {
            check_writable(timings)?;
        }
        Ok(outputs)
    }

    /// The files that the command reads.
    pub fn inputs(&self) -> Inputs {
        Inputs::of_scene(&self.frame.scene, &self.frame.camera, self.frame.profile.as_deref())
    }

    /// Checks that the outputs can hold the alpha of a transparent background.
    ///
    /// # Errors
    /// A JPEG.
    pub fn check_alpha(&self, params: &FrameParams) -> anyhow::Result<()> {
        let is_jpeg =
            |path: &&PathBuf| OutputFormat::of(path).is_ok_and(|format| format == OutputFormat::Jpeg);
        match self.output.iter().find(is_jpeg) {
            Some(path) if params.denoise.background == Background::Transparent => {
                bail!("background transparent: {} has no alpha; write a png or an exr", path.display())
            }
            _ => Ok(()),
        }
    }
}
