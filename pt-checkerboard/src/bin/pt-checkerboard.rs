//! Runs the interleave alone: an image is sorted into its checkerboard fields on the host and interleaved again on the
//! device. Of a capture folder, the recorded fields are interleaved. With a second image, the schemes for surfaces that reflect one and refract the other are compared. Exit codes: 0
//! done, 1 pixels of regular surfaces came back altered, 2 usage or environment.

#![forbid(unsafe_code)]

use anyhow::{Result, ensure};
use clap::Parser;
use pt_checkerboard::study::{Scheme, SplitSurface};
use pt_checkerboard::{CheckerboardParams, Interleave};
use pt_core::harness::{HarnessError, ReplayArgs, StageArgs, replay};
use pt_core::split::to_split;
use pt_core::{ChannelImages, Frame, FrameSizes, StageInputs, console};
use pt_image::image_file::LinearImage;
use pt_image::metrics::{Metric, compare};
use pt_shaders::channels::{COLOR, FLAT_COLOR};
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Splits an image into checkerboard fields, interleaves them again on the device and reports the difference.
#[derive(Parser)]
#[command(version)]
struct Args {
    /// Image (exr, hdr, png or jpg), or a folder of `pt capture`, of which the first frame's fields are interleaved.
    input: PathBuf,
    /// EXR to write: the interleaved channels of a folder's frame.
    #[arg(short, long, value_name = "OUT.exr")]
    output: Option<PathBuf>,
    /// Checkerboard flags of every pixel: 1 primary, 2 reflection, 4 refraction; with several flags the fields are blended.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u8).range(0..8))]
    flags: u8,
    /// Second image of the same size: prints the error of each scheme for a surface that reflects the first and refracts this
    /// one, at equal numbers of rays.
    #[arg(long, value_name = "IMAGE")]
    refraction: Option<PathBuf>,
    #[command(flatten)]
    stage: StageArgs,
}

fn main() -> ExitCode {
    console::program(run)
}

fn run(args: &Args, out: &mut impl Write) -> Result<bool> {
    if args.input.is_dir() {
        interleave_recorded(args, out)?;
        return Ok(true);
    }
    ensure!(
        args.output.is_none(),
        "--output needs a folder of pt capture, {} is a file",
        args.input.display()
    );
    let params: CheckerboardParams = args.stage.params()?;
    let image = LinearImage::read(&args.input)?;
    let size = [image.width, image.height];
    if let Some(path) = &args.refraction {
        let refraction = LinearImage::read(path)?;
        ensure!(
            size == [refraction.width, refraction.height],
            "{}: {}x{} pixels, the first image has {}x{}",
            path.display(),
            refraction.width,
            refraction.height,
            size[0],
            size[1]
        );
        compare_schemes(&image, &refraction, out)?;
        return Ok(true);
    }
    let flags = f32::from(args.flags);
    let texels: Vec<[f32; 4]> = image.pixels.iter().map(|c| [c[0], c[1], c[2], flags]).collect();

    let device = args.stage.open_device()?;
    let images = ChannelImages::alone(&device, FrameSizes::same(size), &[Interleave::IO])?;
    images.current(COLOR).write_f32(to_split(&texels, size, [0.0; 4]).as_flattened())?;
    let stage = Interleave::new(&device)?;
    let inputs = StageInputs::new(&images);
    let times = args.stage.measure(&device, size, |frame| stage.record(frame, &inputs, &params))?;
    write!(out, "{times}")?;

    let flat = images.current(FLAT_COLOR).read_f32()?;
    let mut altered = 0usize;
    let mut largest = 0.0f32;
    let mut squares = 0.0f64;
    for (before, after) in texels.iter().zip(flat.chunks_exact(4)) {
        // By bits, so that NaN pixels count as unaltered when they are.
        altered += usize::from(before.iter().zip(after).any(|(b, a)| b.to_bits() != a.to_bits()));
        for (b, a) in before.iter().zip(after).take(3) {
            largest = largest.max((b - a).abs());
            squares += f64::from(b - a).powi(2);
        }
    }
    let [width, height] = size;
    let rmse = (squares / (3 * texels.len()) as f64).sqrt();
    writeln!(
        out,
        "{width}x{height}: {altered} pixels altered, largest difference {largest}, RMSE {rmse:.3e}"
    )?;
    let blended = params.blend_split && args.flags.count_ones() > 1;
    Ok(blended || altered == 0)
}

fn interleave_recorded(args: &Args, out: &mut impl Write) -> Result<(), HarnessError> {
    let Args { input, output, stage, .. } = args;
    let args = ReplayArgs { capture: input.clone(), output: output.clone(), stage: stage.clone() };
    replay(&args, &[Interleave::IO], out, |device, _, params: CheckerboardParams| {
        let stage = Interleave::new(device)?;
        Ok(move |frame: &mut Frame<'_>, inputs: &StageInputs<'_>| stage.record(frame, inputs, &params))
    })
}

/// Shares of the reflection that stand for a mirror-like, an even and a clear surface.
const SHARES: [(&str, f32); 3] = [("reflections", 0.9), ("both alike", 0.5), ("refractions", 0.1)];
/// Rays for each pixel.
const BUDGETS: [u32; 4] = [1, 2, 8, 32];

fn compare_schemes(reflection: &LinearImage, refraction: &LinearImage, out: &mut impl Write) -> Result<()> {
    let size = [reflection.width, reflection.height];
    let image = |pixels| LinearImage { pixels, ..reflection.clone() };
    let error = |a: Vec<[f32; 3]>, b: &LinearImage| -> Result<f64> {
        Ok(compare(&image(a), b, &[Metric::Flip])?[0].value)
    };
    writeln!(
        out,
        "FLIP of display values against the sum of both paths, by rays for each pixel; flicker: FLIP of two successive frames"
    )?;
    write!(out, "{:<12}  {:<16}", "surface", "scheme")?;
    BUDGETS.iter().try_for_each(|rays| write!(out, "  {rays:>10}"))?;
    writeln!(out, "  {:>10}", "flicker")?;
    for (name, share) in SHARES {
        let surface =
            SplitSurface { size, reflection: &reflection.pixels, refraction: &refraction.pixels, share };
        let truth = image(surface.truth());
        for scheme in Scheme::ALL {
            write!(out, "{name:<12}  {:<16}", scheme.name())?;
            for rays in BUDGETS {
                write!(out, "  {:>10.4}", error(surface.shown(scheme, rays, 0), &truth)?)?;
            }
            let flicker = error(surface.shown(scheme, 1, 1), &image(surface.shown(scheme, 1, 0)))?;
            writeln!(out, "  {flicker:>10.4}")?;
        }
    }
    Ok(writeln!(out, "diffuse and other regular surfaces: 0 with every scheme, they have one path")?)
}
