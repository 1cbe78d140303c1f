//! Opens the window and runs the renderer behind it.

use super::args::ViewArgs;
use super::{content, frames, hand_out};
use crate::session::{Session, choose_camera, open_scene};
use anyhow::{Result, bail, ensure};
use pt_core::DeviceOptions;
use pt_core::console::print_warning;
use pt_gbuffer::hidden_lobes;
use pt_scene::automatic_camera;
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
    let (args, of_thread) = (args.clone(), device.clone());
    let start = move || -> Result<Box<dyn Frames>, Failure> {
        let session = Session::on(&of_thread, args.frame.device.backend, &args.frame.camera, scene)?;
        Ok(Box::new(frames::ViewFrames::new(args, kept, params, session, camera)?))
    };
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
