//! Scenes and environments of other programs, through the whole of `pt reference` and `pt compare`.

use std::path::Path;
use std::process::{Command, Output};

use pt_image::image_file::{Layer, LayeredImage, LinearImage};
use pt_test_data::shared;

fn pt(folder: &Path, line: &str) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_pt"));
    program.current_dir(folder).args(line.split_whitespace()).env_remove("RUST_BACKTRACE");
    if let Some(device) = std::env::var_os("PT_TEST_DEVICE").filter(|_| line.starts_with("reference")) {
        program.arg("--device").arg(device);
    }
    program.output().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// The mean of a picture that `pt reference` makes of a scene of a shared case, and what it says on the way.
fn mean(case: &str, line: &str) -> ([f32; 3], String) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.exr");
    let line = format!("reference {line} --backend compute --no-aov -o {}", file.display());
    let output = pt(&shared("cases").join(case), &line);
    assert!(output.status.success(), "{case}: {}", stderr(&output));
    let image = LinearImage::read(&file).unwrap();
    let sum = |c: usize| image.pixels.iter().map(|p| f64::from(p[c])).sum::<f64>();
    ([0, 1, 2].map(|c| (sum(c) / image.pixels.len() as f64) as f32), stderr(&output))
}

fn close(case: &str, got: [f32; 3], expected: [f32; 3], tolerance: f32) {
    let near = got.iter().zip(expected).all(|(a, b)| (a - b).abs() <= tolerance);
    assert!(near, "{case}: {got:?} is not {expected:?}");
}

/// The sky of each case is one colour.
#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn environments_have_the_radiance_of_their_headers() {
    for (case, scene, environment, expected) in [
        ("env-exr-chromaticities", "sky.gltf", "ap1.exr", [0.82, 0.26, 0.18]),
        ("env-exr-data-window", "up.gltf", "crop.exr", [0.0; 3]),
        ("hdr-exposure", "sky.gltf", "exposure.hdr", [0.25; 3]),
        ("hdr-exposure", "sky.gltf", "flat.hdr", [0.5; 3]),
        ("hdr-orientation-xyze", "sky.gltf", "xyze.hdr", [0.5; 3]),
        ("hdr-rgbe-signature", "sky.gltf", "rgbe.hdr", [0.5; 3]),
    ] {
        let (got, _) = mean(case, &format!("{scene} --env {environment} --size 8x8 --spp 1"));
        // Chromaticities and tristimulus values are rounded to two digits and to 8 bits.
        close(environment, got, expected, 0.01);
    }
    for (case, environment) in [
        ("env-exr-layer-names", "layer.exr"),
        ("env-exr-layer-names", "y.exr"),
        ("hdr-orientation-xyze", "mx.hdr"),
    ] {
        let (got, _) = mean(case, &format!("sky.gltf --env {environment} --size 8x8 --spp 1"));
        assert!(got.iter().sum::<f32>() > 0.1, "{environment} is black");
    }
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn negative_radiance_is_refused_or_clamped() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.exr");
    let line = format!("reference sky.gltf --env neg.exr --size 8x8 --spp 1 --no-aov -o {}", file.display());
    let refused = pt(&shared("cases").join("env-negative-pixel"), &line);
    let text = stderr(&refused);
    assert_eq!(refused.status.code(), Some(2), "{text}");
    assert!(text.contains("1 of 128 pixels") && text.contains("--env-clamp"), "{text}");
    let (got, notices) = mean("env-negative-pixel", "sky.gltf --env neg.exr --env-clamp --size 8x8 --spp 1");
    assert!(notices.contains("1 of 128 pixels had negative values"), "{notices}");
    assert!(got.iter().all(|x| x.is_finite() && *x >= 0.0), "{got:?}");
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn a_flattened_lamp_shines_as_the_one_that_is_not() {
    let line = |scene: &str| format!("{scene} --size 24x16 --spp 64 --max-bounces 0");
    let (flat, notices) = mean("zero-scale-axis", &line("z0.gltf"));
    let (whole, _) = mean("zero-scale-axis", &line("one.gltf"));
    // The same samples: what differs are roundings.
    close("z0.gltf", flat, whole, 1e-4);
    assert!(whole[0] > 1e-3 && !notices.contains("default sky"), "{whole:?} {notices}");
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn scenes_of_other_programs_load() {
    for (case, scene) in [
        ("glb-json-zero-padding", "json0.glb"),
        ("percent-raw", "p.gltf"),
        ("parent-uri", "sub/s.gltf --allow-outside"),
        ("negative-key-time", "neg.gltf --animation none"),
        ("negative-key-time", "neg.gltf --animation-end hold --time 7"),
    ] {
        let (got, _) = mean(case, &format!("{scene} --size 24x24 --spp 4"));
        assert!(got.iter().sum::<f32>() > 0.005, "{scene} is black");
    }
}

/// `pt compare` reads pictures as `--env` does.
#[test]
fn compare_converts_too() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let pixels = [128u8, 128, 128, 128].repeat(16 * 16);
    let header = b"#?RGBE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n+X 16 +Y 16\n".as_slice();
    std::fs::write(at.join("a.hdr"), [header, &pixels].concat()).unwrap();
    let mut image = LayeredImage::new(16, 16).unwrap();
    let layer = "ViewLayer.Combined";
    image.layers.push(Layer::from_interleaved(layer, &["R", "G", "B"], 3, &[0.25; 16 * 16 * 3]));
    image.layers.push(Layer::from_interleaved("ViewLayer.Emit", &["R", "G", "B"], 3, &[7.0; 16 * 16 * 3]));
    image.write_exr(&at.join("b.exr")).unwrap();
    let output = pt(at, "compare a.hdr b.exr --max mse=0");
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert!(stderr(&output).contains("a.hdr: values are divided by the EXPOSURE 2"), "{}", stderr(&output));
}
