//! The contract of `pt reference` and `pt merge`.

mod slurm;

use pt_image::image_file::{Layer, LayeredImage, LinearImage};
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::Duration;

fn pt(folder: &Path, line: &str) -> Command {
    let mut program = Command::new(env!("CARGO_BIN_EXE_pt"));
    program.current_dir(folder).args(line.split_whitespace()).env_remove("RUST_BACKTRACE");
    if let Some(device) = std::env::var_os("PT_TEST_DEVICE").filter(|_| line.starts_with("reference")) {
        program.arg("--device").arg(device);
    }
    program
}

fn succeeds(folder: &Path, line: &str) -> String {
    let done = pt(folder, line).output().unwrap();
    assert!(done.status.success(), "pt {line}: {done:?}");
    String::from_utf8(done.stdout).unwrap()
}

fn refused(folder: &Path, line: &str, parts: &[&str]) {
    let Output { status, stdout, stderr } = pt(folder, line).output().unwrap();
    let message = String::from_utf8(stderr).unwrap();
    assert_eq!(status.code(), Some(2), "pt {line}: {message}");
    assert!(message.starts_with("error: ") && message.lines().count() == 1, "pt {line}: {message}");
    assert!(parts.iter().all(|part| message.contains(part)), "pt {line}: no {parts:?} in {message}");
    assert!(stdout.is_empty());
}

const SMALL: &str = "--size 24x16 --backend compute --max-bounces 2";

#[test]
fn writes_an_estimate_and_the_inputs_of_a_denoiser() {
    let folder = tempfile::tempdir().unwrap();
    let out = succeeds(folder.path(), &format!("reference cornell {SMALL} --spp 4 --validation -o room.exr"));
    assert!(out.contains("4 samples a pixel") && out.contains("0 non-finite samples dropped"), "{out}");
    let image = LayeredImage::read_exr(&folder.path().join("room.exr")).unwrap();
    let layers: Vec<_> = image.layers.iter().map(|layer| layer.name.as_str()).collect();
    for name in ["", "variance", "albedo", "normal", "depth", "motion", "coverage"] {
        assert!(layers.contains(&name), "{name:?} is not among {layers:?}");
    }
    assert_eq!(image.metadata["samples"], "4");
    for part in ["hdr", "alb", "nrm"] {
        let image = LinearImage::read(&folder.path().join(format!("room_0004spp.{part}.exr"))).unwrap();
        assert_eq!((image.width, image.height), (24, 16));
        assert!(image.pixels.iter().flatten().any(|&value| value != 0.0), "{part} is black");
    }
    succeeds(folder.path(), &format!("reference cornell {SMALL} --spp 1 --no-aov -o alone.exr"));
    assert!(!folder.path().join("alone_0001spp.hdr.exr").exists());
}

#[test]
fn an_interrupted_render_resumes_to_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let render = format!("reference cornell {SMALL} --spp 600 --no-aov");
    succeeds(folder.path(), &format!("{render} -o whole.exr"));
    for (round, moment) in [900, 1700, 2600].into_iter().enumerate() {
        let (file, state) = (format!("killed{round}.exr"), format!("state{round}.exr"));
        let line = format!("{render} --checkpoint {state} --checkpoint-interval 0 --resume -o {file}");
        let mut child = pt(folder.path(), &line).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        sleep(Duration::from_millis(moment));
        child.kill().unwrap();
        child.wait().unwrap();
        succeeds(folder.path(), &line);
        let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
        assert!(read(&file) == read("whole.exr"), "killed after {moment} ms: other bits");
    }
}

#[test]
fn slices_merge_to_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let render = format!("reference cornell {SMALL} --no-aov");
    succeeds(folder.path(), &format!("{render} --spp 12 -o whole.exr"));
    for (range, name) in [("0..5", "a"), ("5..6", "b"), ("6..12", "c")] {
        succeeds(folder.path(), &format!("{render} --spp-range {range} -o {name}.exr"));
    }
    succeeds(folder.path(), "merge c.exr a.exr b.exr -o merged.exr --no-aov");
    let [whole, merged] = ["whole", "merged"]
        .map(|name| LayeredImage::read_exr(&folder.path().join(format!("{name}.exr"))).unwrap());
    assert_eq!(merged.metadata["spp_ranges"], "0..12");
    for (layer, tolerance) in [("", 1e-6), ("variance", 1e-4)] {
        for channel in ["R", "G", "B"] {
            let [a, b] = [&whole, &merged].map(|image| image.channel(layer, channel).unwrap().to_f32());
            for (a, b) in a.iter().zip(&b) {
                assert!((a - b).abs() <= tolerance * a.abs() + 1e-9, "{layer} {channel}: {a} and {b}");
            }
        }
    }
    refused(folder.path(), "merge a.exr whole.exr -o x.exr", &["a.exr", "whole.exr", "samples in common"]);
    succeeds(folder.path(), &format!("{render} --seed 1 --spp-range 12..13 -o seed.exr"));
    refused(folder.path(), "merge a.exr seed.exr -o x.exr", &["seed", "1 there and 0 here"]);
    assert!(!folder.path().join("x.exr").exists());
}

#[test]
fn refusals() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    refused(path, "reference cornell -o a.png", &["a.png", ".exr"]);
    refused(path, "reference nowhere -o a.exr", &["nowhere"]);
    refused(path, "reference cornell --spp-range 4..4 -o a.exr", &["empty"]);
    refused(path, "reference cornell --spp-range 4..8 --sampler blue-noise -o a.exr", &["--spp"]);
    refused(path, "reference cornell --light-types moon -o a.exr", &["moon"]);
    refused(path, "reference cornell --resume -o a.exr", &["--checkpoint"]);
    let render = format!("reference cornell {SMALL} --spp 2 --no-aov --checkpoint c.exr");
    succeeds(path, &format!("{render} -o a.exr"));
    let before = fs::read(path.join("c.exr")).unwrap();
    let other = render.replace("24x16", "16x16");
    refused(path, &format!("{other} --resume -o b.exr"), &["c.exr", "size is 24x16 there and 16x16 here"]);
    refused(path, &format!("{other} -o b.exr"), &["c.exr", "another render", "another --checkpoint"]);
    let looks = format!("{render} --look 0,1,3,0,1,0 --resume -o b.exr");
    refused(path, &looks, &["c.exr", "camera.", "there and", "here"]);
    refused(
        path,
        &format!("{} --resume -o b.exr", render.replace("cornell", "plane")),
        &["c.exr", "another render"],
    );
    refused(path, &format!("{} --resume -o b.exr", render.replace("--spp 2", "--spp 1")), &["0..2", "0..1"]);
    assert!(fs::read(path.join("c.exr")).unwrap() == before, "a refused checkpoint was touched");
    fs::write(path.join("cut.exr"), &before[..before.len() / 2]).unwrap();
    refused(path, &format!("{} --resume -o b.exr", render.replace("c.exr", "cut.exr")), &["cut.exr"]);
    refused(
        path,
        &format!("{} --resume -o b.exr", render.replace("c.exr", "a.exr")),
        &["a.exr", "checkpoint"],
    );
    refused(path, "merge c.exr -o x.exr", &["c.exr", "pt reference"]);
    assert!(!path.join("b.exr").exists() && !path.join("x.exr").exists());
}

/// From outside of the box, before a sky of one radiance.
const OUTSIDE: &str =
    "cornell --look 0.5,0.6,1.2,-0.278,0.27,-0.28 --env sky.exr --size 24x16 --backend compute";

fn rgba(path: &Path) -> [Vec<f32>; 4] {
    let image = LayeredImage::read_exr(path).unwrap();
    ["R", "G", "B", "A"].map(|name| image.channel("", name).map_or(Vec::new(), |samples| samples.to_f32()))
}

#[test]
fn a_transparent_background_has_alpha_and_resumes() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let mut sky = LayeredImage::new(4, 2).unwrap();
    sky.layers.push(Layer::from_interleaved("", &["R", "G", "B"], 3, &[3.0; 24]));
    sky.write_exr(&at.join("sky.exr")).unwrap();
    let render = format!("reference {OUTSIDE} --max-bounces 1 --no-aov");
    let transparent = format!("{render} --background transparent");
    succeeds(at, &format!("{render} --spp 32 -o opaque.exr"));
    succeeds(at, &format!("{transparent} --spp 32 -o whole.exr"));
    let (opaque, found) = (rgba(&at.join("opaque.exr")), rgba(&at.join("whole.exr")));
    let alpha = &found[3];
    assert!(opaque[3].is_empty());
    let count = |test: &dyn Fn(f32) -> bool| alpha.iter().filter(|&&a| test(a)).count();
    let counts = [count(&|a| a == 0.0), count(&|a| a == 1.0), count(&|a| a > 0.0 && a < 1.0)];
    assert!(counts[0] > 50 && counts[1] > 20 && counts[2] > 20, "sky, surfaces, edges: {counts:?}");
    for (found, opaque) in found[..3].iter().zip(&opaque[..3]) {
        for (i, (found, opaque)) in found.iter().zip(opaque).enumerate() {
            let over = found + (1.0 - alpha[i]) * 3.0;
            assert!((over - opaque).abs() <= 1e-5 * opaque.max(1.0), "pixel {i}: {over} and {opaque}");
            assert!(alpha[i] > 0.0 || *found == 0.0, "pixel {i}");
        }
    }
    // The frame of the same view has the same coverage. Four standard errors of the difference of 32 samples each.
    let frame = render.replace("reference", "render").replace(" --max-bounces 1 --no-aov", "");
    succeeds(at, &format!("{frame} --background transparent --frames 32 --accumulate -o frame.exr"));
    for (i, (a, b)) in alpha.iter().zip(&rgba(&at.join("frame.exr"))[3]).enumerate() {
        let mean = 0.5 * (a + b);
        let error = (2.0 * mean * (1.0 - mean) / 32.0).sqrt();
        assert!((a - b).abs() <= 4.0 * error, "pixel {i}: alpha {a} and {b}");
    }

    // Interrupted, in tiles, in slices: the same bits.
    let resumed = format!("{transparent} --tile 13x9 --checkpoint c.exr --resume");
    succeeds(at, &format!("{resumed} --spp 9 -o part.exr"));
    succeeds(at, &format!("{resumed} --spp 32 -o resumed.exr"));
    let read = |name: &str| fs::read(at.join(name)).unwrap();
    assert!(read("resumed.exr") == read("whole.exr"));
    succeeds(at, &format!("{resumed} --spp 100000 --time-limit 0.3 -o limited.exr"));
    assert_eq!(rgba(&at.join("limited.exr"))[3].len(), alpha.len());
    succeeds(at, &format!("{transparent} --spp-range 0..16 -o a.exr"));
    succeeds(at, &format!("{transparent} --spp-range 16..32 -o b.exr"));
    succeeds(at, "merge b.exr a.exr -o merged.exr --no-aov");
    for (merged, whole) in rgba(&at.join("merged.exr")).iter().zip(&found) {
        assert!(merged.iter().zip(whole).all(|(a, b)| (a - b).abs() <= 1e-6 * b.abs()));
    }

    // Another background is another render.
    let differs = ["c.exr", "params.background is transparent there and environment here"];
    refused(at, &format!("{render} --spp 64 --checkpoint c.exr --resume -o x.exr"), &differs);
    refused(at, "merge a.exr opaque.exr -o x.exr", &["different renders", "params.background"]);
    refused(at, &format!("{transparent} --spp 2 -o x.png"), &["x.png", ".exr"]);
    refused(at, &format!("{render} --background white -o x.exr"), &["white", "environment", "transparent"]);
    assert!(!at.join("x.exr").exists());
    // The ground truth of a recorded frame has the background of the frame.
    let capture = frame.replace("render", "capture");
    succeeds(at, &format!("{capture} --background transparent --reference-spp 4 -o c"));
    assert_eq!(rgba(&at.join("c/reference_000000.exr"))[3].len(), alpha.len());
}
