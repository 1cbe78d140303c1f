//! Runs the post-processing alone: any chain of its stages on linear images or captures. Exit codes: 0 done, 2 usage
//! or environment.

#![forbid(unsafe_code)]

mod chain;
mod pipeline;

use anyhow::{Context, Result, bail, ensure};
use chain::Chain;
use clap::Parser;
use pipeline::Pipeline;
use pt_core::capture::keys;
use pt_core::console;
use pt_core::harness::StageArgs;
use pt_core::settings::Knobs;
use pt_image::atomic_file::check_writable;
use pt_image::image_file::{ImageState, LayeredImage, LinearImage, OutputFormat, Samples};
use pt_post::{ExposureMode, PostParams, Tonemap};
use pt_shaders::channels::FLAT_MOTION;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Applies a chain of post-processing stages to a sequence of images of linear scene radiance.
#[derive(Parser)]
#[command(version)]
struct Args {
    /// Linear scene radiance: exr or hdr, all of one size. Layer `flat_motion` and the jitter of a capture are used.
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
    /// Images per second, for eye adaptation.
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

/// One input.
struct Input {
    size: [u32; 2],
    color: Vec<[f32; 4]>,
    /// Zero where the file has none.
    motion: Vec<[f32; 2]>,
    jitter: [f32; 2],
}

fn run(args: &Args, out: &mut impl Write) -> Result<()> {
    let params = params(args)?;
    ensure!(args.fps > 0.0 && args.fps.is_finite(), "--fps {}: expected a number above 0", args.fps);
    let outputs = outputs(args, &params)?;
    let first = read(&args.inputs[0])?;
    let size = first.size;
    let device = args.stage.open_device()?;
    let mut pipeline = Pipeline::new(&device, size, &args.chain, params)?;
    let mut next = Some(first);
    for (path, output) in args.inputs.iter().zip(&outputs) {
        let input = match next.take() {
            Some(first) => first,
            None => read(path)?,
        };
        ensure!(
            input.size == size,
            "{}: {}x{} pixels, the first image has {}x{}",
            path.display(),
            input.size[0],
            input.size[1],
            size[0],
            size[1]
        );
        pipeline.load(&input)?;
        pipeline.run(Some(1.0 / args.fps))?;
        pipeline.write(output)?;
        writeln!(out, "{}: {}", output.display(), pipeline.describe()?)?;
    }
    // What was written is done; the times are those of the last image again and again.
    let times = args.stage.measure(&device, size, |frame| pipeline.record(frame, None))?;
    Ok(write!(out, "{times}")?)
}

/// Where the results go: the file itself for one image, else files in a folder.
fn outputs(args: &Args, params: &PostParams) -> Result<Vec<PathBuf>> {
    let extension = match args.chain.tonemap {
        Some(_) if params.encoding == pt_post::Encoding::Scrgb => "exr",
        Some(_) => "png",
        None => "exr",
    };
    let folder = args.output.is_dir() || args.output.extension().is_none();
    let paths: Vec<PathBuf> = if folder {
        std::fs::create_dir_all(&args.output).with_context(|| format!("{}", args.output.display()))?;
        let named =
            |path: &PathBuf| args.output.join(path.file_stem().unwrap_or_default()).with_extension(extension);
        args.inputs.iter().map(named).collect()
    } else {
        ensure!(
            args.inputs.len() == 1,
            "{}: {} images need a folder",
            args.output.display(),
            args.inputs.len()
        );
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

fn read(path: &Path) -> Result<Input> {
    let image = LinearImage::read(path)?;
    ensure!(
        image.state == ImageState::SceneReferred,
        "{}: already tone-mapped, scene radiance (exr, hdr) is needed",
        path.display()
    );
    let mut input = Input {
        size: [image.width, image.height],
        color: image.pixels.iter().map(|c| [c[0], c[1], c[2], 1.0]).collect(),
        motion: vec![[0.0; 2]; image.pixels.len()],
        jitter: [0.0; 2],
    };
    if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) {
        return Ok(input);
    }
    let capture = LayeredImage::read_exr(path)?;
    let layer = FLAT_MOTION.channel().name;
    let component = |name| capture.channel(layer, name).map(Samples::to_f32);
    if let (Some(x), Some(y)) = (component("X"), component("Y")) {
        input.motion = x.into_iter().zip(y).map(|(x, y)| [x, y]).collect();
    }
    if let Some(text) = capture.metadata.get(keys::JITTER) {
        let parsed = text.split_once(',').and_then(|(x, y)| Some([x.parse().ok()?, y.parse().ok()?]));
        input.jitter = parsed.with_context(|| format!("{}: jitter {text:?} is no pair", path.display()))?;
    }
    Ok(input)
}
