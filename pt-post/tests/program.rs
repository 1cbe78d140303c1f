//! The stage program from file to file.

use pt_core::image_file::{Layer, LayeredImage, LinearImage};
use std::path::Path;
use std::process::{Command, Output};

fn pt_post(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pt-post")).args(arguments).current_dir(folder).output().unwrap()
}

#[test]
fn radiance_to_picture() {
    let folder = tempfile::tempdir().unwrap();
    let mut image = LayeredImage::new(2, 1).unwrap();
    let values = [0.6, 1.2, 0.0, 1.0, 0.6, 0.6, f32::NAN, 1.0];
    image.layers.push(Layer::from_interleaved("", &["R", "G", "B", "A"], 4, &values));
    image.write_exr(&folder.path().join("in.exr")).unwrap();

    let done = pt_post(&["in.exr", "-o", "out.png", "--tonemap", "none", "--ev", "0"], folder.path());
    assert!(done.status.success(), "{done:?}");
    assert!(String::from_utf8_lossy(&done.stdout).contains("2x1, EV100 0.000"), "{done:?}");
    let picture = LinearImage::read(&folder.path().join("out.png")).unwrap();
    let half = picture.pixels[0][0];
    assert!((half - 0.5).abs() < 0.005);
    assert_eq!(picture.pixels, [[half, 1.0, 0.0], [half, half, 0.0]]);

    for (arguments, expected) in [
        (["out.png", "-o", "x.png"], "out.png: already tone-mapped"),
        (["none.exr", "-o", "x.png"], "none.exr"),
        (["in.exr", "-o", "x.exr"], "only png"),
    ] {
        let failed = pt_post(&arguments, folder.path());
        let message = String::from_utf8_lossy(&failed.stderr).into_owned();
        assert_eq!(failed.status.code(), Some(2), "{message}");
        assert!(message.contains(expected) && message.lines().count() == 1, "{message}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "no partial output");
}
