//! Runs exposure and tone mapping alone: scene radiance from a file to a picture. Exit codes: 0 done, 2 usage or environment.

#![forbid(unsafe_code)]

use anyhow::{Result, bail, ensure};
use clap::{Parser, ValueEnum};
use pt_core::image_file::{ImageState, LinearImage, OutputFormat, PixelLayout, check_output, write_png};
use pt_core::settings::Validate;
use pt_core::{ChannelImages, Device, DeviceOptions, Recorder};
use pt_post::{ExposureMode, PostParams, Radiance, ToneMap, Tonemap};
use pt_shaders::channels::{DISPLAY, FLAT_COLOR};
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
    /// Tone curve.
    #[arg(long, value_enum, default_value_t = Curve::Aces)]
    tonemap: Curve,
    /// Exposure value at ISO 100, or auto.
    #[arg(long, value_name = "X|auto", default_value = "auto", value_parser = exposure_value, allow_hyphen_values = true)]
    ev: ExposureValue,
    /// Exposure compensation in stops; positive is brighter.
    #[arg(long, value_name = "X", default_value_t = 0.0, allow_hyphen_values = true)]
    compensation: f32,
    /// Auto: metered range of the histogram, as two fractions [default: that of the stage].
    #[arg(long, num_args = 2, value_names = ["LOW", "HIGH"])]
    meter: Option<Vec<f32>>,
    /// Device, by index or part of its name [default: the best].
    #[arg(long)]
    device: Option<String>,
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
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(2)
        }
    }
}

fn params(args: &Args) -> Result<PostParams> {
    let mut params = PostParams { compensation: args.compensation, ..Default::default() };
    if let ExposureValue::Ev100(ev100) = args.ev {
        (params.exposure, params.ev100) = (ExposureMode::Manual, ev100);
    }
    if let Some([low, high]) = args.meter.as_deref() {
        (params.meter_low, params.meter_high) = (*low, *high);
    }
    params.tonemap = match args.tonemap {
        Curve::Aces => Tonemap::Aces,
        Curve::Reinhard => Tonemap::Reinhard,
        Curve::None => Tonemap::None,
    };
    params.validate()?;
    Ok(params)
}

fn run(args: &Args) -> Result<()> {
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

    let device = Device::open(&DeviceOptions { device: args.device.clone(), validation: false })?;
    let images = ChannelImages::new(&device, size, [FLAT_COLOR, DISPLAY])?;
    images.current(FLAT_COLOR).write(bytemuck::cast_slice(&texels))?;
    let stage = ToneMap::new(&device)?;
    let mut recorder = Recorder::new(&device)?;
    let mut frame = recorder.begin()?;
    stage.record(&mut frame, &images, Radiance::Frame, &params)?;
    frame.submit()?;
    let ms = recorder.finish()?[0].gpu_ms;

    let exposure = stage.exposure()?;
    let rgb: Vec<u8> =
        images.current(DISPLAY).read()?.chunks_exact(4).flat_map(|c| [c[0], c[1], c[2]]).collect();
    write_png(&args.output, image.width, image.height, PixelLayout::Rgb, &rgb)?;
    println!(
        "{}: {}x{}, EV100 {:.3}, radiance x {:.5}, {} pixels metered, {ms:.3} ms, {}",
        args.output.display(),
        image.width,
        image.height,
        exposure.ev100,
        exposure.scale,
        exposure.metered_pixels,
        device.info().name
    );
    Ok(())
}
