//! Arguments of `pt view`.

use crate::args::FrameArgs;
use clap::Args;
use std::path::PathBuf;

/// `pt view`
#[derive(Clone, Debug, Args)]
pub struct ViewArgs {
    /// Folder for pictures, captures and camera paths that keys write.
    #[arg(long, value_name = "DIR", default_value = ".", help_heading = "Output")]
    pub folder: PathBuf,
    /// Scene, camera, size, knobs and device.
    #[command(flatten)]
    pub frame: FrameArgs,
    /// Frames of a capture, and of a picture that is rendered anew because no command line could say how it came about.
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..), help_heading = "Frame")]
    pub frames: u32,
    /// Scene time runs from the start.
    #[arg(long, conflicts_with = "hold", help_heading = "Frame")]
    pub play: bool,
}
