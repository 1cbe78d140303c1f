//! The `main` function of every stage's benchmark.

use super::{WARM_UP, measure};
use crate::console::program;
use crate::device::{Device, DeviceOptions};
use crate::frame::Frame;
use clap::Parser;
use pt_image::image_file::ImageSize;
use std::error::Error;
use std::io::Write;
use std::process::ExitCode;

/// GPU times of a stage on a synthetic frame.
#[derive(Parser)]
struct BenchArgs {
    /// Frame size, WIDTHxHEIGHT in pixels [default: that of the bench]
    size: Option<ImageSize>,
    /// Frames whose time counts.
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Vulkan device, by index or part of its name [default: a discrete GPU before the CPU]
    #[arg(long, value_name = "D")]
    device: Option<String>,
    /// Given by `cargo bench`; without it (`cargo test --benches`) one small frame shows that the bench works.
    #[arg(long)]
    bench: bool,
}

/// Size of the frame in a run that is not a measurement.
const TRIAL_SIZE: [u32; 2] = [64, 36];

/// Times a stage and prints the table: `cargo bench -p CRATE [-- WIDTHxHEIGHT] [--frames N] [--device D]`.
///
/// `set_up` gets the device and the frame's size, and returns what records one frame.
pub fn bench<R>(
    default_size: [u32; 2],
    set_up: impl FnOnce(&Device, [u32; 2]) -> Result<R, Box<dyn Error + Send + Sync>>,
) -> ExitCode
where
    R: FnMut(&mut Frame<'_>) -> crate::Result<()>,
{
    program(|args: &BenchArgs, out| {
        let (size, warm_up, frames) = match (args.size, args.bench) {
            (None, false) => (TRIAL_SIZE, 0, 1),
            (size, _) => (size.map_or(default_size, <[u32; 2]>::from), WARM_UP, args.frames),
        };
        let device = Device::open(&DeviceOptions { device: args.device.clone(), validation: false })?;
        let record = set_up(&device, size)?;
        write!(out, "{}", measure(&device, size, warm_up, frames, record)?)?;
        Ok::<_, Box<dyn Error + Send + Sync>>(true)
    })
}
