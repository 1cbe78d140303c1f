//! Light samplers compared on one view: mean and error of the direct light against the reference path tracer, at equal samples and at
//! equal time; how they follow a change; whether gradient pixels repeat their samples; and what they cost with more and more lights. Exit codes:
//! 0 done, 1 a gradient pixel differs, 2 usage or environment.

#![forbid(unsafe_code)]

mod change;
mod contestant;
mod figure;
mod heatmaps;
mod lamps;
mod measure;
mod replay;
mod report;
mod statistics;
mod sweep;
mod truth;
mod view;

use anyhow::{Result, bail, ensure};
use change::Change;
use clap::Parser;
use contestant::{Choice, Entry};
use pt_core::settings::apply_sets;
use pt_core::trace::TraceBackend;
use pt_core::{console, knobs};
use pt_image::atomic_file::check_writable;
use pt_lights::DirectParams;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Compares light samplers on one view of a scene: each renders the direct light in independent runs, which are compared with the
/// reference path tracer.
#[derive(Parser)]
#[command(version)]
struct Args {
    /// glTF file, built-in scene, or folder that `pt capture` has written: its first frame gives camera and size.
    #[arg(value_name = "SCENE|CAPTURE", required_unless_present = "lights_sweep")]
    scene: Option<String>,
    /// Scene of a capture, if it is not a built-in one.
    #[arg(long, value_name = "FILE")]
    scene_file: Option<String>,
    /// Lat-long environment, .hdr or .exr.
    #[arg(long, value_name = "FILE")]
    env: Option<PathBuf>,
    /// Load an environment with negative, infinite or undefined values: they are set to 0 or to the largest half-precision number.
    #[arg(long, requires = "env")]
    env_clamp: bool,
    /// Samplers, separated by commas, each with knobs of its own if need be: NAME:KNOB=VALUE:... The name per-kind stands for a ray for each
    /// kind of light, without a sampler [default: per-kind and all samplers].
    #[arg(long, value_delimiter = ',', value_parser = Entry::parse)]
    samplers: Vec<Entry>,
    /// Independent runs of each sampler.
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u32).range(2..=4096))]
    runs: u32,
    /// Frames of a run.
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=65536))]
    frames: u32,
    /// Frames before them, which do not count: samplers with a history learn.
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(0..=65536))]
    warm_up: u32,
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
    /// Million shadow rays a second that the device traces in the scene [default: measured, as pt bench trace does].
    #[arg(long, value_name = "MRAYS")]
    ray_rate: Option<f64>,
    /// Also compares the means of 16x16 blocks with the reference, in standard errors.
    #[arg(long)]
    blocks: bool,
    /// Hangs so many lamps of one small triangle each into the scene.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(lamps::MOST)))]
    lamps: Option<u32>,
    /// Instead, replays frames as gradient pixels of a denoiser do: says whether the light is that of the last frame, to the bit. Exit code 1 if a
    /// sampler that claims it does not do it.
    #[arg(long, conflicts_with_all = ["change", "blocks", "budget", "figure", "markdown", "heatmaps", "ray_rate", "lights_sweep"])]
    replay: bool,
    /// Instead, measures how long samplers take to follow a change: the scene jumps from one time to another, seconds.
    #[arg(long, value_name = "BEFORE:AFTER", value_parser = Change::parse, conflicts_with_all = ["blocks", "budget", "figure", "heatmaps", "ray_rate"])]
    change: Option<Change>,
    /// Instead, times the samplers in a generated hall with so many lights, separated by commas.
    #[arg(long, value_name = "N,N,...", value_delimiter = ',', value_parser = sweep::count, conflicts_with_all = ["scene", "lamps", "change", "blocks", "budget", "figure", "heatmaps", "ray_rate"])]
    lights_sweep: Vec<u32>,
    /// Writes error against GPU time as SVG.
    #[arg(long, value_name = "FILE.svg")]
    figure: Option<PathBuf>,
    /// Writes the ranking as a table in Markdown.
    #[arg(long, value_name = "FILE")]
    markdown: Option<PathBuf>,
    /// Writes the rows as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Writes for each sampler its mean and its error in false colour as PNG.
    #[arg(long, value_name = "DIR")]
    heatmaps: Option<PathBuf>,
    /// Trace backend: auto, compute, ray-query, rt-pipeline or rt-reorder.
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

fn main() -> ExitCode {
    console::program(run)
}

/// Whether no check has failed.
fn run(args: &Args, out: &mut impl Write) -> Result<bool> {
    let mut settings = Settings::default();
    apply_sets(&mut settings, &args.sets)?;
    settings.lights.replay |= args.replay;
    for (option, value) in [("--budget", args.budget), ("--ray-rate", args.ray_rate)] {
        if let Some(value) = value.filter(|value| !value.is_finite() || *value <= 0.0) {
            bail!("{option}: {value} is not a {}", if option == "--budget" { "time" } else { "rate" });
        }
    }
    for path in [&args.json, &args.figure, &args.markdown].into_iter().flatten() {
        check_writable(path)?;
    }
    let entries = if args.samplers.is_empty() { Entry::all() } else { args.samplers.clone() };
    let choices: Vec<Choice> =
        entries.iter().map(|entry| entry.choose(&settings.lights)).collect::<Result<_>>()?;
    for note in contestant::unequal(&choices)? {
        console::print_warning(&note);
    }
    if !args.lights_sweep.is_empty() {
        let costs = sweep::run(args, &args.lights_sweep, &choices, out)?;
        if let Some(path) = &args.markdown {
            report::write_text(&sweep::markdown(&costs, &args.lights_sweep, &choices), path)?;
        }
        args.json.iter().try_for_each(|path| report::write_json(&sweep::rows(&costs), path))?;
        return Ok(true);
    }
    if args.replay {
        return replay(args, &choices, out);
    }
    compare(args, &choices, out).map(|()| true)
}

/// Replays frames of the samplers; whether each does what it claims.
fn replay(args: &Args, choices: &[Choice], out: &mut impl Write) -> Result<bool> {
    let stages: Vec<_> = choices.iter().map(|choice| choice.params.clone()).collect();
    let mut view = view::View::open(args, &stages)?;
    writeln!(out, "{}", view.describe())?;
    let plan = plan(args);
    let results = replay::run(&mut view, choices, &plan, |line| eprintln!("{line}"))?;
    replay::table(&results, &plan, out)?;
    if let Some(path) = &args.json {
        report::write_json(&replay::rows(&results, &plan, &view), path)?;
    }
    Ok(!results.iter().any(replay::Replayed::fails))
}

fn plan(args: &Args) -> measure::Plan {
    measure::Plan {
        runs: args.runs,
        frames: args.frames,
        warm_up: args.warm_up,
        budget_ms: args.budget,
        seed: args.seed,
        ray_rate: 0.0,
    }
}

/// Compares the samplers with the reference.
fn compare(args: &Args, choices: &[Choice], out: &mut impl Write) -> Result<()> {
    let stages: Vec<_> = choices.iter().map(|choice| choice.params.clone()).collect();
    let mut view = view::View::open(args, &stages)?;
    if let Some(change) = args.change {
        view.set_time(change.after, change.after);
    }
    writeln!(out, "{}", view.describe())?;
    let truth = truth::Truth::trace(&mut view, args.reference_spp)?;
    let mask = measure::mask(&mut view)?;
    let kept = mask.iter().filter(|keep| **keep).count();
    ensure!(kept > 0, "no pixel of the view shows a surface that is neither a lamp nor a mirror nor glass");
    writeln!(
        out,
        "reference: {} samples a pixel, relative error {:.4}; {kept} of {} pixels count: surfaces, without lamps, mirrors and glass",
        args.reference_spp,
        truth.relative_error,
        mask.len()
    )?;
    let mut plan = plan(args);
    let tell = |line: &str| eprintln!("{line}");
    if let Some(change) = args.change {
        let results = change::follow(&mut view, &truth, &mask, choices, &plan, change, tell)?;
        change::table(&results, &plan, change, out)?;
        if let Some(path) = &args.markdown {
            report::write_text(&change::markdown(&results), path)?;
        }
        let rows = change::rows(&results, &plan, change, &view);
        return args.json.iter().try_for_each(|path| report::write_json(&rows, path));
    }
    plan.ray_rate = args.ray_rate.map_or_else(|| view.shadow_rate(), Ok)?;
    writeln!(out, "shadow rays of the scene: {:.1} million a second", plan.ray_rate)?;
    let results = measure::compare(&mut view, &truth, &mask, choices, &plan, tell)?;
    report::tables(&results, &plan, out)?;
    if args.blocks {
        report::blocks(&results, out)?;
    }
    if let Some(path) = &args.json {
        report::write_json(&report::rows(&results, &plan, &view), path)?;
    }
    if let Some(path) = &args.figure {
        let [width, height] = view.size();
        let title = format!("{}, {width}x{height}, {}", view.scene.name, view.device.info().name);
        report::write_text(&figure::draw(&figure::curves(&results), &title)?, path)?;
    }
    if let Some(path) = &args.markdown {
        report::write_text(&report::markdown(&results, &plan, args.blocks), path)?;
    }
    if let Some(folder) = &args.heatmaps {
        heatmaps::write(&results, &truth, view.size(), folder)?;
    }
    Ok(())
}
