//! Stages alone on the capture of a whole frame write what they wrote in the frame.

use clap::Parser;
use pt_app::cli::{Cli, Command};
use pt_checkerboard::{CheckerboardParams, Interleave};
use pt_core::harness::{ReplayArgs, replay};
use pt_core::settings::Knobs;
use pt_core::{Device, Frame, Result};
use pt_core::{SplitLight, StageInputs, StageIo};
use pt_denoise::{Composite, DenoiseParams};
use pt_image::image_file::LayeredImage;
use std::path::Path;

#[derive(Parser)]
struct Program {
    #[command(flatten)]
    args: ReplayArgs,
}

/// Replays a stage on `frame.exr` of the folder and compares every channel that it writes, bit by bit.
fn check<P, R>(folder: &Path, stages: &[StageIo], set_up: impl FnOnce(&Device, [u32; 2], P) -> Result<R>)
where
    P: Knobs,
    R: FnMut(&mut Frame<'_>, &StageInputs<'_>) -> Result<()>,
{
    let [recorded, replayed] = ["frame.exr", "replayed.exr"].map(|name| folder.join(name));
    let words = [Path::new("stage"), &recorded, Path::new("-o"), &replayed, Path::new("--frames=1")];
    let program = Program::try_parse_from(words).unwrap();
    replay(&program.args, stages, &mut Vec::new(), set_up).unwrap();
    let [recorded, replayed] = [recorded, replayed].map(|path| LayeredImage::read_exr(&path).unwrap());
    for id in stages.iter().flat_map(|io| io.writes) {
        let name = id.channel().name;
        assert!(recorded.layer(name).is_some(), "{name}");
        assert!(recorded.layer(name) == replayed.layer(name), "{name} is another one when replayed");
    }
}

#[test]
fn stages_repeat_their_frame() {
    let folder = tempfile::tempdir().unwrap();
    let frame = folder.path().join("frame.exr").display().to_string();
    let line =
        ["pt", "render", "cornell", "--size", "33x18", "--aov", "all", "--backend", "compute", "-o", &frame];
    let Command::Render(args) = Cli::try_parse_from(line).unwrap().command else {
        unreachable!("a render command")
    };
    assert!(pt_app::commands::render::run(&args, &mut Vec::new()).unwrap());

    check(folder.path(), &[SplitLight::UNFILTERED, Composite::IO], |device, _, params: DenoiseParams| {
        let stage = Composite::new(device)?;
        Ok(move |frame: &mut Frame<'_>, inputs: &StageInputs<'_>| {
            stage.record(frame, inputs, SplitLight::unfiltered(inputs.images), &params)
        })
    });
    check(folder.path(), &[Interleave::IO], |device, _, params: CheckerboardParams| {
        let stage = Interleave::new(device)?;
        Ok(move |frame: &mut Frame<'_>, inputs: &StageInputs<'_>| stage.record(frame, inputs, &params))
    });
    let frame = LayeredImage::read_exr(&folder.path().join("frame.exr")).unwrap();
    let lit = frame.channel("color", "R").unwrap().to_f32().iter().filter(|&&v| v > 0.01).count();
    assert!(lit > 100, "{lit} pixels of the box are lit");
}
