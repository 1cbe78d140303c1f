//! Runs the post-processing alone: any chain of its stages on linear images or captures. Exit codes: 0 done, 2 usage
//! or environment.

#![forbid(unsafe_code)]

mod chain;
mod input;
mod pipeline;

use anyhow::{Context, Result, bail, ensure};
use chain::Chain;
use clap::Parser;
use input::Source;
use pipeline::Pipeline;
use pt_core::console;
use pt_core::harness::StageArgs;
use pt_core::settings::Knobs;
use pt_image::atomic_file::check_writable;
use pt_image::image_file::OutputFormat;
use pt_post::{ExposureMode, PostParams, Tonemap};
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Applies a chain of post-processing stages to a sequence of images of linear scene radiance.
#[derive(Parser)]
#[command(version)]
struct Args {
    /// Linear scene radiance, all of one size: exr, hdr, or a folder of `pt capture`, which stands for its frames. Motion and jitter of
    /// recorded frames are used.
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// Picture (png; exr when the chain has no tonemap), or a folder when there are several.
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Stages in the order of the frame: accumulate, taa[=FACTOR], bloom[=gaussian|chain], tonemap[=CURVE], fsr=FACTOR, sharpen.
    #[arg(long, value_name = "LIST", default_value = "tonemap")]
    chain: Chain,
    /// Tone curve; the same as --set tonemap.
    #[arg(long, value_name = "CURVE", value_parser = tone_curve)]
    tonemap: Option<Tonemap>,
    /// Exposure value at ISO 100, or auto; the same as --set exposure and --set ev100.
    #[arg(long, value_name = "X|auto", value_parser = exposure_value, allow_hyphen_values = true)]
    ev: Option<ExposureValue>,
    /// Exposure compensation in stops, positive is brighter; the same as --set compensation.
    #[arg(long, value_name = "X", allow_hyphen_values = true)]
    compensation: Option<f32>,
    /// Auto: metered range of the histogram, as two fractions; the same as --set meter_low and --set meter_high.
    #[arg(long, num_args = 2, value_names = ["LOW", "HIGH"])]
    meter: Option<Vec<f32>>,
    /// Images per second, for eye adaptation; frames of a folder have their own time step.
    #[arg(long, value_name = "F", default_value_t = 60.0)]
    fps: f32,
    #[command(flatten)]
    stage: StageArgs,
}

fn tone_curve(text: &str) -> Result<Tonemap, String> {
    chain::named(text)
}

#[derive(Clone, Copy)]
enum ExposureValue {
    Auto,
    Ev100(f32),
}

fn exposure_value(text: &str) -> Result<ExposureValue, String> {
    match text {
        "auto" => Ok(ExposureValue::Auto),
        _ => text.parse().map(ExposureValue::Ev100).map_err(|_| "expected a number or auto".into()),
    }
}

fn main() -> ExitCode {
    console::program(|args, out| run(args, out).map(|()| true))
}

fn params(args: &Args) -> Result<PostParams> {
    let mut params: PostParams = args.stage.params()?;
    match args.ev {
        Some(ExposureValue::Ev100(ev100)) => (params.exposure, params.ev100) = (ExposureMode::Manual, ev100),
        Some(ExposureValue::Auto) => params.exposure = ExposureMode::Auto,
        None => {}
    }
    params.compensation = args.compensation.unwrap_or(params.compensation);
    if let Some([low, high]) = args.meter.as_deref() {
        (params.meter_low, params.meter_high) = (*low, *high);
    }
    params.tonemap = args.tonemap.unwrap_or(params.tonemap);
    params = args.chain.apply(params);
    params.validate()?;
    Ok(params)
}

fn run(args: &Args, out: &mut impl Write) -> Result<()> {
    let params = params(args)?;
    ensure!(args.fps > 0.0 && args.fps.is_finite(), "--fps {}: expected a number above 0", args.fps);
    let sources = Source::list(&args.inputs)?;
    let outputs = outputs(args, &sources, &params)?;
    let first = sources[0].read()?;
    let size = first.size();
    let device = args.stage.open_device()?;
    let mut pipeline = Pipeline::new(&device, size, &args.chain, params)?;
    let mut next = Some(first);
    for (source, output) in sources.iter().zip(&outputs) {
        let input = match next.take() {
            Some(first) => first,
            None => source.read()?,
        };
        let [width, height] = input.size();
        ensure!(
            [width, height] == size,
            "{}: {width}x{height} pixels, the first image has {}x{}",
            source.path().display(),
            size[0],
            size[1]
        );
        pipeline.load(&input)?;
        pipeline.run(Some(input.time_step().unwrap_or(1.0 / args.fps)))?;
        pipeline.write(output)?;
        writeln!(out, "{}: {}", output.display(), pipeline.describe()?)?;
    }
    // What was written is done; the times are those of the last image again and again.
    let times = args.stage.measure(&device, size, |frame| pipeline.record(frame, None))?;
    Ok(write!(out, "{times}")?)
}

/// Where the results go: the file itself for one image, else files in a folder.
fn outputs(args: &Args, sources: &[Source], params: &PostParams) -> Result<Vec<PathBuf>> {
    let extension = match args.chain.tonemap {
        Some(_) if params.encoding == pt_post::Encoding::Scrgb => "exr",
        Some(_) => "png",
        None => "exr",
    };
    let folder = args.output.is_dir() || args.output.extension().is_none();
    let paths: Vec<PathBuf> = if folder {
        std::fs::create_dir_all(&args.output).with_context(|| format!("{}", args.output.display()))?;
        let named = |source: &Source| {
            args.output.join(source.path().file_stem().unwrap_or_default()).with_extension(extension)
        };
        sources.iter().map(named).collect()
    } else {
        ensure!(sources.len() == 1, "{}: {} images need a folder", args.output.display(), sources.len());
        vec![args.output.clone()]
    };
    for path in &paths {
        let format = OutputFormat::of(path)?;
        let expected = if args.chain.tonemap.is_none() {
            OutputFormat::Exr
        } else {
            params.encoding.check_file(path)?
        };
        if format != expected
            || (args.chain.tonemap.is_some() && path.extension().is_some_and(|e| e != extension))
        {
            bail!("{}: only {extension} can be written here", path.display());
        }
        check_writable(path)?;
    }
    Ok(paths)
}
