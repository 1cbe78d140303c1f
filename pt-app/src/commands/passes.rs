//! `pt passes` prints the passes of the frame as a table, and the memory that it takes.

use crate::args::values::{assignment, named};
use crate::args::{CameraArgs, DeviceArgs};
use crate::frame::{FrameMemory, FullFrame};
use crate::params;
use crate::session::{Session, open_scene};
use anyhow::Result;
use clap::Args;
use pt_core::frame::PassInfo;
use pt_core::trace::TraceBackend;
use pt_core::{Kept, Recorder};
use pt_image::image_file::ImageSize;
use pt_import::LoadOptions;
use std::io::Write;

/// `pt passes`
#[derive(Clone, Debug, Args)]
pub struct PassesArgs {
    /// Print JSON instead of a table.
    #[arg(long)]
    pub json: bool,
    /// Image size for which extents and bytes are printed.
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    pub size: ImageSize,
    /// glTF or GLB file, or the name of a built-in scene. Animated scenes have additional passes.
    #[arg(long, value_name = "S", default_value = "cornell")]
    pub scene: String,
    /// Read buffers and images that are not beside or below the scene file, too.
    #[arg(long)]
    pub allow_outside: bool,
    /// Include the pass that averages frames.
    #[arg(long)]
    pub accumulate: bool,
    /// Keep all images until the next frame, as `pt render --aov` does; else they share memory where one is written after another was read last.
    #[arg(long)]
    pub keep_all: bool,
    /// Set one knob; may be repeated.
    #[arg(long = "set", value_name = "stage.key=value", value_parser = assignment)]
    pub set: Vec<String>,
    /// Trace backend.
    #[arg(long, value_name = "B", value_parser = named::<TraceBackend>(), default_value_t = TraceBackend::Compute)]
    pub backend: TraceBackend,
    /// Vulkan device, by index or part of its name.
    #[arg(long, value_name = "D")]
    pub device: Option<String>,
}

/// Runs the command: records three frames of the scene, 1/60 s apart, and prints the declared accesses.
///
/// # Errors
/// Unknown keys, a device that can't do it.
pub fn run(args: &PassesArgs, out: &mut impl Write) -> Result<bool> {
    let params = params::resolve(None, &args.set, args.accumulate)?;
    let options = LoadOptions { allow_outside: args.allow_outside, ..LoadOptions::default() };
    let scene = open_scene(&args.scene, &options)?;
    let device = DeviceArgs { backend: args.backend, device: args.device.clone(), validation: false };
    let mut session = Session::open(&device, &CameraArgs::default(), scene)?;
    let size = [args.size.width, args.size.height];
    let before = session.device.memory_in_use();
    let kept = if args.keep_all { Kept::All } else { Kept::Outputs };
    let mut full = FullFrame::keeping(kept, &mut session, size, args.accumulate, &params)?;
    let mut recorder = Recorder::new(&session.device)?;
    // The third frame has no set-up uploads.
    for time in [0.0, 1.0 / 60.0, 2.0 / 60.0] {
        let mut frame = recorder.begin()?;
        session.update(&mut frame, time, 0.0)?;
        full.record(&mut frame, &session.gpu, &session.camera.at(time), 0, None, &params)?;
        frame.submit()?;
    }
    recorder.finish()?;

    let passes = recorder.pass_table();
    let memory = full.memory(&before, session.device.memory_in_use(), passes);
    if args.json {
        writeln!(out, "{}", serde_json::to_string_pretty(&Listed { passes, memory })?)?;
        return Ok(true);
    }
    for (number, pass) in (1..).zip(passes) {
        let [x, y, z] = pass.extent;
        let mebibytes = pass.bytes as f64 / f64::from(1 << 20);
        writeln!(
            out,
            "{number:2} {}  [{}]  {x}x{y}x{z} threads, {}{mebibytes:.1} MiB",
            pass.name,
            pass.kernel,
            if pass.bytes_are_upper_bound { "at most " } else { "" },
        )?;
        if !pass.reads.is_empty() {
            writeln!(out, "     reads   {}", pass.reads.join(" "))?;
        }
        writeln!(out, "     writes  {}", pass.writes.join(" "))?;
    }
    writeln!(out, "memory of the frame: {}", in_words(memory.bytes, memory.bytes_a_pixel))?;
    for stage in &memory.stages {
        let share = |(name, bytes): &(String, u64)| {
            format!("{name} {:.1}", *bytes as f64 / memory.bytes as f64 * memory.bytes_a_pixel)
        };
        let allocations: Vec<_> = stage.allocations.iter().map(share).collect();
        writeln!(out, "  {}: {}", stage.stage, in_words(stage.bytes, stage.bytes_a_pixel))?;
        writeln!(out, "     {}", allocations.join(", "))?;
    }
    Ok(true)
}

/// What `--json` prints.
#[derive(serde::Serialize)]
struct Listed<'a> {
    passes: &'a [PassInfo],
    memory: FrameMemory,
}

fn in_words(bytes: u64, bytes_a_pixel: f64) -> String {
    format!("{bytes_a_pixel:.1} bytes a pixel, {:.1} MiB", bytes as f64 / f64::from(1 << 20))
}
