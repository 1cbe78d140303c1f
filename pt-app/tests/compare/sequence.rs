//! `pt compare` of sequences: pairs of frames, values of the change from frame to frame, messages.

use super::{pt, refused, stdout};
use pt_image::image_file::{Layer, LayeredImage, PixelLayout, write_png};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::thread;

const SIZE: [u32; 2] = [40, 24];

fn pixels(value: impl Fn(u32, u32) -> Vec<f32>) -> Vec<f32> {
    (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| [x, y])).flat_map(|[x, y]| value(x, y)).collect()
}

/// An EXR of grey values, with further layers.
fn write(path: &Path, value: impl Fn(u32, u32) -> f32, layers: Vec<Layer>) {
    let mut image = LayeredImage::new(SIZE[0], SIZE[1]).unwrap();
    let values = pixels(|x, y| vec![value(x, y); 3]);
    image.layers.push(Layer::from_interleaved("", &["R", "G", "B"], 3, &values));
    image.layers.extend(layers);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    image.write_exr(path).unwrap();
}

/// `a` is 1, 1.2, 1.1 in the frames 0, 1, 2 and 1 in frame 4; `b` is always 1.
fn sequences() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (frame, value) in [(0, 1.0), (1, 1.2), (2, 1.1), (4, 1.0)] {
        write(&folder.path().join(format!("a/f_{frame:04}.exr")), |_, _| value, Vec::new());
        write(&folder.path().join(format!("b/f_{frame:04}.exr")), |_, _| 1.0, Vec::new());
    }
    folder
}

fn report(folder: &Path, line: &str) -> Value {
    let output = pt(folder, line);
    assert_eq!(output.status.code(), Some(0), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_str(&stdout(&output)).unwrap()
}

fn near(value: &Value, expected: f64) {
    let found = value.as_f64().unwrap_or_else(|| panic!("{value} is no number, expected {expected}"));
    assert!((found - expected).abs() <= 1e-6 * expected.abs().max(1.0), "{found}, expected {expected}");
}

#[test]
fn frames_and_their_changes_are_measured() {
    let folder = sequences();
    let at = folder.path();
    let found = report(at, "compare a b --json");
    let row = |i: usize, metric: &str| &found["frames"][i][metric];
    for (i, (relmse, change)) in
        [(0.0, None), (0.04, Some(0.04)), (0.01, Some(0.01)), (0.0, None)].into_iter().enumerate()
    {
        near(row(i, "relmse"), relmse / 1.01);
        for metric in ["temporal_pixel", "temporal_block"] {
            // Frame 3 is missing in both: the change to frame 4 is of two steps, and is none of these.
            match change {
                Some(change) => near(row(i, metric), change / 1.01),
                None => assert!(row(i, metric).is_null(), "{found}"),
            }
        }
    }
    assert_eq!(found["frames"][3]["frame"], 4);
    assert_eq!(found["frames"][3]["b"], "b/f_0004.exr");
    near(row(1, "energy"), 1.2);
    near(&found["metrics"]["relmse"]["mean"], 0.05 / 1.01 / 4.0);
    // Of the frames that have one.
    near(&found["metrics"]["temporal_pixel"]["mean"], 0.05 / 1.01 / 2.0);
    let formula = found["metrics"]["temporal_block"]["formula"].as_str().unwrap();
    assert!(formula.contains("16 x 16") && formula.contains("a_before"), "{formula}");
    assert!(found["motion"].as_str().unwrap().contains("still camera"), "{found}");

    let text = stdout(&pt(at, "compare a b"));
    let line = |start: &str| {
        let found = text.lines().find(|line| line.trim_start().starts_with(start));
        found.unwrap_or_else(|| panic!("{start}: {text}")).split_whitespace().collect::<Vec<_>>()
    };
    assert_eq!(
        line("frame "),
        ["frame", "relmse", "flip", "energy", "detail", "temporal_pixel", "temporal_block"]
    );
    assert_eq!(line("0 ")[5..], ["-", "-"]);
    assert_eq!(line("1 ")[5..], ["0.039604", "0.039604"]);
    assert_eq!((line("mean ")[1], line("mean ")[3]), ("0.012376", "1.075000"));
}

/// A file that can be read once: who opens it again finds it empty.
fn write_pipe(path: &Path, layers: Vec<Layer>) {
    write(path, |x, _| 1.0 + x as f32, layers);
    let content = fs::read(path).unwrap();
    fs::remove_file(path).unwrap();
    assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
    let path = path.to_owned();
    // Each write waits for a reader; the last one for ever.
    thread::spawn(move || {
        let _ = fs::write(&path, content);
        while fs::write(&path, []).is_ok() {}
    });
}

#[test]
fn every_file_is_read_once() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a/f_0.exr", "a/f_1.exr", "b/f_0.exr", "b/f_1.exr"] {
        let layer = |name: &str, channels: &[&str], value: f32| {
            let values = pixels(|_, _| vec![value; channels.len()]);
            Layer::from_interleaved(name, channels, channels.len(), &values)
        };
        let motion = [layer("motion", &["X", "Y", "Z", "W"], 0.0), layer("view_depth", &["Z"], 1.0)];
        let layers = motion.into_iter().chain([layer("variance", &["R", "G", "B"], 1.0)]);
        write_pipe(&folder.path().join(name), layers.collect());
    }
    let found = report(folder.path(), "compare a b --metric z-test,temporal_pixel --json");
    assert_eq!(found["motion"], "layers motion and view_depth of b; pixels that come into view do not count");
    near(&found["metrics"]["z-test"]["mean"], 1.0);
    near(&found["metrics"]["temporal_pixel"]["mean"], 0.0);
}

#[test]
fn limits_are_on_the_mean() {
    let folder = sequences();
    let code = |limits: &str| pt(folder.path(), &format!("compare a b {limits}")).status.code();
    assert_eq!(code("--max temporal_pixel=0.025 --max relmse=0.0124"), Some(0));
    assert_eq!(code("--max temporal_pixel=0.024"), Some(1));
    assert_eq!(code("--metric relmse --max relmse=0.0123"), Some(1));
    // One frame has no change, and what is not known passes no limit.
    fs::create_dir(folder.path().join("one")).unwrap();
    fs::copy(folder.path().join("a/f_0001.exr"), folder.path().join("one/f_0001.exr")).unwrap();
    assert_eq!(pt(folder.path(), "compare one one --max temporal_block=1").status.code(), Some(1));
}

/// A ramp that moves by 2 pixels a frame before a still reference: its change is none along the motion.
#[test]
fn changes_are_measured_along_the_motion_of_the_files() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let ramp = |shift: f32| move |x: u32, _: u32| 1.0 + 0.02 * (x as f32 - shift);
    let layer = |name: &str, channels: &[&str], value: &dyn Fn(u32) -> Vec<f32>| {
        Layer::from_interleaved(name, channels, channels.len(), &pixels(|x, _| value(x)))
    };
    let offset = -2.0 / SIZE[0] as f32;
    for frame in 0..2u32 {
        let name = |folder: &str| at.join(format!("{folder}/f_{frame}.exr"));
        // The right half has an error that flickers.
        let spoiled = move |x: u32, y: u32| {
            ramp(2.0 * frame as f32)(x, y) + if x >= 20 && frame == 1 { 0.5 } else { 0.0 }
        };
        let motion = |depth: f32| {
            vec![
                layer("motion", &["X", "Y", "Z", "W"], &|_| vec![offset, 0.0, 0.0, 1e18]),
                layer("view_depth", &["Z"], &|x| vec![if x >= 18 { depth } else { 5.0 }]),
            ]
        };
        write(&name("plain"), ramp(2.0 * frame as f32), Vec::new());
        write(&name("spoiled"), spoiled, Vec::new());
        write(&name("still"), |_, _| 1.0, Vec::new());
        write(&name("moving"), |_, _| 1.0, motion(5.0));
        // What the right half shows was not there in the frame before.
        write(&name("new"), |_, _| 1.0, motion(5.0 + 2.0 * frame as f32));
        let vectors = |x: u32| vec![if x >= 20 { 0.0 } else { offset }, 0.0];
        let seen = |x: u32| vec![if x >= 20 { 0.0 } else { 1.0 }];
        let layers = vec![layer("motion", &["X", "Y"], &vectors), layer("coverage", &["A"], &seen)];
        write(&name("path_traced"), |_, _| 1.0, layers);
        write(&name("a_moves"), ramp(2.0 * frame as f32), motion(5.0));
    }
    let measured = |a: &str, b: &str| {
        let found = report(at, &format!("compare {a} {b} --json"));
        let value = found["frames"][1]["temporal_pixel"].as_f64().unwrap();
        (value, found["motion"].as_str().unwrap().to_owned())
    };
    // Without motion each pixel changes by 0.04.
    let (value, motion) = measured("plain", "still");
    assert!((value - 0.0016 / 1.01).abs() < 1e-6 && motion.contains("still camera"), "{value} {motion}");
    let (value, motion) = measured("plain", "moving");
    assert!(value < 1e-9 && motion.starts_with("layers motion and view_depth of b"), "{value} {motion}");
    let (value, motion) = measured("a_moves", "still");
    assert!(value < 1e-9 && motion.starts_with("layers motion and view_depth of a"), "{value} {motion}");
    // The error of the right half counts, unless that comes into view or shows no surface.
    let (value, _) = measured("spoiled", "moving");
    assert!((value - 20.0 / 38.0 * 0.25 / 1.01).abs() < 1e-5, "{value}");
    let (value, _) = measured("spoiled", "new");
    assert!(value < 1e-9, "{value}");
    let (value, motion) = measured("spoiled", "path_traced");
    assert!(value < 1e-9 && motion == "layer motion of b", "{value} {motion}");
    // A region: what moved in from outside of it is not known.
    let region = |x: u32| {
        let line = format!("compare spoiled moving --json --region {x},4,10,6");
        report(at, &line)["frames"][1]["temporal_pixel"].as_f64().unwrap()
    };
    assert!(region(5) < 1e-9);
    assert!((region(25) - 0.25 / 1.01).abs() < 1e-5, "{}", region(25));
}

#[test]
fn frames_are_found_by_their_number() {
    let folder = sequences();
    let at = folder.path();
    // As a capture has them, beside other files.
    fs::create_dir(at.join("cap")).unwrap();
    for frame in [0, 1, 2, 4] {
        for name in ["frame", "reference"] {
            fs::copy(at.join("b/f_0000.exr"), at.join(format!("cap/{name}_{frame:06}.exr"))).unwrap();
        }
    }
    fs::write(at.join("cap/index.json"), "{}").unwrap();
    let expected = report(at, "compare a b --json");
    let found = report(at, "compare a cap/reference_######.exr --json");
    assert_eq!(found["metrics"], expected["metrics"]);
    assert_eq!(found["frames"][3]["b"], "cap/reference_000004.exr");
    assert_eq!(report(at, "compare a/f_####.exr b --json")["metrics"], expected["metrics"]);
    refused(
        at,
        "compare a cap",
        "cap/frame_000000.exr and cap/reference_000000.exr are both of frame 0; give a run of # for the number instead of the folder, as cap/reference_######.exr",
    );
    refused(
        at,
        "compare a b/f_%04d.exr",
        "a run of # stands for the number of the frame here, for example ####",
    );
}

#[test]
fn sequences_that_do_not_match_are_refused() {
    let folder = sequences();
    let at = folder.path();
    fs::create_dir(at.join("empty")).unwrap();
    fs::write(at.join("empty/notes.txt"), "0").unwrap();
    refused(at, "compare a empty", "empty: has no frames (png, jpg, jpeg, hdr, exr)");
    refused(at, "compare a b/g_#.exr", "b/g_#.exr: has no frames");
    refused(at, "compare none/f_#.exr b", "cannot read none: No such file");
    refused(at, "compare a none", "a is a sequence of frames and none is not");
    refused(at, "compare a b --heatmap h.png", "--heatmap is of two images");
    refused(at, "compare a b --region 38,0,4,4", "reaches outside a/f_0000.exr (40x24 pixels)");
    refused(
        at,
        "compare a/f_0000.exr b/f_0000.exr --max temporal_pixel=1",
        "temporal_pixel is of the change from frame to frame; give two sequences",
    );
    refused(
        at,
        "compare a b --metric z-test",
        "z-test needs the variances of both images: a/f_0000.exr is no EXR",
    );

    fs::remove_file(at.join("b/f_0002.exr")).unwrap();
    refused(at, "compare a b", "b lacks frame 2, which is a/f_0002.exr in the other sequence");
    fs::remove_file(at.join("b/f_0004.exr")).unwrap();
    refused(at, "compare b a", "b lacks frame 2, which is a/f_0002.exr in the other sequence, and 1 more");

    let odd = |name: &str, width: u32| {
        let path = at.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        write_png(&path, width, 1, PixelLayout::Rgb, &vec![9; 3 * width as usize]).unwrap();
    };
    for (name, width) in [("c/0.png", 4), ("c/1.png", 3), ("d/0.png", 4), ("d/1.png", 4), ("e/last.png", 4)] {
        odd(name, width);
    }
    refused(
        at,
        "compare c c",
        "c/1.png has 3x1 pixels and c/0.png 4x1; the frames of a sequence have one size",
    );
    refused(at, "compare c d", "cannot compare c/1.png with d/1.png: the images differ in size: 3x1 and 4x1");
    refused(at, "compare e d", "e/last.png: the name has no number of a frame");
}
