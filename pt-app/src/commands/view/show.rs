//! Opens the window and runs the renderer behind it.

use super::args::ViewArgs;
use super::{content, frames, hand_out};
use crate::params::FrameParams;
use crate::session::{Session, choose_camera, open_scene};
use anyhow::{Result, bail, ensure};
use pt_core::console::print_warning;
use pt_core::{Device, DeviceOptions};
use pt_gbuffer::hidden_lobes;
use pt_scene::{Camera, Scene, automatic_camera};
use pt_view::offscreen_view::OffscreenView;
use pt_view::protocol::{Failure, Frames};
use pt_view::{Opening, View};
use std::io::Write;

/// Runs the command.
///
/// # Errors
/// No display, a device that can't present, and what `pt render` fails with.
pub fn run(args: &ViewArgs, out: &mut impl Write) -> Result<bool> {
    let params = args.frame.params()?;
    frames::check_shown(&params)?;
    ensure!(args.folder.is_dir(), "{}: no such folder; give another --folder", args.folder.display());
    let view = View::new()?;
    let kept = hand_out::kept_words(std::env::args_os());
    let scene = open_scene(&args.frame.scene.file, &args.frame.scene.load_options())?;
    for notice in scene.notices.iter().chain(&hidden_lobes(&scene, &params.gbuffer)) {
        print_warning(notice);
    }
    let options =
        DeviceOptions { device: args.frame.device.device.clone(), validation: args.frame.device.validation };
    let device = view.open_device(&options)?;
    let camera = choose_camera(&scene, &args.frame.camera)?.unwrap_or_else(|| automatic_camera(&scene));
    let opening = Opening {
        title: format!("pt view: {}", scene.name),
        size: args.frame.output_size(),
        pose: frames::pose_of(&camera.at(args.frame.scene.time)),
        scene_size: scene.bounds().map_or(1.0, |bounds| bounds.size().max_element()),
        content: content::of(&params, &scene.cameras, args.frame.accumulate)?,
    };
    let start = renderer(args, kept, params, &device, scene, camera);
    let mut written = Ok(());
    let mut print = |command: &str| {
        written = writeln!(out, "{command}").and_then(|()| out.flush());
    };
    let summary = view.run(&device, opening, start, &mut print)?;
    written?;
    writeln!(out, "{summary}")?;
    match device.validation().map(|log| log.messages()) {
        Some(messages) if !messages.is_empty() => {
            bail!("{} validation messages, the first: {}", messages.len(), messages[0])
        }
        _ => Ok(true),
    }
}

/// The same frames without a window.
///
/// # Errors
/// A scene that can't be loaded, a device that can't draw.
pub(crate) fn off_screen(args: &ViewArgs, device: &Device) -> Result<OffscreenView> {
    let params = args.frame.params()?;
    let scene = open_scene(&args.frame.scene.file, &args.frame.scene.load_options())?;
    let camera = choose_camera(&scene, &args.frame.camera)?.unwrap_or_else(|| automatic_camera(&scene));
    let start = renderer(args, Vec::new(), params, device, scene, camera);
    Ok(OffscreenView::new(device, args.frame.output_size(), start)?)
}

/// Makes the renderer, on the thread on which it is called.
fn renderer(
    args: &ViewArgs,
    kept: Vec<String>,
    params: FrameParams,
    device: &Device,
    scene: Scene,
    camera: Camera,
) -> impl FnOnce() -> Result<Box<dyn Frames>, Failure> + Send + 'static {
    let (args, device) = (args.clone(), device.clone());
    move || {
        let session = Session::on(&device, args.frame.device.backend, &args.frame.camera, scene)?;
        Ok(Box::new(frames::ViewFrames::new(args, kept, params, session, camera)?))
    }
}
