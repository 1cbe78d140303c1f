//! The command line: the list of commands.

#[cfg(feature = "codecs")]
use crate::commands::bake;
use crate::commands::{
    bench, capture, compare, import, info, knobs, merge, passes, reference, render, replay, scenes, sheet,
    study, view,
};
use anyhow::Result;
use clap::{Parser, Subcommand};
use std::io::Write;

/// Renders scenes by real-time path tracing, one exchangeable stage after the other, and compares every stage with ground truth.
#[derive(Debug, Parser)]
#[command(name = "pt", version, about, after_help = EXAMPLES)]
pub struct Cli {
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

const EXAMPLES: &str = "\
Examples:
  pt render gallery -o picture.png                    one frame of a built-in scene
  pt render scene.gltf --frames 64 --accumulate -o picture.exr
  pt view gallery --size 480x270                      a window
  pt reference scene.gltf --spp 256 -o truth.exr      the ground truth
  pt compare picture.exr truth.exr                    error metrics
  pt scenes                                           the built-in scenes
  pt render --help                                    the options of a command

Exit codes: 0 done, 1 a check failed, 2 wrong usage or environment.";

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// List devices, drivers and trace backends, and the backend that `auto` chooses.
    Info(info::InfoArgs),
    /// List the built-in scenes, or the content of one scene.
    Scenes(scenes::ScenesArgs),
    /// List the passes of the frame in order: what each reads, writes and moves.
    Passes(passes::PassesArgs),
    /// List the knobs (parameters) that `--set` takes, with their defaults and ranges.
    Knobs(knobs::KnobsArgs),
    /// Measure speed: rays, the reference path tracer, post-processing, every pass of the frame; compare two measurements.
    Bench(bench::BenchArgs),
    /// Render frames of a scene.
    Render(Box<render::RenderArgs>),
    /// Show frames of a scene in a window: every knob, ground truth beside them, the command line that reproduces them.
    View(Box<view::ViewArgs>),
    /// Record frames of a scene: the channels between the stages, and the histories at the first frame.
    Capture(Box<capture::CaptureArgs>),
    /// Run the rest of the frame on recorded frames, without a scene.
    Replay(replay::ReplayArgs),
    /// Make a capture of frames that another renderer recorded.
    Import(import::ImportArgs),
    /// Path trace the ground truth of a scene, without bias.
    Reference(Box<reference::ReferenceArgs>),
    /// Join slices of one render of `pt reference`.
    Merge(merge::MergeArgs),
    /// Compress a scene's textures ahead of time, for `pt render --baked`.
    #[cfg(feature = "codecs")]
    Bake(bake::BakeArgs),
    /// Compare an image, or the frames of a sequence, with its reference: error metrics.
    Compare(compare::CompareArgs),
    /// Put many images on one sheet, with their names.
    Sheet(sheet::SheetArgs),
    /// Run a study: switch knobs, on these scenes with these seeds, and say whether it matters.
    Study(Box<study::StudyArgs>),
}

impl Cli {
    /// Runs the command; false when a check failed.
    ///
    /// # Errors
    /// Wrong usage, files that can't be read or written, a device that can't do it.
    pub fn run(&self, out: &mut impl Write) -> Result<bool> {
        match &self.command {
            Command::Info(args) => info::run(args, out),
            Command::Scenes(args) => scenes::run(args, out),
            Command::Passes(args) => passes::run(args, out),
            Command::Knobs(args) => knobs::run(args, out),
            Command::Bench(args) => bench::run(args, out),
            Command::Render(args) => render::run(args, out),
            Command::View(args) => view::run(args, out),
            Command::Capture(args) => capture::run(args, out),
            Command::Replay(args) => replay::run(args, out),
            Command::Import(args) => import::run(args, out),
            Command::Reference(args) => reference::run(args, out),
            Command::Merge(args) => merge::run(args, out),
            #[cfg(feature = "codecs")]
            Command::Bake(args) => bake::run(args, out),
            Command::Compare(args) => compare::run(args, out),
            Command::Sheet(args) => sheet::run(args, out),
            Command::Study(args) => study::run(args, out),
        }
    }
}
