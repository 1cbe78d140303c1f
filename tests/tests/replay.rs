//! Stages alone on the capture of a whole frame write what they wrote in the frame.

use clap::Parser;
use pt_app::args::CameraArgs;
use pt_app::cli::{Cli, Command};
use pt_app::frame::bounce_lights;
use pt_app::params::FrameParams;
use pt_app::session::Session;
use pt_checkerboard::{CheckerboardParams, Interleave};
use pt_core::capture::folder::CaptureFolder;
use pt_core::capture::read_layer;
use pt_core::frame::Uniforms;
use pt_core::harness::{ReplayArgs, replay};
use pt_core::settings::Knobs;
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, Device, Frame, FramePlan, FrameSizes, Recorder, Result};
use pt_core::{SplitLight, StageInputs, StageIo};
use pt_denoise::{Composite, DenoiseParams};
use pt_image::image_file::LayeredImage;
use pt_indirect::{IndirectLighting, IndirectParams};
use pt_shaders::channels::{COLOR_LF_COCG, COLOR_LF_SH};
use pt_tests::builtin;
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
    let line = "pt render cornell --size 33x18 --aov all --backend compute --set denoise.variant=off -o";
    let line = line.split(' ').chain([&frame[..]]);
    let Command::Render(args) = Cli::try_parse_from(line).unwrap().command else {
        unreachable!("a render command")
    };
    assert!(pt_app::commands::render::run(&args, &mut Vec::new()).unwrap());

    let composite = [SplitLight::UNFILTERED_INDIRECT, Composite::IO_INDIRECT];
    check(folder.path(), &composite, |device, _, params: DenoiseParams| {
        let stage = Composite::with_indirect(device)?;
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

/// Bounce rays on a recorded G-buffer find the light that they found in the frame, to the bit, and other light with other knobs.
#[test]
fn indirect_light_repeats_its_frame() {
    let folder = tempfile::tempdir().unwrap();
    let capture = folder.path().join("capture").display().to_string();
    let line = [
        "pt",
        "capture",
        "cornell",
        "--size",
        "33x18",
        "--frames",
        "0..2",
        "--backend",
        "compute",
        "-o",
        &capture,
    ];
    let Command::Capture(args) = Cli::try_parse_from(line).unwrap().command else {
        unreachable!("a capture command")
    };
    assert!(pt_app::commands::capture::run(&args, &mut Vec::new()).unwrap());
    let recorded = CaptureFolder::open(Path::new(&capture)).unwrap().frame(1).unwrap();

    let device = TestDevice::open();
    let mut session =
        Session::on(&device, TraceBackend::Compute, &CameraArgs::default(), builtin("cornell")).unwrap();
    let params = FrameParams::default();
    let Session { device, scene, gpu, lights, .. } = &mut session;
    lights.prepare(device, scene, gpu, params.lights.sampler_choice()).unwrap();
    let lights = bounce_lights(&params.lights);
    let most = IndirectParams { bounces: 3.0, ..IndirectParams::default() };
    let stage = IndirectLighting::new(&session.device, session.gpu.variant(), lights, &most, 4).unwrap();
    let sizes = FrameSizes::same([33, 18]);
    let images = ChannelImages::alone(&session.device, sizes, &[IndirectLighting::IO]).unwrap();
    let given: Vec<_> = FramePlan::new(sizes).missing(&[IndirectLighting::IO]).into_iter().collect();
    recorded.load(&images, &given).unwrap();
    let uniforms = Uniforms::new(&session.device, "frame_uniforms").unwrap();
    let mut recorder = Recorder::new(&session.device).unwrap();
    let mut light = |bounces: f32| {
        let mut frame = recorder.begin().unwrap();
        session.update(&mut frame, 0.0, 0.0).unwrap();
        uniforms.upload(&mut frame, &recorded.sidecar.record()).unwrap();
        let inputs = StageInputs { scene: Some(&session.gpu), uniforms: Some(&uniforms), images: &images };
        stage
            .record(&mut frame, &inputs, &IndirectParams { bounces, ..IndirectParams::default() }, 0.0)
            .unwrap();
        frame.submit().unwrap();
        recorder.finish().unwrap();
        [COLOR_LF_SH, COLOR_LF_COCG].map(|id| read_layer(&images, id).unwrap().0)
    };
    let (one, three) = (light(1.0), light(3.0));
    let image = recorded.into_image();
    for (layer, other) in one.iter().zip(&three) {
        for channel in &layer.channels {
            let found = image.channel(&layer.name, &channel.name) == Some(&channel.samples);
            assert!(found, "{}.{} is another one when lit again", layer.name, channel.name);
        }
        assert!(layer != other, "{}: three bounces are not one", layer.name);
    }
}
