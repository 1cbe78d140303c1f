//! The stage program on a file.

use pt_core::image_file::{Layer, LayeredImage};
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
