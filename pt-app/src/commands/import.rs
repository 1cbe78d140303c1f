//! `pt import` makes a capture of frames that another renderer recorded.

use anyhow::Result;
use clap::{Args, Subcommand};
use pt_import::bmfr;
use std::io::Write;
use std::path::PathBuf;

/// `pt import`
#[derive(Clone, Debug, Args)]
pub struct ImportArgs {
    /// What the frames are recorded as.
    #[command(subcommand)]
    pub format: ImportFormat,
}

/// The formats.
#[derive(Clone, Debug, Subcommand)]
pub enum ImportFormat {
    /// Frames in the layout of the data set of "Blockwise Multi-Order Feature Regression for Real-Time Path-Tracing Reconstruction" (Koskela et al. 2019).
    Bmfr(BmfrArgs),
}

/// `pt import bmfr`
#[derive(Clone, Debug, Args)]
#[command(after_help = BMFR_HELP)]
pub struct BmfrArgs {
    /// Folder with camera_matrices.h and color0.exr, albedo0.exr, shading_normal0.exr, world_position0.exr, reference0.exr and so on, here or in its
    /// folder inputs.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Folder for the capture; created if missing; must not contain a capture yet.
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
}

const BMFR_HELP: &str = "\
The capture has what pt-denoise and pt replay --from denoise need for the variants off, accumulate, svgf, atrous and recurrent. It has no random seeds, no light lists
and no indirect light apart from the direct: the variant asvgf, which takes light samples again, is refused with the name of the channel that is missing
(gradient_sample). All light is diffuse, and all surfaces are still and rough; their vertex normals are the shading normals.";

/// Runs the command.
///
/// # Errors
/// Files that are missing, damaged or of different sizes, cameras that do not fit the positions, a folder that can't be written.
pub fn run(args: &ImportArgs, out: &mut impl Write) -> Result<bool> {
    let ImportFormat::Bmfr(args) = &args.format;
    let done = bmfr::import(&args.folder, &args.output)?;
    let [width, height] = done.size;
    writeln!(
        out,
        "{}: {} frames, {width}x{height}, {} of them with a reference; without gradient_sample, which the variant asvgf needs",
        args.output.display(),
        done.frames,
        done.references
    )?;
    Ok(true)
}
