//! `pt study`: the shipped studies are valid, a killed study goes on to the same bytes, and the ledger adds up.

use pt_core::capture::keys;
use pt_image::image_file::{ImageState, LayeredImage, LinearImage};
use pt_image::metrics::{Metric, compare};
use pt_study::folder::{read_results, read_study};
use pt_study::record::CellRecord;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

fn pt(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pt"));
    command.current_dir(folder).args(args).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn run(folder: &Path, args: &[&str]) -> Output {
    pt(folder, args).output().unwrap()
}

/// Standard output of a command that succeeds.
fn text(folder: &Path, args: &[&str]) -> String {
    let output = run(folder, args);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// The one line of an error, with exit code 2.
fn refused(folder: &Path, args: &[&str]) -> String {
    let output = run(folder, args);
    assert_eq!(output.status.code(), Some(2), "{args:?}");
    let line = String::from_utf8(output.stderr).unwrap();
    assert_eq!(line.trim_end().lines().count(), 1, "{line}");
    line
}

#[test]
fn shipped_studies_are_valid() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../studies");
    let files: Vec<PathBuf> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    let names = [
        "bounces",
        "checkerboard",
        "denoiser",
        "frame",
        "gradient-filter",
        "gradient-filter-still",
        "gradient-projection",
        "light-samplers",
        "random",
        "restir-gi",
        "restir-under-denoiser",
        "sh-vs-rgb",
        "stabilisers",
        "upscalers",
    ];
    for name in names {
        assert!(files.contains(&folder.join(format!("{name}.toml"))), "{name}");
    }
    for file in &files {
        let text = text(&folder, &["study", file.to_str().unwrap(), "--dry-run"]);
        assert!(
            text.contains(" cells: ") && text.contains("estimated time on a GPU"),
            "{}: {text}",
            file.display()
        );
    }
}

#[test]
fn what_cannot_run_is_said_in_a_line() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let write = |name: &str, rest: &str| {
        fs::write(at.join(name), format!("scenes = [\"cornell\"]\nmetrics = [\"relmse\"]\n{rest}")).unwrap();
    };
    write("key.toml", "set = { denoise.varant = \"off\" }\n");
    let line = refused(at, &["study", "key.toml", "-o", "out"]);
    assert!(
        line.contains("key.toml:3:17: unknown knob \"denoise.varant\", closest: \"denoise.variant\""),
        "{line}"
    );
    write("value.toml", "[[axis]]\nkey = \"denoise.variant\"\nvalues = [\"off\", \"svg\"]\n");
    let line = refused(at, &["study", "value.toml", "-o", "out"]);
    assert!(line.contains("value.toml:5:18: denoise.variant = svg: expected off, accumulate"), "{line}");
    write("profile.toml", "[[axis]]\nkey = \"profile\"\nvalues = [\"realtim\"]\n");
    assert!(
        refused(at, &["study", "profile.toml", "-o", "out"])
            .contains("variant realtim: profile realtim: no such file")
    );
    let many: Vec<String> = (0..1000).map(|i| i.to_string()).collect();
    let axis = |name: &str| format!("[[axis]]\nname = \"{name}\"\nvalues = [{}]\n", many.join(","));
    write("many.toml", &format!("{}{}", axis("a"), axis("b")));
    let line = refused(at, &["study", "many.toml", "--dry-run"]);
    assert!(line.contains("the study has 5000000 cells") && line.contains("--yes"), "{line}");
    write("good.toml", "");
    assert!(refused(at, &["study", "good.toml"]).contains("--output"));
    assert!(
        refused(at, &["study", "good.toml", "--dry-run", "--filter", "scene=gallery"])
            .contains("no cell has scene=gallery")
    );
    assert!(refused(at, &["study", "good.toml", "-o", "out", "--shard", "0/4"]).contains("from 1"));
    assert!(refused(at, &["study", "none.toml", "-o", "out"]).contains("none.toml"));
    fs::write(at.join("scene.toml"), "scenes = [\"cornell\", \"galery\"]\nmetrics = [\"relmse\"]\n").unwrap();
    let line = refused(at, &["study", "scene.toml", "-o", "out"]);
    assert!(
        line.contains("scene.toml:1:22: galery: neither") && line.contains("closest: \"gallery\""),
        "{line}"
    );
    // Cameras are looked for in each scene before the first cell is run, and before a device is opened.
    write("camera.toml", "cameras = [0, \"classic\",\n  \"clasic\"]\n");
    for args in [&["study", "camera.toml", "--dry-run"][..], &["study", "camera.toml", "-o", "out"]] {
        let line = refused(at, args);
        assert!(
            line.contains(
                "camera.toml:4:3: camera clasic: cornell has no such camera, closest: \"classic\"; it has 0"
            ),
            "{line}"
        );
    }
    write("index.toml", "cameras = 7\n");
    assert!(
        refused(at, &["study", "index.toml", "--dry-run"])
            .contains("index.toml:3:11: camera 7: cornell has no")
    );
    write("sky.toml", "sky = \"-2,0\"\n");
    let line = refused(at, &["study", "sky.toml", "--dry-run"]);
    assert!(
        line.contains("sky.toml:3:7: the sun is below the horizon at an elevation of -2 degrees"),
        "{line}"
    );
    // A scene beside the study file is found from elsewhere, and its cameras too.
    fs::create_dir(at.join("sub")).unwrap();
    let empty = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"scene":0,"nodes":[{"camera":0,"name":"eye"}],
        "cameras":[{"type":"perspective","perspective":{"yfov":1.0,"znear":0.1}}]}"#;
    fs::write(at.join("sub/own.gltf"), empty).unwrap();
    let own = "scenes = [\"own.gltf\"]\nmetrics = [\"relmse\"]\n";
    fs::write(at.join("sub/own.toml"), format!("{own}cameras = \"eye\"\n")).unwrap();
    text(at, &["study", "sub/own.toml", "--dry-run"]);
    fs::write(at.join("sub/own.toml"), format!("{own}cameras = \"eyes\"\n")).unwrap();
    let line = refused(at, &["study", "sub/own.toml", "--dry-run"]);
    assert!(line.contains("sub/own.toml:3:11: camera eyes") && line.contains("closest: \"eye\""), "{line}");
    // A view is no name, and a filter may leave the cells that are wrong out.
    write("view.toml", "cameras = [\"0,1,3,0,1,0\", \"clasic\"]\n");
    text(at, &["study", "view.toml", "--dry-run", "--filter", "camera=0,1,3,0,1,0"]);
    write("far.toml", "set = { wavelength = 1 }\n");
    let line = refused(at, &["study", "far.toml", "--dry-run"]);
    assert!(line.contains("unknown knob \"wavelength\" (pt knobs lists them)"), "{line}");
    write("seeds.toml", "seeds = 1000000\n");
    let line = refused(at, &["study", "seeds.toml", "--dry-run"]);
    assert!(line.contains("the study has 1000000 cells"), "{line}");
    fs::write(at.join("file"), "").unwrap();
    assert!(refused(at, &["study", "good.toml", "-o", "file"]).contains("is a file"));
    assert!(!at.join("out").exists(), "nothing is half-written");
}

/// Without a sky the floor of `plane` has 25 lux; frames and ground truth have the sky's.
#[test]
fn a_study_is_lit_by_its_sky() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let rest = "scenes = [\"plane\"]\nsizes = [\"8x8\"]\nbackends = [\"compute\"]\nseeds = 1\nframes = 8\nspp = 64\n\
                accumulate = true\nmetrics = [\"relmse\"]\nset = { profile = \"unbiased\" }\nsky = \"60,20,2\"\n";
    fs::write(at.join("sky.toml"), rest).unwrap();
    text(at, &["study", "sky.toml", "-o", "out"]);
    // If only one of both had the sky, the error would be nearly 1, or a million.
    let results = read_results(&at.join("out")).unwrap();
    let relmse = results[0].metrics["relmse"].unwrap();
    assert!((0.0..0.05).contains(&relmse), "{relmse}");
    assert!(results[0].command.contains("--sky 60,20,2"), "{}", results[0].command);
    let truth = fs::read_dir(at.join("out/references")).unwrap().next().unwrap().unwrap().path();
    let image = LinearImage::read(&truth).unwrap();
    let mean = image.pixels.iter().map(|p| p[1]).sum::<f32>() / image.pixels.len() as f32;
    assert!(mean > 1000.0, "{mean}");
}

/// Of a way with a station in each frame, the frame that is measured has the error of a camera that rests at its station.
#[test]
fn a_study_follows_the_way_of_a_camera() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::create_dir(at.join("sub")).unwrap();
    let station =
        |time: u32, eye: &str| format!(r#"{{"time": {time}, "position": [{eye}], "target": [0, 1, 0]}}"#);
    let (first, second) = ("0.9, 1.9, 2", "-0.9, 0.2, 3");
    let way = format!(r#"{{"vfov": 50, "stations": [{}, {}]}}"#, station(0, first), station(1, second));
    fs::write(at.join("sub/way.json"), way).unwrap();
    let looks = [first, second].map(|eye| format!("{},0,1,0", eye.replace(' ', "")));
    let study = |cameras: &[&str]| {
        let rest = "scenes = [\"cornell\"]\nsizes = [\"16x12\"]\nbackends = [\"compute\"]\nseeds = 1\nframes = 2\nspp = 64\nfps = 1\n\
                    pairing = \"seed\"\nmetrics = [\"relmse\"]\nset = { profile = \"unbiased\" }\n";
        fs::write(at.join("sub/way.toml"), format!("{rest}cameras = {cameras:?}\n")).unwrap();
    };
    study(&["way.json", &looks[0], &looks[1]]);
    text(at, &["study", "sub/way.toml", "-o", "out"]);
    let results = read_results(&at.join("out")).unwrap();
    let error = |i: usize| results[i].metrics["relmse"].unwrap();
    assert!((error(0) / error(2) - 1.0).abs() < 0.02, "{} {} {}", error(0), error(1), error(2));
    assert!((error(0) / error(1) - 1.0).abs() > 0.1, "{} {} {}", error(0), error(1), error(2));
    assert!(results[0].command.contains("--camera-path sub/way.json"), "{}", results[0].command);

    study(&["none.json"]);
    let line = refused(at, &["study", "sub/way.toml", "--dry-run"]);
    assert!(line.contains("sub/way.toml:11:12: cannot read none.json"), "{line}");
}

/// A denoiser of two, a placebo with the same random numbers, and a ledger over all stages that can be fed.
const SMALL: &str = r#"
question = "Does it go on?"
scenes = ["cornell"]
sizes = ["16x12"]
backends = ["compute"]
seeds = 1
frames = 2
spp = 16
metrics = ["relmse", "temporal_pixel"]
pairing = "seed"
set = { indirect.bounces = 0, reference.max_bounces = 0, post.taa.enabled = true, gbuffer.jitter = "halton" }

[[axis]]
name = "placebo"
values = ["a", "b"]

[ledger]
stages = ["taa", "denoise", "lights", "indirect"]
"#;

#[test]
fn a_killed_study_goes_on_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("small.toml"), SMALL).unwrap();
    let started = Instant::now();
    let printed = text(at, &["study", "small.toml", "-o", "whole", "--cache", "cache"]);
    let whole = started.elapsed();
    assert!(
        printed.contains("no difference shown") && printed.contains("\n1 seed: nothing tells"),
        "{printed}"
    );
    // At nine moments before the first cell, and once as soon as a cell is there: none of them leaves anything that is not whole.
    let cells = at.join("killed/cells");
    let finished = || {
        fs::read_dir(&cells).is_ok_and(|list| {
            list.flatten().any(|entry| entry.path().extension().is_some_and(|end| end == "jsonl"))
        })
    };
    for kill in 1..=10 {
        let mut killed =
            pt(at, &["study", "small.toml", "-o", "killed", "--cache", "cache", "--resume"]).spawn().unwrap();
        // The fractional parts of multiples of the golden ratio.
        sleep(whole.mul_f64((f64::from(kill) * 0.618_034).fract() / 6.0));
        while kill == 10 && !finished() && killed.try_wait().unwrap().is_none() {
            sleep(Duration::from_millis(5));
        }
        killed.kill().unwrap();
        killed.wait().unwrap();
        assert!(!at.join("killed/results.jsonl").exists(), "it was killed before its end");
    }
    text(at, &["study", "small.toml", "-o", "killed", "--cache", "cache", "--resume"]);
    let bytes = |name: &str| fs::read(at.join(name).join("results.jsonl")).unwrap();
    assert!(bytes("killed") == bytes("whole"), "the same bytes");

    let record = read_study(&at.join("whole")).unwrap();
    assert_eq!((record.cells, record.baseline.as_str()), (2, "a"));
    let results = read_results(&at.join("whole")).unwrap();
    for CellRecord { metrics, frames, ledger, images, .. } in &results {
        assert!(metrics["relmse"].unwrap() > 0.0 && metrics["temporal_pixel"].unwrap() > 0.0, "{metrics:?}");
        assert_eq!(frames["relmse"].len(), 1);
        assert!(images.values().all(|name| at.join("whole").join(name).is_file()));
        let ledger = ledger.as_ref().unwrap();
        let names: Vec<_> = ledger.parts.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["lights", "indirect", "denoise", "taa"]);
        let sum: f64 = ledger.parts.iter().map(|(_, part)| part).sum::<f64>() + ledger.interaction;
        assert!((sum - ledger.total).abs() <= 1e-12 * ledger.total, "{ledger:?}");
        assert!((ledger.total - metrics["relmse"].unwrap()).abs() <= 1e-12, "the error that was measured");
        // With ground truth after TAA nothing is left but the rounding to half floats: 2^-11 of each value, squared.
        assert!(ledger.interaction.abs() < 1e-6, "{ledger:?}");
        // No bounces: nothing to feed.
        assert_eq!(ledger.parts[1].1, 0.0, "{ledger:?}");
        // Noise, what a pixel of one sample misses, and the rest.
        assert!(ledger.parts[0].1 > 0.1 * ledger.total, "{ledger:?}");
        assert!(ledger.parts[2].1 > 0.1 * ledger.total, "{ledger:?}");
    }
    // The placebo has the same random numbers and the same result.
    assert_eq!(results[0].frames, results[1].frames);

    let report = at.join("whole/report.html");
    assert!(printed.trim_end().ends_with("report.html") && report.is_file(), "{printed}");
    fs::remove_file(&report).unwrap();
    let again = text(at, &["study", "report", "whole", "--markdown", "found.md", "--figure", "found.svg"]);
    assert!(printed.ends_with(&again) && report.is_file(), "{again}");
    let table = fs::read_to_string(at.join("found.md")).unwrap();
    let row = table.lines().find(|line| line.starts_with("| b |")).unwrap();
    assert_eq!(row.split(" | ").count(), 8, "{row}");
    assert!(row.contains("no difference shown") && !row.ends_with("- |"), "{row}");
    let figure = fs::read_to_string(at.join("found.svg")).unwrap();
    // The file, and a panel in it; the legend names the variants.
    assert!(figure.trim_start().starts_with("<svg xmlns") && figure.matches("<svg").count() >= 2, "{figure}");
    assert!(figure.contains(">a</text>") && figure.contains(">b</text>"), "{figure}");
}

/// Lights of `flicker` move and blink while the camera stands.
#[test]
fn a_scene_that_moves_has_a_reference_for_each_measured_frame() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let study = |scene: &str| {
        format!(
            "scenes = [\"{scene}\"]\nsizes = [\"16x12\"]\nbackends = [\"compute\"]\nseeds = 1\nframes = 2\nmeasure = 2\nspp = 4\nmetrics = [\"relmse\"]\n"
        )
    };
    for (scene, references) in [("flicker", 2), ("cornell", 1)] {
        fs::write(at.join("moving.toml"), study(scene)).unwrap();
        text(at, &["study", "moving.toml", "-o", scene]);
        let kept = fs::read_dir(at.join(scene).join("references")).unwrap();
        let kept = kept.flatten().filter(|entry| entry.path().extension().is_some_and(|end| end == "exr"));
        assert_eq!(kept.count(), references, "{scene}");
    }
}

/// The picture as shown is measured: the ledger has a part of the exposure, which noise in the frame moves.
#[test]
fn the_ledger_of_the_picture_as_shown_adds_up() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let stages = "stages = [\"taa\", \"denoise\", \"lights\", \"tonemap\"]";
    let shown = SMALL
        .replace("stages = [\"taa\", \"denoise\", \"lights\", \"indirect\"]", stages)
        .replace("values = [\"a\", \"b\"]", "values = [\"a\"]");
    fs::write(at.join("radiance.toml"), &shown).unwrap();
    let line = refused(at, &["study", "radiance.toml", "-o", "radiance"]);
    assert!(line.contains("radiance.toml:18:39: radiance is measured before the tone map"), "{line}");
    fs::write(at.join("shown.toml"), format!("measure_at = \"display\"{shown}")).unwrap();
    let printed = text(at, &["study", "shown.toml", "-o", "shown"]);
    assert!(printed.contains("noise of the reference: ") && printed.contains("display values"), "{printed}");
    let results = read_results(&at.join("shown")).unwrap();
    let (cell, ledger) = (&results[0], results[0].ledger.as_ref().unwrap());
    let names: Vec<_> = ledger.parts.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["tonemap", "lights", "denoise", "taa"]);
    for ledger in ledger.frames.iter().chain([ledger]) {
        let sum: f64 = ledger.parts.iter().map(|(_, part)| part).sum::<f64>() + ledger.interaction;
        assert!((sum - ledger.total).abs() <= 1e-12 * ledger.total, "{ledger:?}");
    }
    assert!((ledger.total - cell.metrics["relmse"].unwrap()).abs() <= 1e-12);
    // The same codes but for those that the rounding of TAA to half floats moves by one.
    assert!(ledger.interaction.abs() < 1e-4 && ledger.interaction.abs() < 0.01 * ledger.total, "{ledger:?}");
    assert!(ledger.parts[0].1 != 0.0, "{ledger:?}");
    let noise = ledger.reference_noise.unwrap();
    assert!(noise > 0.0 && noise < ledger.total, "{ledger:?}");
    assert!(fs::read_to_string(at.join("shown/report.html")).unwrap().contains("Noise of the reference"));
    // In radiance it is the error between both layers of the reference.
    let radiance = SMALL.replace("values = [\"a\", \"b\"]", "values = [\"a\"]");
    let radiance = radiance.replace("[\"taa\", \"denoise\", \"lights\", \"indirect\"]", "[\"taa\"]");
    fs::write(at.join("radiance.toml"), radiance).unwrap();
    text(at, &["study", "radiance.toml", "-o", "radiance"]);
    let found =
        read_results(&at.join("radiance")).unwrap()[0].ledger.as_ref().unwrap().reference_noise.unwrap();
    let mut errors = Vec::new();
    for entry in fs::read_dir(at.join("radiance/references")).unwrap() {
        let file = LayeredImage::read_exr(&entry.unwrap().path()).unwrap();
        let layer = |name: &str| {
            let [r, g, b] = ["R", "G", "B"].map(|c| file.channel(name, c).unwrap().to_f32());
            let pixels = (0..r.len()).map(|i| [r[i], g[i], b[i]]).collect();
            LinearImage { width: file.width, height: file.height, pixels, state: ImageState::SceneReferred }
        };
        errors.push(compare(&layer("half"), &layer(""), &[Metric::RelMse]).unwrap()[0].value);
    }
    assert!(
        found > 0.0 && errors.iter().any(|error| (error - found).abs() <= 1e-6 * found),
        "{found} {errors:?}"
    );
}

/// Whatever the noise of the frame, it is shown with the exposure of the ground truth.
#[test]
fn a_fed_tone_map_has_the_exposure_of_the_ground_truth() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let exposure = |options: &[&str], seed: &str| {
        let words =
            ["render", "cornell", "--size", "16x12", "--backend", "compute", "--seed", seed, "-o", "x.exr"];
        text(at, &[&words[..], options].concat());
        LayeredImage::read_exr(&at.join("x.exr")).unwrap().metadata[keys::EXPOSURE].clone()
    };
    let fed = ["--oracle", "tonemap", "--oracle-spp", "64"];
    assert_ne!(exposure(&[], "1"), exposure(&[], "2"));
    assert_eq!(exposure(&fed, "1"), exposure(&fed, "2"));
    let manual = ["--set", "post.exposure=manual"];
    let line =
        refused(at, &[&["render", "cornell", "--size", "16x12", "-o", "x.exr"][..], &fed, &manual].concat());
    assert!(line.contains("the frame has no tonemap to feed"), "{line}");
}

/// FSR 1 upscales after the tone map, where the picture as shown is measured.
#[test]
fn fsr_is_measured_in_the_picture_as_shown() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let study = "scenes = [\"textures\"]\nsizes = [\"32x18\"]\nbackends = [\"compute\"]\nseeds = 1\nframes = 3\nspp = 16\n\
                 metrics = [\"relmse\", \"flip\", \"temporal_pixel\"]\nset = { indirect.bounces = 0, reference.max_bounces = 0, post.exposure = \"manual\" }\n\
                 [[variant]]\nname = \"native\"\n\
                 [[variant]]\nname = \"fsr\"\nset = { post.upscale = \"fsr1\", post.render_scale = 0.5 }\n\
                 [[variant]]\nname = \"taau\"\nset = { post.upscale = \"taau\", post.render_scale = 0.5 }\n";
    fs::write(at.join("radiance.toml"), study).unwrap();
    let line = refused(at, &["study", "radiance.toml", "-o", "radiance", "--filter", "variant=fsr"]);
    assert!(
        line.contains("fsr1 upscales the tone-mapped picture; measure_at = \"display\" measures it"),
        "{line}"
    );
    fs::write(at.join("shown.toml"), format!("measure_at = \"display\"\n{study}")).unwrap();
    text(at, &["study", "shown.toml", "-o", "shown"]);
    let cells = read_results(&at.join("shown")).unwrap();
    assert_eq!(cells.iter().map(|cell| cell.variant.as_str()).collect::<Vec<_>>(), ["native", "fsr", "taau"]);
    for cell in &cells {
        assert!(cell.metrics.values().all(|value| value.unwrap() > 0.0), "{cell:?}");
        // All are compared with the same picture of the ground truth.
        assert_eq!(cell.images["reference"], cells[0].images["reference"]);
        // What is measured is what the command of the cell shows, code by code.
        let words: Vec<_> = cell.command.split(' ').skip(1).map(|word| word.trim_matches('\'')).collect();
        let command = words.iter().map(|word| if *word == "frame.exr" { "frame.png" } else { *word });
        text(at, &command.collect::<Vec<_>>());
        let picture = |path: PathBuf| LinearImage::read(&path).unwrap().pixels;
        assert!(picture(at.join("frame.png")) == picture(at.join("shown").join(&cell.images["picture"])));
    }
    fs::write(at.join("hdr.toml"), format!("measure_at = \"display\"\n{study}").replace("flip", "hdr-flip"))
        .unwrap();
    let line = refused(at, &["study", "hdr.toml", "-o", "hdr"]);
    assert!(line.contains("hdr.toml:8:22: hdr-flip exposes radiance itself"), "{line}");
    let encoded = study.replace("post.exposure", "post.encoding = \"pq\", post.exposure");
    fs::write(at.join("pq.toml"), format!("measure_at = \"display\"\n{encoded}")).unwrap();
    assert!(refused(at, &["study", "pq.toml", "-o", "pq"]).contains("post.encoding is pq"));
}

/// Pictures of two seeds differ by their noise alone: with the mean of 64 runs its variance is 1/64 of that of one run.
#[test]
fn light_that_is_fed_has_no_noise() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let noise = |options: &[&str]| {
        let image = |seed: &str| {
            let words = [
                "render",
                "cornell",
                "--size",
                "16x12",
                "--backend",
                "compute",
                "--set",
                "gbuffer.jitter=none",
            ];
            let name = format!("{seed}.exr");
            text(at, &[&words[..], options, &["--seed", seed, "-o", &name]].concat());
            LinearImage::read(&at.join(name)).unwrap()
        };
        compare(&image("1"), &image("2"), &[Metric::RelMse]).unwrap()[0].value
    };
    let (once, fed) = (noise(&[]), noise(&["--oracle", "lights,indirect", "--oracle-spp", "64"]));
    let ratio = once / fed;
    // The spread of a ratio of two sums over 192 pixels of skewed noise.
    assert!((32.0..128.0).contains(&ratio), "{once} {fed}: {ratio}");
    let line = refused(at, &["render", "cornell", "--size", "16x12", "--oracle", "taa", "-o", "x.png"]);
    assert!(line.contains("the frame has no taa to feed"), "{line}");
}

#[test]
fn recorded_references_are_of_the_same_view() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    text(
        at,
        &[
            "capture",
            "plane",
            "--size",
            "16x12",
            "--frames",
            "0..2",
            "--reference-spp",
            "4",
            "--backend",
            "compute",
            "-o",
            "recorded",
        ],
    );
    let study = |scene: &str, rest: &str| {
        let head = "against = \"recorded\"\nmetrics = [\"relmse\"]\nseeds = 1\nframes = 2\nbackends = [\"compute\"]\n";
        fs::write(at.join("s.toml"), format!("scenes = [\"{scene}\"]\n{head}{rest}")).unwrap();
    };
    study("plane", "sizes = [\"16x12\"]\n");
    text(at, &["study", "s.toml", "-o", "same"]);
    let value = read_results(&at.join("same")).unwrap()[0].metrics["relmse"].unwrap();
    assert!(value > 0.0 && value < 1.0, "{value}");
    study("cornell", "sizes = [\"16x12\"]\n");
    let line = refused(at, &["study", "s.toml", "-o", "scene"]);
    assert!(line.contains("s.toml:2:11: recorded: is of the scene plane, the study of cornell"), "{line}");
    study("plane", "cameras = [\"above\"]\nsizes = [\"16x12\"]\n");
    assert!(refused(at, &["study", "s.toml", "-o", "camera"]).contains("with another camera"));
    study("plane", "sizes = [\"16x12\", \"8x6\"]\n");
    let line = refused(at, &["study", "s.toml", "--dry-run"]);
    assert!(line.contains("s.toml:2:11: recorded: has frames of 16x12, the study of 8x6"), "{line}");
    study("plane", "sizes = [\"16x12\"]\nmeasure = \"0..3\"\n");
    assert!(refused(at, &["study", "s.toml", "-o", "frames"]).contains("within 0..2"));
    study("plane", "sizes = [\"16x12\"]\n");
    let longer = fs::read_to_string(at.join("s.toml")).unwrap().replace("frames = 2", "frames = 3");
    fs::write(at.join("s.toml"), longer).unwrap();
    let line = refused(at, &["study", "s.toml", "--dry-run"]);
    assert!(line.contains("recorded: has the frames 0..2, and the study measures 2"), "{line}");
    // Another version, which is seen before a scene is opened.
    let index = at.join("recorded/index.json");
    let changed = fs::read_to_string(&index)
        .unwrap()
        .replace(&format!("\"{}\"", env!("CARGO_PKG_VERSION")), "\"0.0.7\"");
    fs::write(&index, changed).unwrap();
    study("plane", "sizes = [\"16x12\"]\n");
    let line = refused(at, &["study", "s.toml", "--dry-run"]);
    assert!(line.contains("s.toml:2:11: ") && line.contains("was recorded by version 0.0.7"), "{line}");
}
