//! The harness on files, and what the stage refuses.

use pt_core::frame::Uniforms;
use pt_core::settings::Knobs;
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, Error, FrameSizes, Recorder, StageInputs};
use pt_image::image_file::{Layer, LayeredImage};
use pt_indirect::records::BounceReuse;
use pt_indirect::{BounceLights, IndirectLighting, IndirectParams};
use pt_light_sampling::LightTables;
use pt_scene::builtin;
use pt_scene::gpu::GpuScene;
use pt_shaders::records::{FrameRecord, LightSampler};
use std::path::Path;
use std::process::{Command, Output};

fn run(path: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pt-indirect")).arg(path).output().unwrap()
}

/// A 128x64 environment; `radiance` of the row (0 at +Y) and the column.
fn write(path: &Path, radiance: impl Fn(usize, usize) -> f32) {
    let values: Vec<f32> = (0..128 * 64 * 3).map(|i| radiance(i / 384, i / 3 % 128)).collect();
    let mut image = LayeredImage::new(128, 64).unwrap();
    image.layers.push(Layer::from_interleaved("", &["R", "G", "B"], 3, &values));
    image.write_exr(path).unwrap();
}

/// The table's lines, in the order of the axes, with the error in percent; NaN where there is none.
fn table(path: &Path) -> Vec<(String, f64)> {
    let done = run(path);
    assert!(done.status.success(), "{done:?}");
    let text = String::from_utf8(done.stdout).unwrap();
    let error = |line: &str| line.trim_end_matches(" %").rsplit(' ').next()?.parse().ok();
    text.lines().skip(2).map(|line| (line.into(), error(line).unwrap_or(f64::NAN))).collect()
}

#[test]
fn what_the_representation_holds_and_what_it_loses() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("env.exr");
    write(&path, |_, _| 3.0);
    assert!(table(&path).iter().all(|(_, error)| error.abs() < 0.5), "constant: {:?}", table(&path));
    // The upper half: pi upwards, pi/2 sideways and nothing from below are all held.
    write(&path, |row, _| if row < 32 { 1.0 } else { 0.0 });
    let half = table(&path);
    assert_eq!(half.len(), 6);
    assert!([0, 1, 2, 4, 5].iter().all(|&i| half[i].1.abs() < 0.5), "{half:?}");
    assert!(half[2].0.starts_with("+Y      3.14") && half[0].0.starts_with("+X      1.57"), "{half:?}");
    assert!(half[3].0.ends_with('-'), "black has no relative error: {half:?}");
    // A beam from above: a quarter of it is lost where it is faced.
    write(&path, |row, _| if row == 0 { 1.0 } else { 0.0 });
    assert!((table(&path)[2].1 + 25.0).abs() < 1.0, "{:?}", table(&path));
}

#[test]
fn bad_input_is_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let empty = folder.path().join("empty.hdr");
    std::fs::write(&empty, "").unwrap();
    for path in [folder.path().join("none.exr"), empty, folder.path().into()] {
        let failed = run(&path);
        let message = String::from_utf8(failed.stderr).unwrap();
        assert_eq!(failed.status.code(), Some(2), "{message}");
        assert!(message.starts_with("error: ") && message.lines().count() == 1, "{message}");
        assert!(message.contains(&path.display().to_string()), "{message}");
        assert!(failed.stdout.is_empty());
    }
}

/// Light tables that were not prepared for the sampler of the bounce lights: the frame is refused and says what is missing. Without the check the
/// kernel reads from address 0.
#[test]
fn bounce_lights_without_their_tables_are_refused() {
    let device = TestDevice::open();
    let scene = builtin("cornell").unwrap();
    let mut gpu = GpuScene::new(&device, &scene, TraceBackend::Compute).unwrap();
    let mut lights = LightTables::new(&device, &scene).unwrap();
    lights.attach(&mut gpu);
    let bounce_lights = BounceLights::all(LightSampler::LightBvh);
    let params = IndirectParams { bounces: 1.0, ..IndirectParams::default() };
    let stage = IndirectLighting::new(&device, gpu.variant(), bounce_lights, &params, 4).unwrap();
    let images = ChannelImages::alone(&device, FrameSizes::same([4, 4]), &[IndirectLighting::IO]).unwrap();
    let uniforms = Uniforms::<FrameRecord>::new(&device, "frame_uniforms").unwrap();
    let mut recorder = Recorder::new(&device).unwrap();
    let mut frame = recorder.begin().unwrap();
    lights.update(&mut frame, &scene, &mut gpu).unwrap();
    let inputs = StageInputs { scene: Some(&gpu), uniforms: Some(&uniforms), images: &images };
    let error = stage.record(&mut frame, &inputs, &params, 0.0).unwrap_err();
    let Error::MissingTable { pass, table, .. } = &error else { panic!("{error}") };
    assert_eq!((pass.as_str(), *table), ("bounce lights", "the light tree"), "{error}");
}

/// Paths of half a bounce belong to other pixels in each frame.
#[test]
fn half_a_bounce_is_not_reused() {
    let params =
        |bounces| IndirectParams { bounces, reuse: BounceReuse::RestirGi, ..IndirectParams::default() };
    assert!(params(1.0).validate().is_ok());
    let error = params(0.5).validate().unwrap_err().to_string();
    assert!(error.contains("reuse") && error.contains("bounces=0.5"), "{error}");
}
