//! The stage program on a file.

use pt_checkerboard::{CheckerboardParams, Interleave};
use pt_core::capture::read_layer;
use pt_core::test_support::{TestDevice, record_folder};
use pt_core::{ChannelImages, FrameSizes, Recorder, StageInputs};
use pt_image::image_file::{Layer, LayeredImage};
use pt_shaders::channels::{COLOR, FLAT_COLOR, FLAT_MOTION, MOTION};
use std::process::Command;

#[test]
fn reports_the_reconstruction_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("in.exr");
    let mut image = LayeredImage::new(5, 3).unwrap();
    let values: Vec<f32> = (0..45).map(|v| v as f32).collect();
    image.layers.push(Layer::from_interleaved("", &["R", "G", "B"], 3, &values));
    image.write_exr(&path).unwrap();
    let run = |flags: &str| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_pt-checkerboard"));
        let done = program.arg(&path).args(["--flags", flags]).output().unwrap();
        assert!(done.status.success(), "{done:?}");
        String::from_utf8(done.stdout).unwrap()
    };
    assert!(run("1").contains("5x3: 0 pixels altered, largest difference 0,"));
    // A ramp is kept by the blend except at the borders, where neighbours are missing.
    let blended = run("6");
    assert!(blended.contains("5x3: 12 pixels altered"), "{blended}");

    let mut program = Command::new(env!("CARGO_BIN_EXE_pt-checkerboard"));
    let failed = program.arg(folder.path().join("none.exr")).output().unwrap();
    assert_eq!(failed.status.code(), Some(2));
}

#[test]
fn compares_the_schemes() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, width: u32, value: fn(usize) -> f32| {
        let mut image = LayeredImage::new(width, 4).unwrap();
        let values: Vec<f32> = (0..width as usize * 12).map(value).collect();
        image.layers.push(Layer::from_interleaved("", &["R", "G", "B"], 3, &values));
        image.write_exr(&folder.path().join(name)).unwrap();
    };
    write("a.exr", 7, |v| 1.0 + 0.05 * (v / 3 % 7) as f32);
    write("b.exr", 7, |v| 4.0 - 0.05 * (v / 21) as f32);
    write("c.exr", 8, |_| 1.0);
    let run = |second: &str| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_pt-checkerboard"));
        program.current_dir(folder.path()).args(["a.exr", "--refraction", second]).output().unwrap()
    };
    let done = run("b.exr");
    assert!(done.status.success(), "{done:?}");
    let text = String::from_utf8(done.stdout).unwrap();
    let row = |start: &str| {
        let line = text.lines().find(|line| line.starts_with(start)).unwrap_or_else(|| panic!("{text}"));
        line[30..].split_whitespace().map(|v| v.parse::<f64>().unwrap()).collect::<Vec<_>>()
    };
    let (blend, swap) = (row("both alike    blend"), row("both alike    swap"));
    assert!(blend[0] > 0.0 && blend[0] == blend[3], "{text}");
    assert!(swap[0] > blend[0] && swap[1] < 1e-12, "{text}");
    assert!(blend[4] == 0.0 && swap[4] > 0.05, "{text}");
    assert_eq!(run("c.exr").status.code(), Some(2));
}

/// The recorded fields of a folder's frame become the flat image that the frame had, bit by bit.
#[test]
fn interleaves_a_recorded_frame() {
    let device = TestDevice::open();
    let images = ChannelImages::alone(&device, FrameSizes::same([13, 7]), &[Interleave::IO]).unwrap();
    for id in [COLOR, MOTION] {
        let texels: u32 = images.current(id).extent().iter().product();
        // The last component of the colour holds the flags.
        let flags = |i: u32| id == COLOR && i % 4 == 3;
        let value = |i: u32| if flags(i) { i / 4 % 7 } else { i * 7919 % 613 } as f32;
        let values: Vec<f32> = (0..texels * id.channel().format.components()).map(value).collect();
        images.current(id).write_f32(&values).unwrap();
    }
    let stage = Interleave::new(&device).unwrap();
    let mut recorder = Recorder::new(&device).unwrap();
    let mut frame = recorder.begin().unwrap();
    stage.record(&mut frame, &StageInputs::new(&images), &CheckerboardParams::default()).unwrap();
    frame.submit().unwrap();
    recorder.finish().unwrap();

    let folder = tempfile::tempdir().unwrap();
    record_folder(&folder.path().join("frames"), &images, 3..5);
    let run = |arguments: &[&str]| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_pt-checkerboard"));
        program.current_dir(folder.path()).args(arguments).output().unwrap()
    };
    let done = run(&["frames", "-o", "out.exr", "--frames", "1"]);
    assert!(done.status.success(), "{done:?}");
    let out = LayeredImage::read_exr(&folder.path().join("out.exr")).unwrap();
    for id in [FLAT_COLOR, FLAT_MOTION] {
        let layer = read_layer(&images, id).unwrap().0;
        for channel in &layer.channels {
            assert_eq!(out.channel(&layer.name, &channel.name), Some(&channel.samples), "{}", layer.name);
        }
    }
    std::fs::remove_file(folder.path().join("frames/frame_000003.exr")).unwrap();
    let failed = run(&["frames"]);
    let message = String::from_utf8_lossy(&failed.stderr).into_owned();
    assert_eq!(failed.status.code(), Some(2), "{message}");
    assert!(message.contains("frame_000003.exr") && message.lines().count() == 1, "{message}");
}
