//! Lights a recorded G-buffer by bounces, or projects an environment into the representation of indirect light. Exit codes: 0 done,
//! 2 usage or environment.

#![forbid(unsafe_code)]

mod environment;
mod relight;

use anyhow::{Result, ensure};
use clap::Parser;
use pt_core::console;
use pt_core::harness::StageArgs;
use pt_core::trace::TraceBackend;
use pt_shaders::records::LightSampler;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Lights the G-buffer of a capture by bounce rays with other knobs; or, for an image, compares the irradiance of the six axes from a
/// lat-long environment in spherical harmonics up to l = 1 with the exact integral.
#[derive(Parser)]
#[command(version)]
pub struct Args {
    /// Folder that `pt capture` wrote, or a lat-long environment: hdr or exr.
    #[arg(value_name = "CAPTURE|ENVIRONMENT")]
    input: PathBuf,
    /// Load an environment with negative, infinite or undefined values: they are set to 0 or to the largest half-precision number.
    #[arg(long)]
    env_clamp: bool,
    /// EXR to write: the indirect light of the frame, diffuse and specular, one layer per channel.
    #[arg(short, long, value_name = "OUT.exr")]
    output: Option<PathBuf>,
    /// Scene of the capture, if it is not where it was recorded.
    #[arg(long, value_name = "S")]
    scene_file: Option<String>,
    /// Environment of the capture's scene: a lat-long .hdr or .exr image.
    #[arg(long, value_name = "F")]
    env: Option<PathBuf>,
    /// Recorded frame to light [default: the first one]
    #[arg(long, value_name = "N")]
    frame: Option<u32>,
    /// How the surfaces that bounce rays meet pick a local light.
    #[arg(long, value_name = "NAME", value_parser = sampler, default_value = LightSampler::Power.name())]
    sampler: LightSampler,
    /// Trace backend: auto (measures), compute, ray-query, rt-pipeline or rt-reorder.
    #[arg(long, value_name = "B", default_value_t = TraceBackend::Auto)]
    backend: TraceBackend,
    #[command(flatten)]
    stage: StageArgs,
}

fn sampler(name: &str) -> Result<LightSampler, String> {
    pt_shaders::NamedEnum::from_name(name).map_err(|error: pt_shaders::UnknownName| error.to_string())
}

fn main() -> ExitCode {
    console::program(|args, out| run(args, out).map(|()| true))
}

fn run(args: &Args, out: &mut impl Write) -> Result<()> {
    if args.input.is_dir() && args.input.join(pt_core::capture::folder::INDEX).is_file() {
        return relight::run(args, out);
    }
    let path = args.input.display();
    ensure!(!args.input.is_dir(), "{path}: is a folder without a capture; pt capture writes one");
    ensure!(args.output.is_none(), "{path}: -o writes the light of a capture, and this is no folder of one");
    environment::run(&args.input, args.env_clamp, out)
}
