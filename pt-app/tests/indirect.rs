//! Indirect light from the command line: the frame against the reference with paths of the same length, the profiles, and the line that says
//! what there is.

use pt_image::image_file::LinearImage;
use std::path::Path;
use std::process::Command;

fn succeeds(folder: &Path, line: &str) -> String {
    let mut program = Command::new(env!("CARGO_BIN_EXE_pt"));
    program.current_dir(folder).args(line.split_whitespace());
    if let Some(device) = std::env::var_os("PT_TEST_DEVICE") {
        program.arg("--device").arg(device);
    }
    let done = program.output().unwrap();
    assert!(done.status.success(), "pt {line}: {done:?}");
    String::from_utf8(done.stdout).unwrap()
}

fn mean(path: &Path) -> f64 {
    let image = LinearImage::read(path).unwrap();
    let sum: f64 = image.pixels.iter().map(|p| p.iter().map(|&c| f64::from(c)).sum::<f64>()).sum();
    sum / (3 * image.pixels.len()) as f64
}

/// Energy of the frame over that of the reference.
fn ratio(folder: &Path, scene: &str, bounces: u32, size: &str, frames: u32, options: &str) -> f64 {
    let view = format!("{scene} --size {size} --backend compute");
    let said = succeeds(
        folder,
        &format!(
            "render {view} --profile unbiased --set indirect.bounces={bounces} --frames {frames} --accumulate {options} -o frame.exr"
        ),
    );
    let expected = match bounces {
        0 => "light: direct light only".to_owned(),
        1 => "light: direct light and 1 bounce ".to_owned(),
        n => format!("light: direct light and up to {n} bounces "),
    };
    assert!(said.lines().any(|line| line.starts_with(&expected)), "{said}");
    succeeds(
        folder,
        &format!("reference {view} --max-bounces {bounces} --spp {frames} --seed 5 --no-aov -o truth.exr"),
    );
    let ratio = mean(&folder.join("frame.exr")) / mean(&folder.join("truth.exr"));
    println!("{scene}, {bounces} bounces {options}: ratio {ratio:.4}");
    ratio
}

/// 1 % is the promise; the standard error of these means is about 0.2 %.
#[test]
fn energy_is_that_of_the_reference() {
    let folder = tempfile::tempdir().unwrap();
    for (scene, bounces, size, frames) in [
        ("cornell", 1, "24x24", 256),
        ("cornell", 4, "24x24", 256),
        ("veach", 1, "32x18", 256),
        ("lamps", 2, "32x18", 192),
    ] {
        let ratio = ratio(folder.path(), scene, bounces, size, frames, "");
        assert!((0.99..=1.01).contains(&ratio), "{scene}, {bounces} bounces: {ratio}");
    }
}

/// Every light sampler picks the lights of the surfaces that rays meet with its own probabilities.
#[test]
fn light_samplers_agree() {
    let folder = tempfile::tempdir().unwrap();
    for sampler in ["cluster-stats", "light-bvh", "ris", "restir-di"] {
        let options = format!("--set lights.rays=merged --set lights.sampler={sampler}");
        let ratio = ratio(folder.path(), "lamps", 1, "24x14", 128, &options);
        assert!((0.985..=1.015).contains(&ratio), "{sampler}: {ratio}");
    }
}

#[test]
fn profiles_render() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for (profile, light) in [
        ("default", "direct light and 1 bounce ("),
        ("q2rtx", "direct light and 1 bounce ("),
        ("half-res-gi", "direct light and 1 bounce of diffuse light at every other row ("),
        ("unbiased", "direct light and 1 bounce ("),
    ] {
        let said = succeeds(
            at,
            &format!(
                "render cornell --size 24x24 --backend compute --profile {profile} --frames 4 -o {profile}.exr"
            ),
        );
        assert!(said.contains(&format!("light: {light}")), "{profile}: {said}");
        let mean = mean(&at.join(format!("{profile}.exr")));
        assert!(mean.is_finite() && mean > 0.05, "{profile}: {mean}");
    }
}
