//! Ground truth of direct light, written as an image. Exit codes: 0 done, 2 usage or environment.

#![forbid(unsafe_code)]

use anyhow::{Context, Result, ensure};
use clap::Parser;
use pt_core::console;
use pt_image::image_file::{Layer, LayeredImage, OutputFormat, check_output, check_size};
use pt_import::LoadOptions;
use pt_reference::direct::{DirectLight, Quality};
use pt_scene::BadTexels;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Integrates direct light on opaque Lambertian surfaces, deterministically, on the CPU.
#[derive(Parser)]
#[command(version)]
struct Args {
    /// glTF file or built-in scene.
    scene: String,
    /// Lat-long environment, .hdr or .exr.
    #[arg(long, value_name = "FILE")]
    env: Option<PathBuf>,
    /// Load an environment with negative, infinite or undefined values: they are set to 0 or to the largest half-precision number.
    #[arg(long, requires = "env")]
    env_clamp: bool,
    /// Width x height in pixels.
    #[arg(long, default_value = "64x64", value_parser = size)]
    size: [u32; 2],
    /// Samples per pixel.
    #[arg(long, default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pixel: u32,
    /// Points along each side of the grid on an emissive triangle.
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=256))]
    emitter: u32,
    /// Rows of the grid on the environment.
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=1024))]
    environment: u32,
    /// EXR to write, linear scene radiance.
    #[arg(short, long, value_name = "OUT.exr")]
    output: PathBuf,
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let wrong = || format!("{text:?} is not WIDTHxHEIGHT");
    let (width, height) = text.split_once('x').ok_or_else(wrong)?;
    let size: [u32; 2] = [width.parse().map_err(|_| wrong())?, height.parse().map_err(|_| wrong())?];
    check_size(size[0].into(), size[1].into()).map_err(|e| e.to_string())?;
    Ok(size)
}

fn main() -> ExitCode {
    console::program(|args, out| run(args, out).map(|()| true))
}

fn run(args: &Args, out: &mut impl Write) -> Result<()> {
    let format = check_output(&args.output)?;
    ensure!(format == OutputFormat::Exr, "{}: the output is linear radiance, an .exr", args.output.display());
    let options = LoadOptions {
        environment: args.env.clone(),
        bad_texels: BadTexels::clamp_if(args.env_clamp),
        ..LoadOptions::default()
    };
    let scene = pt_import::open(&args.scene, &options)?;
    scene.notices.iter().for_each(|notice| console::print_warning(notice));
    let quality = Quality { pixel: args.pixel, emitter: args.emitter, environment: args.environment };
    let light = DirectLight::new(&scene, quality)?;
    let pixels = light.image(&scene.default_camera(), args.size)?;
    let values: Vec<f32> = pixels.iter().flatten().map(|&c| c as f32).collect();
    let mut image = LayeredImage::new(args.size[0], args.size[1])?;
    image.layers.push(Layer::from_interleaved("", &["R", "G", "B"], 3, &values));
    image.write_exr(&args.output).context("writing the image")?;
    let [width, height] = args.size;
    writeln!(out, "{}: {width}x{height}, {} samples a pixel", args.output.display(), args.pixel)?;
    Ok(())
}
