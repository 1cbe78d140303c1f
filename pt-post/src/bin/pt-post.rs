//! Runs exposure and tone mapping alone: scene radiance from a file to a picture. Exit codes: 0 done, 2 usage or environment.

#![forbid(unsafe_code)]

use anyhow::{Result, bail, ensure};
use clap::{Parser, ValueEnum};
use pt_core::harness::StageArgs;
use pt_core::image_file::{ImageState, LinearImage, OutputFormat, PixelLayout, check_output, write_png};
use pt_core::settings::Validate;
use pt_core::{ChannelImages, Frame, console};
use pt_post::{ExposureMode, PostParams, Radiance, ToneMap, Tonemap};
use pt_shaders::channels::{DISPLAY, FLAT_COLOR};
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Exposes and tone-maps linear scene radiance.
#[derive(Parser)]
#[command(version)]
struct Args {
    /// Linear scene radiance: exr or hdr.
    input: PathBuf,
    /// Picture to write (sRGB).
    #[arg(short, long, value_name = "OUT.png")]
    output: PathBuf,
    /// Tone curve; short for --set tonemap.
    #[arg(long, value_enum)]
    tonemap: Option<Curve>,
    /// Exposure value at ISO 100, or auto; short for --set exposure and --set ev100.
    #[arg(long, value_name = "X|auto", value_parser = exposure_value, allow_hyphen_values = true)]
    ev: Option<ExposureValue>,
    /// Exposure compensation in stops, positive is brighter; short for --set compensation.
    #[arg(long, value_name = "X", allow_hyphen_values = true)]
    compensation: Option<f32>,
    /// Auto: metered range of the histogram, as two fractions; short for --set meter_low and --set meter_high.
    #[arg(long, num_args = 2, value_names = ["LOW", "HIGH"])]
    meter: Option<Vec<f32>>,
    #[command(flatten)]
    stage: StageArgs,
}

#[derive(Clone, Copy, ValueEnum)]
enum Curve {
    Aces,
    Reinhard,
    None,
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
    params.tonemap = match args.tonemap {
        Some(Curve::Aces) => Tonemap::Aces,
        Some(Curve::Reinhard) => Tonemap::Reinhard,
        Some(Curve::None) => Tonemap::None,
        None => params.tonemap,
    };
    params.validate()?;
    Ok(params)
}

fn run(args: &Args, out: &mut impl Write) -> Result<()> {
    let params = params(args)?;
    if check_output(&args.output)? != OutputFormat::Png {
        bail!("{}: only png can be written here", args.output.display());
    }
    let image = LinearImage::read(&args.input)?;
    ensure!(
        image.state == ImageState::SceneReferred,
        "{}: already tone-mapped, scene radiance (exr, hdr) is needed",
        args.input.display()
    );
    let size = [image.width, image.height];
    let texels: Vec<[f32; 4]> = image.pixels.iter().map(|c| [c[0], c[1], c[2], 1.0]).collect();

    let device = args.stage.open_device()?;
    let images = ChannelImages::new(&device, size, [FLAT_COLOR, DISPLAY])?;
    images.current(FLAT_COLOR).write_f32(texels.as_flattened())?;
    let stage = ToneMap::new(&device)?;
    let record = |frame: &mut Frame<'_>| stage.record(frame, &images, Radiance::Frame, &params);
    write!(out, "{}", args.stage.measure(&device, size, record)?)?;

    let exposure = stage.exposure()?;
    let rgb: Vec<u8> =
        images.current(DISPLAY).read()?.chunks_exact(4).flat_map(|c| [c[0], c[1], c[2]]).collect();
    write_png(&args.output, image.width, image.height, PixelLayout::Rgb, &rgb)?;
    writeln!(
        out,
        "{}: {}x{}, EV100 {:.3}, radiance x {:.5}, {} pixels metered",
        args.output.display(),
        image.width,
        image.height,
        exposure.ev100,
        exposure.scale,
        exposure.metered_pixels
    )?;
    Ok(())
}
