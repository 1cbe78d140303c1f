//! Light samplers compared on one view: mean and error of the direct light against the reference path tracer, at equal samples and at
//! equal time. Exit codes: 0 done, 2 usage or environment.

#![forbid(unsafe_code)]

mod bench;
mod heatmaps;
mod report;
mod truth;
mod view;

use anyhow::{Result, bail, ensure};
use clap::Parser;
use pt_core::settings::apply_sets;
use pt_core::trace::TraceBackend;
use pt_core::{console, knobs};
use pt_lights::DirectParams;
use pt_lights::records::LightRays;
use pt_shaders::named_enum::NamedEnum;
use pt_shaders::records::LightSampler;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Compares light samplers on one view of a scene: each renders the direct light in independent runs, which are compared with the
/// reference path tracer.
#[derive(Parser)]
#[command(version)]
struct Args {
    /// glTF file, built-in scene, or folder that `pt capture` has written: its first frame gives camera and size.
    #[arg(value_name = "SCENE|CAPTURE")]
    scene: String,
    /// Scene of a capture, if it is not a built-in one.
    #[arg(long, value_name = "FILE")]
    scene_file: Option<String>,
    /// Lat-long environment, .hdr or .exr.
    #[arg(long, value_name = "FILE")]
    env: Option<PathBuf>,
    /// Load an environment with negative, infinite or undefined values: they are set to 0 or to the largest half-precision number.
    #[arg(long, requires = "env")]
    env_clamp: bool,
    /// Samplers, separated by commas [default: all].
    #[arg(long, value_delimiter = ',', value_parser = sampler)]
    samplers: Vec<LightSampler>,
    /// Independent runs of each sampler.
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u32).range(2..=4096))]
    runs: u32,
    /// Frames of a run.
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=65536))]
    frames: u32,
    /// GPU time of a run at equal time, milliseconds [default: what `--frames` frames of the slowest sampler take].
    #[arg(long, value_name = "MS")]
    budget: Option<f64>,
    /// Width of the picture; the height follows from 16:9.
    #[arg(long, default_value_t = 160, value_parser = clap::value_parser!(u32).range(16..=3840))]
    width: u32,
    /// Camera of the file, by index.
    #[arg(long)]
    camera: Option<usize>,
    /// Samples per pixel of the reference.
    #[arg(long, default_value_t = 1024, value_parser = clap::value_parser!(u32).range(2..))]
    reference_spp: u32,
    /// Sets a knob of direct lighting (pt knobs lights).
    #[arg(long = "set", value_name = "lights.NAME=VALUE")]
    sets: Vec<String>,
    /// Writes the rows as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Writes for each sampler its mean and its error in false colour as PNG.
    #[arg(long, value_name = "DIR")]
    heatmaps: Option<PathBuf>,
    /// Trace backend: auto, compute, ray-query or rt-pipeline.
    #[arg(long, default_value = "auto")]
    backend: TraceBackend,
    /// Device, by index or part of its name [default: the best].
    #[arg(long)]
    device: Option<String>,
    /// Seed of the first run.
    #[arg(long, default_value_t = 0)]
    seed: u32,
}

knobs! {
    /// The knobs that `--set` takes.
    pub struct Settings {
        /// Direct lighting.
        pub lights: DirectParams;
    }
}

fn sampler(name: &str) -> Result<LightSampler, String> {
    LightSampler::from_name(name).map_err(|unknown| unknown.to_string())
}

fn main() -> ExitCode {
    console::program(|args, out| run(args, out).map(|()| true))
}

fn run(args: &Args, out: &mut impl Write) -> Result<()> {
    let mut settings = Settings::default();
    apply_sets(&mut settings, &args.sets)?;
    settings.lights.rays = LightRays::Merged;
    if args.budget.is_some_and(|ms| ms.is_nan() || ms <= 0.0) {
        bail!("--budget: {} is not a time", args.budget.unwrap_or_default());
    }
    let samplers = if args.samplers.is_empty() { LightSampler::VALUES } else { &args.samplers };
    let of = |&sampler: &LightSampler| DirectParams { sampler, ..settings.lights.clone() };
    let mut view = view::View::open(args, &samplers.iter().map(of).collect::<Vec<_>>())?;
    writeln!(out, "{}", view.describe())?;
    let truth = truth::Truth::trace(&mut view, args.reference_spp)?;
    let mask = bench::mask(&mut view)?;
    let kept = mask.iter().filter(|keep| **keep).count();
    ensure!(kept > 0, "no pixel of the view shows a surface that is neither a lamp nor a mirror nor glass");
    writeln!(
        out,
        "reference: {} samples a pixel, relative error {:.4}; {kept} of {} pixels count: surfaces, without lamps, mirrors and glass",
        args.reference_spp,
        truth.relative_error,
        mask.len()
    )?;
    let plan = bench::Plan {
        runs: args.runs,
        frames: args.frames,
        budget_ms: args.budget,
        seed: args.seed,
        params: &settings.lights,
    };
    let results = bench::compare(&mut view, &truth, &mask, samplers, &plan, |line| eprintln!("{line}"))?;
    report::table(&results, &plan, out)?;
    if let Some(path) = &args.json {
        report::write_json(&results, &view, path)?;
    }
    if let Some(folder) = &args.heatmaps {
        heatmaps::write(&results, &truth, view.size(), folder)?;
    }
    Ok(())
}
