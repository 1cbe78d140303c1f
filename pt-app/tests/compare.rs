//! `pt compare` as a program: values, limits, exit codes, messages.

mod sequence;

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use pt_image::image_file::{Layer, LayeredImage, LinearImage, PixelLayout, write_png};
use pt_image::metrics::Metric;
use serde_json::Value;

fn pt(folder: &Path, line: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pt")).current_dir(folder).args(line.split_whitespace()).output().unwrap()
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// A 16x8 EXR of one value, with an optional other value in the right half.
fn write(folder: &Path, name: &str, left: f32, right: f32) {
    let values: Vec<f32> =
        (0..16 * 8 * 3).map(|index| if index / 3 % 16 < 8 { left } else { right }).collect();
    let mut image = LayeredImage::new(16, 8).unwrap();
    image.layers.push(Layer::from_interleaved("", &["R", "G", "B"], 3, &values));
    image.write_exr(&folder.join(name)).unwrap();
}

/// `b.exr` is 1 everywhere, `a.exr` 1 on the left and 1.2 on the right: MSE 0.02, energy 1.1.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "a.exr", 1.0, 1.2);
    write(folder.path(), "b.exr", 1.0, 1.0);
    folder
}

fn refused(folder: &Path, line: &str, expected: &str) {
    let output = pt(folder, line);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{line}: {message}");
    assert!(message.starts_with("error: ") && message.contains(expected), "{line}: {message}");
    assert_eq!(message.lines().count(), 1, "{line}: {message}");
    assert!(output.stdout.is_empty(), "{line}");
}

#[test]
fn json_has_the_values_and_the_formulas() {
    let folder = folder();
    let output = pt(folder.path(), "compare a.exr b.exr --json");
    assert_eq!(output.status.code(), Some(0));
    let report: Value = serde_json::from_str(&stdout(&output)).unwrap();
    let value = |metric: &str| report["metrics"][metric]["value"].as_f64().unwrap();
    assert!((value("mse") - 0.02).abs() < 1e-7, "{report}");
    assert!((value("relmse") - 0.02 / 1.01).abs() < 1e-7, "{report}");
    assert!((value("energy") - 1.1).abs() < 1e-7, "{report}");
    assert!(value("flip") > 0.0 && value("psnr") > 10.0);
    assert!(value("ssim") > 0.9 && value("ssim") < 1.0, "{report}");
    // The reference is 1 everywhere: both exposures bring it to 0.85, at log2 2.1188723.
    let hdr = &report["metrics"]["hdr-flip"];
    assert!(value("hdr-flip") > 0.0 && hdr["exposures"] == 2, "{report}");
    for exposure in ["start_exposure", "stop_exposure"] {
        assert!((hdr[exposure].as_f64().unwrap() - 1.083_297).abs() < 1e-5, "{report}");
    }
    assert_eq!(report["metrics"]["relmse"]["epsilon"], 0.01);
    assert_eq!(report["metrics"]["mse"]["formula"], "mean((a - b)^2)");
    assert_eq!((&report["width"], &report["passed"]), (&Value::from(16), &Value::from(true)));
}

#[test]
fn text_prints_formula_and_epsilon() {
    let folder = folder();
    let text = stdout(&pt(folder.path(), "compare a.exr b.exr --metric relmse,mse"));
    assert!(text.contains("mean((a - b)^2 / (b^2 + epsilon)), epsilon = 0.01"), "{text}");
    assert!(text.contains("0.020000"), "{text}");
    assert!(!text.contains("psnr") && !text.contains("sRGB"), "only what was asked for: {text}");
    let text = stdout(&pt(folder.path(), "compare a.exr b.exr --metric ssim,hdr-flip"));
    assert!(text.contains("K1 = 0.01, K2 = 0.03") && text.contains("Gaussian window"), "{text}");
    assert!(
        text.contains("hdr-flip: start_exposure 1.083297, stop_exposure 1.083297, exposures 2\n"),
        "{text}"
    );
    let text = stdout(&pt(folder.path(), "compare a.exr b.exr --metric flip"));
    assert!(text.contains("sRGB codes") && text.contains("x / (1 + x)"), "{text}");
}

#[test]
fn limits_decide_the_exit_code() {
    let folder = folder();
    let code = |limits: &str| pt(folder.path(), &format!("compare a.exr b.exr {limits}")).status.code();
    assert_eq!(code("--max mse=0.021 --max relmse=0.02"), Some(0));
    assert_eq!(code("--max mse=0.021 --max relmse=0.01"), Some(1));
    assert_eq!(code("--metric mse --max energy=1.05"), Some(1), "a limit brings its metric along");
    assert_eq!(code("--min energy=1.05 --max energy=1.15"), Some(0));
    assert_eq!(code("--min psnr=90"), Some(1));
    assert_eq!(code("--min ssim=0.9 --max hdr-flip=0.5"), Some(0));
    assert_eq!(code("--min ssim=0.9999"), Some(1));
    assert_eq!(code("--max hdr-flip=0.001"), Some(1));
    let failed = pt(folder.path(), "compare a.exr b.exr --max mse=0.01 --max energy=2");
    let text = stdout(&failed);
    assert!(text.contains("check mse <= 0.01: FAILED") && text.contains("check energy <= 2: ok"), "{text}");
    let report: Value =
        serde_json::from_str(&stdout(&pt(folder.path(), "compare a.exr b.exr --json --max mse=0.01")))
            .unwrap();
    assert_eq!(report["passed"], false);
}

#[test]
fn equal_images_pass_every_limit() {
    let folder = folder();
    let output = pt(
        folder.path(),
        "compare b.exr b.exr --json --max mse=0 --max flip=0 --max hdr-flip=0 --min ssim=1 --min psnr=1000",
    );
    assert_eq!(output.status.code(), Some(0));
    let report: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(report["metrics"]["psnr"]["value"], "inf");
}

#[test]
fn a_region_is_cut_out_first() {
    let folder = folder();
    let mse = |region: &str| {
        let line = format!("compare a.exr b.exr --metric mse --json --region {region}");
        let report: Value = serde_json::from_str(&stdout(&pt(folder.path(), &line))).unwrap();
        report["metrics"]["mse"]["value"].as_f64().unwrap()
    };
    assert_eq!(mse("0,0,8,8"), 0.0);
    assert!((mse("8,3,8,2") - 0.04).abs() < 1e-7);
    refused(folder.path(), "compare a.exr b.exr --region 8,0,9,8", "reaches outside a.exr (16x8 pixels)");
    refused(folder.path(), "compare a.exr b.exr --region 0,0,0,8", "region is empty");
    refused(folder.path(), "compare a.exr b.exr --region 1,2,3", "four whole numbers x,y,w,h");
}

#[test]
fn the_heat_map_is_bright_where_the_error_is() {
    let folder = folder();
    let output = pt(folder.path(), "compare a.exr b.exr --metric mse,flip --heatmap map.png");
    assert_eq!(output.status.code(), Some(0));
    assert!(stdout(&output).contains("heat map map.png: mse per pixel"));
    let map = LinearImage::read(&folder.path().join("map.png")).unwrap();
    assert_eq!((map.width, map.height), (16, 8));
    assert!(map.pixels[0][1] < 0.01 && map.pixels[15][1] > 0.5, "{:?} {:?}", map.pixels[0], map.pixels[15]);
    refused(folder.path(), "compare a.exr b.exr --heatmap map.exr", "another extension");
    refused(folder.path(), "compare a.exr b.exr --heatmap no/map.png", "folder no does not exist");
}

/// A 16x8 estimate of 1 with variance 0.01 in every channel; the right half is off by `bias`.
fn write_estimate(folder: &Path, name: &str, bias: f32, variance: f32) {
    let mut image = LayeredImage::new(16, 8).unwrap();
    let mean = |index: usize| 1.0 + if index / 3 % 16 < 8 { 0.01 } else { bias };
    let means: Vec<f32> = (0..16 * 8 * 3).map(mean).collect();
    image.layers.push(Layer::from_interleaved("", &["R", "G", "B"], 3, &means));
    image.layers.push(Layer::from_interleaved("variance", &["R", "G", "B"], 3, &[variance; 16 * 8 * 3]));
    image.write_exr(&folder.join(name)).unwrap();
}

#[test]
fn z_test_reads_the_variances_of_both_files() {
    let folder = folder();
    let at = folder.path();
    write_estimate(at, "b.exr", 0.0, 0.01);
    write_estimate(at, "a.exr", 0.5, 0.01);
    // 384 tests: z = 4.21; a bias of 0.5 is 3.54 standard errors of 0.1414, one of 0.7 is 4.95.
    assert_eq!(pt(at, "compare a.exr b.exr --min z-test=0.9975").status.code(), Some(0));
    write_estimate(at, "a.exr", 0.7, 0.01);
    let output = pt(at, "compare a.exr b.exr --metric z-test --min z-test=0.9975 --json");
    assert_eq!(output.status.code(), Some(1));
    let report: Value = serde_json::from_str(&stdout(&output)).unwrap();
    let entry = &report["metrics"]["z-test"];
    assert_eq!(entry["value"], 0.5);
    assert!((entry["critical_z"].as_f64().unwrap() - 4.206).abs() < 2e-3, "{report}");
    let formula = entry["formula"].as_str().unwrap();
    assert!(formula.contains("Sidak") && formula.contains("significance 0.01"), "{formula}");
    // The left half agrees; the variances are cut out with the image.
    let left = pt(at, "compare a.exr b.exr --min z-test=1 --region 0,0,8,8");
    assert_eq!(left.status.code(), Some(0), "{}", stdout(&left));
    let map = pt(at, "compare a.exr b.exr --metric z-test --heatmap z.png");
    assert_eq!(map.status.code(), Some(0));
    let map = LinearImage::read(&at.join("z.png")).unwrap();
    assert!(map.pixels[0][1] < 0.05 && map.pixels[15][1] > 0.5, "{:?} {:?}", map.pixels[0], map.pixels[15]);
    // Equal images are estimates of one seed.
    let same = pt(at, "compare b.exr b.exr --metric z-test");
    let warning = String::from_utf8(same.stderr).unwrap();
    assert!(warning.starts_with("warning: the images are equal"), "{warning}");
}

#[test]
fn z_test_without_usable_variances_is_refused() {
    let folder = folder();
    let at = folder.path();
    write_estimate(at, "estimate.exr", 0.0, 0.01);
    write_estimate(at, "negative.exr", 0.3, -0.01);
    write_png(&at.join("a.png"), 16, 8, PixelLayout::Rgb, &[128; 384]).unwrap();
    refused(
        at,
        "compare estimate.exr b.exr --metric z-test",
        "b.exr is no EXR with channels R, G, B in a layer",
    );
    refused(at, "compare a.exr estimate.exr --min z-test=0.9975", "a.exr is no EXR with channels");
    refused(at, "compare a.png estimate.exr --metric mse,z-test", "a.png is no EXR with channels");
    refused(
        at,
        "compare negative.exr estimate.exr --metric z-test",
        "the variances of 128 pixels of the image and 0 of the reference are NaN, infinite or negative (of 128)",
    );
    // Other metrics do not ask for them.
    assert_eq!(pt(at, "compare negative.exr b.exr").status.code(), Some(0));
}

/// One pixel, black frames and light below zero have values.
#[test]
fn odd_images_are_measured() {
    let folder = folder();
    let at = folder.path();
    write(at, "black.exr", 0.0, 0.0);
    write(at, "ringing.exr", -0.5, 1.0);
    for line in ["compare black.exr black.exr", "compare a.exr black.exr", "compare black.exr a.exr"] {
        assert_eq!(pt(at, line).status.code(), Some(0), "{line}");
    }
    let equal =
        pt(at, "compare black.exr black.exr --max hdr-flip=0 --max flip=0 --min ssim=1 --max energy=1");
    assert_eq!(equal.status.code(), Some(0), "{}", stdout(&equal));
    let different = pt(at, "compare a.exr black.exr --min hdr-flip=0.9");
    assert_eq!(different.status.code(), Some(0), "{}", stdout(&different));
    assert_eq!(pt(at, "compare ringing.exr a.exr").status.code(), Some(0));
    assert_eq!(pt(at, "compare a.exr b.exr --region 3,3,1,1 --heatmap one.png").status.code(), Some(0));
}

#[test]
fn bad_input_is_one_line() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("broken.exr"), &fs::read(at.join("a.exr")).unwrap()[..200]).unwrap();
    fs::write(at.join("empty.png"), "").unwrap();
    write(at, "nan.exr", f32::NAN, 1.0);
    write_png(&at.join("small.png"), 2, 2, PixelLayout::Rgb, &[0; 12]).unwrap();
    write_png(&at.join("small2.png"), 2, 1, PixelLayout::Rgb, &[0; 6]).unwrap();
    refused(at, "compare none.exr b.exr", "cannot read none.exr: No such file");
    refused(at, "compare broken.exr b.exr", "cannot read broken.exr");
    refused(at, "compare empty.png b.exr", "cannot read empty.png");
    refused(
        at,
        "compare a.exr .",
        ". is a sequence of frames and a.exr is not; give two images or two sequences",
    );
    refused(
        at,
        "compare nan.exr b.exr",
        "64 pixels of the image and 0 of the reference are NaN or infinite (of 128)",
    );
    refused(at, "compare small.png small2.png", "the images differ in size: 2x2 and 2x1");
    refused(
        at,
        "compare a.exr b.exr --metric rmse",
        "unknown metric \"rmse\", known: relmse, mse, psnr, ssim, flip, hdr-flip, energy, detail, z-test, temporal_pixel, temporal_block",
    );
    refused(at, "compare a.exr b.exr --max mse", "expected METRIC=VALUE");
    refused(at, "compare a.exr b.exr --max mse=low", "\"low\" is not a number");
    refused(at, "compare a.exr b.exr --max mse=nan", "not a number");
    refused(at, "compare a.exr", "<B>");
    refused(at, "compare a.exr b.exr --hot", "--hot");
    refused(at, "comprae a.exr b.exr", "compare");
}

#[test]
fn a_scene_against_a_display_is_warned_about() {
    let folder = folder();
    write_png(&folder.path().join("a.png"), 16, 8, PixelLayout::Rgb, &[128; 384]).unwrap();
    let output = pt(folder.path(), "compare a.png b.exr");
    assert_eq!(output.status.code(), Some(0));
    let warning = String::from_utf8(output.stderr).unwrap();
    assert!(
        warning.starts_with("warning: a.png is display-referred and b.exr is scene-referred"),
        "{warning}"
    );
}

/// The reader of the pipe is gone before the program writes: no panic, and the exit code still tells of the check.
#[test]
fn a_closed_pipe_changes_nothing() {
    let folder = folder();
    for (line, code) in [("compare a.exr b.exr", 0), ("compare a.exr b.exr --max mse=0", 1), ("--help", 0)] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = Command::new(env!("CARGO_BIN_EXE_pt"))
            .current_dir(folder.path())
            .args(line.split_whitespace())
            .stdout(writer)
            .stderr(Stdio::piped())
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(code), "{line}");
        assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn help_and_version_leave_with_zero() {
    let folder = folder();
    let help = pt(folder.path(), "compare --help");
    assert_eq!(help.status.code(), Some(0));
    let defaults = Metric::OF_IMAGES.map(Metric::name);
    let text = stdout(&help).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        text.contains("Checks:") && text.contains(&format!("[default of images: {}]", defaults.join(","))),
        "{text}"
    );
    assert_eq!(pt(folder.path(), "--version").status.code(), Some(0));
}
