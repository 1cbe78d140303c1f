//! Runs the composite alone on recorded channels. Exit codes: 0 done, 2 usage or environment.
//!
//! The input is an EXR with one layer per channel, called as in the channel table; the components are R, G, B, A or
//! X, Y, Z, W in the order of the table, and the words `shading_position.material` and `view_direction.flags` may stand by
//! themselves, as `pt render --aov all` writes them. The composite is per pixel, so split and flat layout both serve.

#![forbid(unsafe_code)]

use anyhow::{Context, Result, bail, ensure};
use clap::Parser;
use pt_core::image_file::{Layer, LayeredImage, OutputFormat, Samples, check_output};
use pt_core::settings::apply_sets;
use pt_core::{ChannelImages, Device, DeviceOptions, Recorder};
use pt_denoise::{Composite, DenoiseParams, texels};
use pt_shaders::channels::{COLOR, ChannelId, SHADING_POSITION, VIEW_DIRECTION};
use std::path::PathBuf;
use std::process::ExitCode;

/// Composites recorded light channels.
#[derive(Parser)]
#[command(version)]
struct Args {
    /// Recorded channels: an EXR of even width, one layer per channel.
    capture: PathBuf,
    /// Composited radiance to write, in the layout of the input; alpha holds the checkerboard flags.
    #[arg(short, long, value_name = "OUT.exr")]
    output: PathBuf,
    /// Knob of the stage, such as scale_spec=0.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Device, by index or part of its name [default: the best].
    #[arg(long)]
    device: Option<String>,
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

/// Texels of one channel, from the layer of its name.
fn texels_of(capture: &LayeredImage, id: ChannelId) -> Result<Vec<u8>> {
    let channel = id.channel();
    // Of these two channels the composite looks at one word only.
    let word = |name| match capture.channel(channel.name, name) {
        Some(Samples::U32(words)) => Some(words),
        _ => None,
    };
    if let Some(material) = word("material").filter(|_| id == SHADING_POSITION) {
        let values: Vec<u32> = material.iter().flat_map(|&bits| [0, 0, 0, bits]).collect();
        return Ok(bytemuck::cast_slice(&values).to_vec());
    }
    if let Some(flags) = word("flags").filter(|_| id == VIEW_DIRECTION) {
        let values: Vec<u32> = flags.iter().flat_map(|&flags| [0, flags]).collect();
        return Ok(texels::encode_u32(channel.format, &values));
    }
    let planes = ["RGBA", "XYZW"].iter().find_map(|names| {
        let names = names.chars().take(channel.format.components() as usize);
        names.map(|name| capture.channel(channel.name, &name.to_string())).collect::<Option<Vec<_>>>()
    });
    let planes = planes.with_context(|| {
        let components = channel.format.components();
        format!("no layer {:?} with {components} channels (R, G, B, A or X, Y, Z, W)", channel.name)
    })?;
    let words: Option<Vec<&Vec<u32>>> =
        planes.iter().map(|plane| if let Samples::U32(words) = plane { Some(words) } else { None }).collect();
    let pixels = planes[0].len();
    Ok(match words {
        Some(words) => {
            let values: Vec<u32> = (0..pixels).flat_map(|i| words.iter().map(move |w| w[i])).collect();
            texels::encode_u32(channel.format, &values)
        }
        None => {
            let planes: Vec<Vec<f32>> = planes.iter().map(|plane| plane.to_f32()).collect();
            let values: Vec<f32> = (0..pixels).flat_map(|i| planes.iter().map(move |p| p[i])).collect();
            texels::encode(channel.format, &values)
        }
    })
}

fn run(args: &Args) -> Result<()> {
    let mut params = DenoiseParams::default();
    apply_sets(&mut params, &args.set)?;
    if check_output(&args.output)? != OutputFormat::Exr {
        bail!("{}: only exr can be written here", args.output.display());
    }
    let in_capture = || args.capture.display().to_string();
    let capture = LayeredImage::read_exr(&args.capture)?;
    let (width, height) = (capture.width, capture.height);
    ensure!(
        width % 2 == 0,
        "{}: the width must be even (two checkerboard fields), this is {width}",
        in_capture()
    );

    let device = Device::open(&DeviceOptions { device: args.device.clone(), validation: false })?;
    let channels = [Composite::READS, Composite::WRITES].concat();
    let images = ChannelImages::new(&device, [width, height], channels)?;
    for &id in Composite::READS {
        images.current(id).write(&texels_of(&capture, id).with_context(in_capture)?)?;
    }
    let stage = Composite::new(&device)?;
    let mut recorder = Recorder::new(&device)?;
    let mut frame = recorder.begin()?;
    stage.record(&mut frame, &images, &params)?;
    frame.submit()?;
    let ms = recorder.finish()?[0].gpu_ms;

    let color = images.current(COLOR).read_f32()?;
    let mut out = LayeredImage::new(width, height)?;
    out.layers.push(Layer::from_interleaved("", &["R", "G", "B", "A"], 4, &color));
    out.metadata = capture.metadata;
    out.write_exr(&args.output)?;
    println!("{}: {width}x{height}, {ms:.3} ms, {}", args.output.display(), device.info().name);
    Ok(())
}
