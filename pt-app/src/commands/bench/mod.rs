//! `pt bench`: its commands.

pub mod compare;
pub mod frame;
#[cfg(feature = "view")]
pub mod panel;
pub mod path;
pub mod post;
pub mod trace;

use anyhow::Result;
use clap::{Args, Subcommand};
use frame::Subject;
use pt_core::Device;
use std::io::Write;

/// Seconds of work before anything is timed: the clock of a GPU rises only after some of it.
fn least_warm_up_s(device: &Device) -> f64 {
    if device.info().is_cpu() { 0.0 } else { 1.5 }
}

/// `pt bench`
#[derive(Clone, Debug, Args)]
pub struct BenchArgs {
    /// The benchmark.
    #[command(subcommand)]
    pub command: BenchCommand,
}

/// The benchmarks.
#[derive(Clone, Debug, Subcommand)]
pub enum BenchCommand {
    /// Rays per second of every trace backend, on the same primary, bounce and shadow rays.
    Trace(trace::BenchTraceArgs),
    /// GPU time, bytes and share of the copy bandwidth of every pass from the interleave to the picture.
    Post(post::BenchPostArgs),
    /// Paths and rays per second of the reference path tracer, compared with the CPU tracing the same number of rays.
    Path(Box<path::BenchPathArgs>),
    /// GPU time, bytes, rays and shares of the measured bandwidth and ray rates of every pass of the frame.
    Frame(Box<frame::BenchFrameArgs>),
    /// The same of the passes of one stage; a stage that needs no rays runs alone on a recorded frame.
    Stage(Box<frame::BenchStageArgs>),
    /// The frame, then each stage that needs no rays alone.
    All(Box<frame::BenchFrameArgs>),
    /// GPU time of the panel of `pt view`, drawn over pictures on a surface without a window.
    #[cfg(feature = "view")]
    Panel(panel::BenchPanelArgs),
    /// Compare two runs of a benchmark of the frame: which passes have become slower.
    Compare(compare::CompareArgs),
}

/// Runs the command.
///
/// # Errors
/// Unknown scene or device, a file that can't be written.
pub fn run(args: &BenchArgs, out: &mut impl Write) -> Result<bool> {
    match &args.command {
        BenchCommand::Trace(args) => trace::run(args, out),
        BenchCommand::Path(args) => path::run(args, out),
        BenchCommand::Post(args) => post::run(args, out),
        BenchCommand::Frame(args) => frame::run(args, Subject::Frame, out),
        BenchCommand::Stage(args) => frame::run(&args.frame, Subject::Stage(args.stage), out),
        BenchCommand::All(args) => frame::run(args, Subject::All, out),
        #[cfg(feature = "view")]
        BenchCommand::Panel(args) => panel::run(args, out),
        BenchCommand::Compare(args) => compare::run(args, out),
    }
}
