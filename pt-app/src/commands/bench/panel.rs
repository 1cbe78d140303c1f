//! `pt bench panel` measures what the panel of `pt view` costs.

use crate::commands::view::{ViewArgs, content, off_screen};
use crate::params::FrameParams;
use anyhow::{Result, ensure};
use clap::{Args, FromArgMatches};
use pt_core::harness::Spread;
use pt_core::{Device, DeviceOptions, Image};
use pt_image::image_file::ImageSize;
use pt_shaders::channels::Format;
use pt_view::Context;
use pt_view::blit::Blit;
use pt_view::headless::lay_out;
use pt_view::offscreen::Offscreen;
use pt_view::panel::Panel;
use pt_view::panel_renderer::LaidOut;
use pt_view::protocol::Status;
use std::io::Write;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// `pt bench panel`
#[derive(Clone, Debug, Args)]
pub struct BenchPanelArgs {
    /// Also show frames of this scene, a file or a built-in one, as `pt view --play` does, and count them a second with and without the panel.
    #[arg(long, value_name = "S")]
    pub scene: Option<String>,
    /// Size of window and picture in pixels.
    #[arg(long, value_name = "WxH", default_value = "1920x1080")]
    pub size: ImageSize,
    /// Pictures that are measured; so many frames of the scene are a turn.
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..))]
    pub frames: u32,
    /// Vulkan device, by index or part of its name [default: a discrete GPU before the CPU]
    #[arg(long, value_name = "D")]
    pub device: Option<String>,
}

/// Pictures before the measurement.
const WARM_UP: u32 = 8;
/// Turns with and without the panel, in which frames of the scene are counted.
const TURNS: usize = 5;
/// A device that takes so long does not work.
const PATIENCE: Duration = Duration::from_secs(60);

/// Runs the command.
///
/// # Errors
/// A scene that can't be loaded, a device that can't draw, or fails.
pub fn run(args: &BenchPanelArgs, out: &mut impl Write) -> Result<bool> {
    let size: [u32; 2] = args.size.into();
    let device = Device::open(&DeviceOptions { device: args.device.clone(), validation: false })?;
    let mut panel = Panel::new(content::of(&FrameParams::default(), &[], false)?);
    // Every key has a dot: all knobs are listed, which is the most that there is to draw.
    panel.search(".");
    if let Some(scene) = &args.scene {
        frames(args, scene, &device, &mut panel, out)?;
    }
    let mut target = Offscreen::new(&device, size)?;
    let image = Image::new(&device, "picture", Format::Rgba8Unorm, size)?;
    let whole = [0, 0, size[0] as i32, size[1] as i32];
    let blit = Blit { image, from: whole, to: whole };
    let context = Context::default();
    let mut times = [Vec::new(), Vec::new()];
    for index in 0..WARM_UP + args.frames {
        for (has_panel, times) in [false, true].into_iter().zip(&mut times) {
            let mut laid_out = has_panel.then(|| lay_out(&context, size, &mut panel, &Status::default()));
            let ms = time(&mut target, &blit, laid_out.as_mut())?;
            times.extend(ms.filter(|_| index >= WARM_UP));
        }
    }
    let [without, with] = times.map(Spread::of);
    writeln!(
        out,
        "panel at {}x{}: {:.3} ms of GPU time (95 % below {:.3} ms), without it {:.3} ms; {} pictures, {}",
        size[0],
        size[1],
        with.median_ms,
        with.p95_ms,
        without.median_ms,
        args.frames,
        device.info().name
    )?;
    Ok(true)
}

/// Counts frames of a scene a second, with and without the panel in turns.
fn frames(
    args: &BenchPanelArgs,
    scene: &str,
    device: &Device,
    panel: &mut Panel,
    out: &mut impl Write,
) -> Result<()> {
    let size = format!("{}x{}", args.size.width, args.size.height);
    let words = ["pt view", scene, "--size", &size, "--profile", "realtime", "--play"];
    let view = ViewArgs::augment_args(clap::Command::new("pt view")).try_get_matches_from(words)?;
    let mut view = off_screen(&ViewArgs::from_arg_matches(&view)?, device)?;
    view.rate(WARM_UP, Some(panel))?;
    let mut rates = [const { Vec::new() }; 2];
    for _ in 0..TURNS {
        rates[0].push(view.rate(args.frames, None)?);
        rates[1].push(view.rate(args.frames, Some(panel))?);
    }
    let [without, with] = rates.map(|mut rates| {
        rates.sort_by(f64::total_cmp);
        format!("{:.2} ({:.2} to {:.2})", rates[TURNS / 2], rates[0], rates[TURNS - 1])
    });
    writeln!(
        out,
        "frames a second of {scene} at {size}: {with} with the panel, {without} without it; median, least and most of {TURNS} turns of {} frames",
        args.frames
    )?;
    Ok(())
}

/// GPU time between the picture and the end of the panel, milliseconds.
fn time(target: &mut Offscreen, blit: &Blit, mut panel: Option<&mut LaidOut>) -> Result<Option<f64>> {
    let begun = Instant::now();
    let wait = || -> Result<()> {
        ensure!(begun.elapsed() < PATIENCE, "the device does not draw");
        sleep(Duration::from_micros(100));
        Ok(())
    };
    while !target.draw(std::slice::from_ref(blit), panel.as_deref_mut())? {
        wait()?;
    }
    while !target.is_free()? {
        wait()?;
    }
    Ok(target.panel_ms())
}
