//! The stage program on a file.

use pt_image::image_file::{Layer, LayeredImage};
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
