//! `pt render` with the options of the picture, from the command line to the file.

use pt_image::image_file::{LayeredImage, LinearImage};
use std::process::Command;

/// Upscaling, bloom and HDR output from the command line.
#[test]
fn pictures_are_upscaled_and_encoded() {
    let folder = tempfile::tempdir().unwrap();
    let picture = |name: &str| folder.path().join(name);
    let render = |name: &str, options: &str| {
        let path = picture(name);
        let line = format!(
            "render cornell --size 48x32 --backend compute --frames 2 {options} -o {}",
            path.display()
        );
        let mut program = Command::new(env!("CARGO_BIN_EXE_pt"));
        let done = program.args(line.split_whitespace()).output().unwrap();
        assert!(done.status.success(), "{options}: {done:?}");
        path
    };
    for (name, options) in [
        ("taau.png", "--upscale taau --render-scale 0.5 --bloom --tonemap noise-aware"),
        ("fsr.png", "--upscale fsr1 --render-scale quality --tonemap agx --ev 3"),
        ("q2rtx.png", "--profile q2rtx --bloom=chain"),
    ] {
        let image = LinearImage::read(&render(name, options)).unwrap();
        assert_eq!((image.width, image.height), (48, 32), "{options}");
        assert!(image.pixels.iter().flatten().any(|v| *v > 0.02), "{options}: black");
    }
    let hdr = std::fs::read(render("pq.png", "--set post.encoding=pq --validation")).unwrap();
    assert!(hdr.windows(4).any(|w| w == b"cICP"));
    // The linear image of a temporally upscaled frame has the size of the picture, and its header says how it was exposed.
    let exr = LayeredImage::read_exr(&render("taau.exr", "--upscale taau --render-scale 0.5")).unwrap();
    assert_eq!((exr.width, exr.height), (48, 32));
    for key in ["ev100", "exposure", "jitter"] {
        assert!(exr.metadata.contains_key(key), "{key}");
    }
}

/// The very program that users run: the layer is switched on from outside and prints what it finds.
#[test]
fn a_frame_is_silent_under_the_validation_layer() {
    let folder = tempfile::tempdir().unwrap();
    let done = Command::new(env!("CARGO_BIN_EXE_pt"))
        .current_dir(&folder)
        .args("render cornell --size 160x90 --frames 2 -o frame.png -o frame.exr".split(' '))
        .env("VK_INSTANCE_LAYERS", "VK_LAYER_KHRONOS_validation")
        // Synchronization validation; older layers read the second name.
        .env("VK_KHRONOS_VALIDATION_VALIDATE_SYNC", "true")
        .env("VK_LAYER_ENABLES", "VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&[done.stdout, done.stderr].concat()).into_owned();
    assert!(done.status.success(), "{said}");
    for complaint in ["VUID-", "SYNC-HAZARD", "Validation Error", "Validation Warning"] {
        assert!(!said.contains(complaint), "{said}");
    }
    for image in ["frame.png", "frame.exr"] {
        assert!(folder.path().join(image).metadata().unwrap().len() > 0, "{image} is empty");
    }
}
