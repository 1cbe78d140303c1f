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
fn ratio(folder: &Path, scene: &str, bounces: u32, size: &str, frames: u32) -> f64 {
    let view = format!("{scene} --size {size} --backend compute");
    let said = succeeds(
        folder,
        &format!(
            "render {view} --profile unbiased --set indirect.bounces={bounces} --frames {frames} --accumulate -o frame.exr"
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
    println!("{scene}, {bounces} bounces: ratio {ratio:.4}");
    ratio
}

/// 1 % is the promise; the standard error of these means is about 0.3 %.
#[test]
fn one_bounce_has_the_energy_of_the_reference() {
    let folder = tempfile::tempdir().unwrap();
    let ratio = ratio(folder.path(), "cornell", 1, "24x24", 256);
    assert!((0.99..=1.01).contains(&ratio), "{ratio}");
}

#[test]
fn four_bounces_have_the_energy_of_the_reference() {
    let folder = tempfile::tempdir().unwrap();
    let ratio = ratio(folder.path(), "cornell", 4, "24x24", 256);
    assert!((0.99..=1.01).contains(&ratio), "{ratio}");
}

#[test]
fn profiles_render() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for (profile, light) in [
        ("q2rtx", "direct light and 1 bounce ("),
        ("half-res-gi", "direct light and 1 bounce of diffuse light at every other row ("),
    ] {
        let said = succeeds(
            at,
            &format!(
                "render cornell --size 24x24 --backend compute --profile {profile} --frames 4 -o {profile}.exr"
            ),
        );
        assert!(said.contains(&format!("light: {light}")), "{profile}: {said}");
        let mean = mean(&at.join(format!("{profile}.exr")));
        // Temporal anti-aliasing in the manner of that game takes most of what is not denoised for sparkle.
        assert!(mean.is_finite() && mean > 0.02, "{profile}: {mean}");
    }
}
