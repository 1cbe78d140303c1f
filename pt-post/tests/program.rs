//! The stage program from file to file.

use pt_core::test_support::{TestDevice, record_folder};
use pt_core::{ChannelImages, FrameSizes, StageIo};
use pt_image::image_file::{Layer, LayeredImage, LinearImage};
use pt_shaders::channels::{FLAT_COLOR, FLAT_MOTION};
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

    let done = {
        let arguments =
            ["in.exr", "-o", "out.png", "--tonemap", "none", "--ev", "0", "--set", "dither=false"];
        pt_post(&arguments, folder.path())
    };
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

fn linear(path: &Path, width: u32, height: u32, value: impl Fn(u32, u32) -> f32) {
    let mut image = LayeredImage::new(width, height).unwrap();
    let values: Vec<f32> = (0..width * height).flat_map(|i| [value(i % width, i / width); 3]).collect();
    image.layers.push(Layer::from_interleaved("", &["R", "G", "B"], 3, &values));
    image.write_exr(path).unwrap();
}

#[test]
fn chains_over_several_images() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    for index in 0..3 {
        linear(&path(&format!("f{index}.exr")), 16, 12, |x, y| 0.1 + ((x + y) % 4) as f32);
    }
    let inputs = ["f0.exr", "f1.exr", "f2.exr"];
    let run = |more: &[&str]| pt_post(&[&inputs[..], more].concat(), folder.path());

    let done = run(&["--chain", "taa,bloom,tonemap=agx,fsr=1.5", "-o", "out/", "--frames", "1"]);
    assert!(done.status.success(), "{done:?}");
    for name in ["out/f0.png", "out/f1.png", "out/f2.png"] {
        let picture = LinearImage::read(&path(name)).unwrap();
        assert_eq!((picture.width, picture.height), (24, 18), "{name}");
    }
    // Without a tone map: linear images, enlarged by temporal upscaling.
    let done = run(&["--chain", "taa=2,bloom=chain", "-o", "linear", "--frames", "1"]);
    assert!(done.status.success(), "{done:?}");
    let last = LinearImage::read(&path("linear/f2.exr")).unwrap();
    assert_eq!((last.width, last.height), (32, 24));
    let mean = last.pixels.iter().map(|c| c[1]).sum::<f32>() / last.pixels.len() as f32;
    assert!((mean - 1.6).abs() < 0.1, "{mean}");
    // The mean of equal images is the image.
    let done = run(&["--chain", "accumulate", "-o", "mean/", "--frames", "1"]);
    assert!(done.status.success(), "{done:?}");
    assert_eq!(LinearImage::read(&path("mean/f2.exr")).unwrap().pixels[5], [1.1; 3]);

    linear(&path("other.exr"), 8, 8, |_, _| 1.0);
    for (arguments, expected) in [
        (&["f0.exr", "-o", "x.png", "--chain", "blur"][..], "no stage"),
        (&["f0.exr", "f1.exr", "-o", "x.png"], "folder"),
        (&["f0.exr", "other.exr", "-o", "mixed/"], "8x8 pixels, the first image has 16x12"),
        (&["f0.exr", "-o", "x.png", "--set", "bloom.intensity=2"], "bloom.intensity"),
        (&["f0.exr", "-o", "x.png", "--set", "encoding=scrgb"], "scRGB"),
        (&["f0.exr", "-o", "x.png", "--fps", "0"], "--fps"),
    ] {
        let failed = pt_post(arguments, folder.path());
        let message = String::from_utf8_lossy(&failed.stderr).into_owned();
        assert_eq!(failed.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains(expected), "{arguments:?}: {message}");
    }
}

/// PQ goes to 16 bits with its tag, sRGB to 8 with its own; scRGB to an EXR of linear values.
#[test]
fn pictures_say_what_their_codes_mean() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    linear(&path("in.exr"), 4, 4, |_, _| 1.2);
    let common = ["in.exr", "--ev", "0", "--tonemap", "none", "--frames", "1"];
    for (output, encoding) in
        [("pq.png", "encoding=pq"), ("srgb.png", "encoding=srgb"), ("scrgb.exr", "encoding=scrgb")]
    {
        let done = pt_post(&[&common[..], &["-o", output, "--set", encoding]].concat(), folder.path());
        assert!(done.status.success(), "{done:?}");
    }
    let chunk = |name: &str, tag: &[u8; 4]| {
        let bytes = std::fs::read(path(name)).unwrap();
        let at = bytes.windows(4).position(|w| w == tag)?;
        Some(bytes[at + 4..at + 8].to_vec())
    };
    assert_eq!(chunk("pq.png", b"cICP"), Some(vec![9, 16, 0, 1]));
    assert_eq!(chunk("pq.png", b"sRGB"), None);
    assert_eq!(chunk("srgb.png", b"sRGB").map(|v| v[0]), Some(0));
    let header = std::fs::read(path("pq.png")).unwrap();
    assert_eq!(header[24], 16, "bits a sample");
    let scrgb = LinearImage::read(&path("scrgb.exr")).unwrap();
    assert!((scrgb.pixels[0][0] - 203.0 / 80.0).abs() < 2e-3, "{:?}", scrgb.pixels[0]);
}

/// From one pixel to the longest rows that devices promise: every stage copes, and the picture is that of the input.
#[test]
fn extreme_sizes() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    for (width, height) in [(1, 1), (16384, 2), (2, 16384)] {
        // Twice what is shown as white, so that no rounding and no dither shows.
        linear(&path("in.exr"), width, height, |_, _| 2.4);
        for chain in ["taa,bloom,tonemap=none,sharpen", "bloom=chain,tonemap=none", "accumulate,tonemap=none"]
        {
            let arguments = ["in.exr", "-o", "out.png", "--chain", chain, "--ev", "0", "--frames", "1"];
            let done = pt_post(&arguments, folder.path());
            assert!(done.status.success(), "{width}x{height} {chain}: {done:?}");
            let picture = LinearImage::read(&path("out.png")).unwrap();
            assert_eq!((picture.width, picture.height), (width, height));
            let darkest = picture.pixels.iter().flatten().copied().fold(1.0, f32::min);
            assert_eq!(darkest, 1.0, "{width}x{height} {chain}");
        }
    }
    // One step further there is a message, not a crash.
    linear(&path("long.exr"), 16384, 1, |_, _| 1.0);
    for chain in ["taa=4", "tonemap,fsr=4"] {
        let output = if chain.contains("tonemap") { "x.png" } else { "x.exr" };
        let failed = pt_post(&["long.exr", "-o", output, "--chain", chain], folder.path());
        let message = String::from_utf8_lossy(&failed.stderr).into_owned();
        assert_eq!(failed.status.code(), Some(2), "{chain}: {message}");
        assert!(message.contains("65536") && message.lines().count() == 1, "{chain}: {message}");
    }
}

/// A folder stands for its frames: the pictures are those of the same images in files.
#[test]
fn runs_on_recorded_frames() {
    let folder = tempfile::tempdir().unwrap();
    let device = TestDevice::open();
    let io = StageIo { reads: &[FLAT_COLOR, FLAT_MOTION], ..StageIo::of("test") };
    let images = ChannelImages::alone(&device, FrameSizes::same([16, 12]), &[io]).unwrap();
    let value = |x: u32, y: u32| 0.1 + ((x + y) % 4) as f32;
    let color: Vec<f32> = (0..16 * 12).flat_map(|i| [value(i % 16, i / 16); 4]).collect();
    images.current(FLAT_COLOR).write_f32(&color).unwrap();
    images.current(FLAT_MOTION).write_f32(&[0.0; 2 * 16 * 12]).unwrap();
    record_folder(&folder.path().join("frames"), &images, 2..4);
    for name in ["f0.exr", "f1.exr"] {
        linear(&folder.path().join(name), 16, 12, value);
    }
    let chain = ["--chain", "taa,bloom=chain", "--frames", "1", "-o"];
    for (inputs, output) in [(&["frames"][..], "recorded/"), (&["f0.exr", "f1.exr"], "files/")] {
        let done = pt_post(&[inputs, &chain, &[output]].concat(), folder.path());
        assert!(done.status.success(), "{done:?}");
    }
    let read = |name: &str| LinearImage::read(&folder.path().join(name)).unwrap().pixels;
    assert_eq!(read("recorded/frame_000002.exr"), read("files/f0.exr"));
    assert_eq!(read("recorded/frame_000003.exr"), read("files/f1.exr"));

    std::fs::write(folder.path().join("frames/frame_000003.exr"), b"cut").unwrap();
    let failed = pt_post(&[&["frames"][..], &chain, &["again/"]].concat(), folder.path());
    let message = String::from_utf8_lossy(&failed.stderr).into_owned();
    assert_eq!(failed.status.code(), Some(2), "{message}");
    assert!(message.contains("frame_000003.exr") && message.lines().count() == 1, "{message}");
}
