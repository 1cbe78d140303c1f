//! `pt bench`: its commands.

pub mod path;
pub mod post;
pub mod trace;

use anyhow::Result;
use clap::{Args, Subcommand};
use std::io::Write;

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
    }
}
