//! The benchmarks of the frame, and their comparison.

use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn pt(folder: &Path, line: &str) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_pt"));
    program.current_dir(folder).args(line.split_whitespace()).env_remove("RUST_BACKTRACE");
    if let Some(device) = std::env::var_os("PT_TEST_DEVICE").filter(|_| !line.contains("compare")) {
        program.arg("--device").arg(device);
    }
    program.output().unwrap()
}

fn succeeds(folder: &Path, line: &str) -> String {
    let done = pt(folder, line);
    assert!(done.status.success(), "pt {line}: {done:?}");
    String::from_utf8(done.stdout).unwrap()
}

fn refused(folder: &Path, line: &str, parts: &[&str]) {
    let done = pt(folder, line);
    let said = String::from_utf8(done.stderr).unwrap();
    assert_eq!(done.status.code(), Some(2), "pt {line}: {said}");
    assert!(said.starts_with("error: ") && said.lines().count() == 1, "pt {line}: {said}");
    assert!(parts.iter().all(|part| said.contains(part)), "pt {line}: no {parts:?} in {said}");
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

const SMALL: &str = "--scene cornell --size 33x18 --backend compute --rounds 3 --frames 2";

fn passes<'a>(file: &'a Value, part: &str) -> &'a Vec<Value> {
    let parts = file["parts"].as_array().unwrap();
    parts.iter().find(|there| there["name"] == part).unwrap()["passes"].as_array().unwrap()
}

/// Every time of every pass is there; rays are counted on the device; the stages that need no rays also run alone.
#[test]
fn the_frame_and_its_stages() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let line = format!("bench all {SMALL} --set denoise.variant=accumulate --validation --json all.json");
    let said = succeeds(at, &line);
    for part in ["primary rays", "of copy", "copying", "<= ", "% of the frame", "without rays"] {
        assert!(said.contains(part), "no {part} in {said}");
    }
    let file = json(&at.join("all.json"));
    let names: Vec<_> = file["parts"].as_array().unwrap().iter().map(|part| part["name"].clone()).collect();
    assert_eq!(names, ["frame", "denoise", "checkerboard", "post"]);
    assert_eq!(file["command"], format!("pt {line}"));
    let frame = passes(&file, "frame");
    for pass in frame {
        let rounds = pass["ms"].as_array().unwrap();
        assert!(
            rounds.len() == 3 && rounds.iter().all(|round| round.as_array().unwrap().len() == 2),
            "{pass}"
        );
    }
    // Fields are 17 wide, and each texel has a ray.
    let rays = |name: &str| frame.iter().find(|pass| pass["pass"] == name).unwrap()["rays"].clone();
    assert_eq!(
        rays("primary rays"),
        serde_json::json!({ "kind": "primary", "count": 34 * 18, "is_upper_bound": false })
    );
    // The room fills half of the picture; some of its surfaces have neither a shadow ray to the lamp nor a bounce ray.
    for name in ["shadow rays", "bounce rays", "bounce shadow rays"] {
        let (rays, texels) = (rays(name), 34 * 18);
        assert_eq!(rays["is_upper_bound"], false, "{name}");
        let count = rays["count"].as_u64().unwrap();
        assert!((texels / 8..=texels).contains(&count), "{name}: {count} rays of {texels} texels");
    }
    let kinds: Vec<_> =
        file["yardsticks"]["mrays_per_s"].as_array().unwrap().iter().map(|row| row[0].clone()).collect();
    assert_eq!(kinds, ["primary", "bounce", "shadow", "bounce-shadow"]);
    // Alone, a stage has the passes that it has in the frame, but for those that need rays or come before.
    for stage in ["denoise", "checkerboard", "post"] {
        let of_stage: Vec<_> =
            frame.iter().filter(|pass| pass["stage"] == stage).map(|pass| &pass["pass"]).collect();
        let alone: Vec<_> = passes(&file, stage).iter().map(|pass| &pass["pass"]).collect();
        assert_eq!(alone, of_stage);
        assert!(!alone.is_empty());
    }
    // Whole frames are at least as long as their passes.
    let frame_ms = file["parts"][0]["time"]["ms"][0][0].as_f64().unwrap();
    let sum: f64 = frame.iter().map(|pass| pass["ms"][0][0].as_f64().unwrap()).sum();
    assert!(frame_ms >= 0.999 * sum, "{frame_ms} ms, its passes {sum} ms");
}

/// A run against itself shows nothing, a pass that takes half as long again is named, and files that do not fit are refused.
#[test]
fn two_runs_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let bench = format!("bench stage checkerboard {SMALL} --set indirect.bounces=0 --times-only --json");
    succeeds(at, &format!("{bench} a.json"));
    let said = succeeds(at, "bench compare a.json a.json");
    assert!(
        said.ends_with("no regression of more than 2 %\n") && said.contains("no difference shown"),
        "{said}"
    );

    let change = |name: &str, edit: &dyn Fn(&mut Value)| {
        let mut file = json(&at.join("a.json"));
        edit(&mut file);
        fs::write(at.join(name), file.to_string()).unwrap();
    };
    let slower = |file: &mut Value, factor: f64| {
        let pass = &mut file["parts"][0]["passes"][0];
        assert_eq!(pass["pass"], "interleave");
        for round in pass["ms"].as_array_mut().unwrap() {
            round
                .as_array_mut()
                .unwrap()
                .iter_mut()
                .for_each(|ms| *ms = (factor * ms.as_f64().unwrap()).into());
        }
    };
    change("slow.json", &|file| slower(file, 1.5));
    let done = pt(at, "bench compare a.json slow.json --least-ms 0 --json rows.json");
    let said = String::from_utf8(done.stdout).unwrap();
    assert_eq!(done.status.code(), Some(1), "{said}");
    assert!(said.ends_with("slower by more than 2 %: interleave (checkerboard)\n"), "{said}");
    let rows = json(&at.join("rows.json"));
    assert_eq!(rows["regressions"], serde_json::json!(["interleave (checkerboard)"]));
    assert!((rows["rows"][0]["ratio"].as_f64().unwrap() - 1.5).abs() < 1e-6, "{rows}");
    succeeds(at, "bench compare slow.json a.json --least-ms 0");
    succeeds(at, "bench compare a.json slow.json --threshold 60");

    change("size.json", &|file| file["size"] = serde_json::json!([64, 36]));
    change("scene.json", &|file| file["scene"] = "gallery".into());
    change("device.json", &|file| file["device"] = "another".into());
    change("version.json", &|file| file["format"] = 99.into());
    change("few.json", &|file| file["rounds"] = serde_json::json!([2]));
    for (file, part) in [
        ("size", "the size is 33x18 and 64x36"),
        ("scene", "the scene is cornell and gallery"),
        ("device", "another"),
    ] {
        refused(at, &format!("bench compare a.json {file}.json"), &["do not fit together", part]);
    }
    refused(at, "bench compare few.json few.json", &["2 rounds", "at least 3"]);
    refused(at, "bench compare a.json version.json", &["version.json", "version 99"]);
    fs::write(at.join("other.json"), "{}").unwrap();
    refused(at, "bench compare other.json a.json", &["other.json: is no benchmark"]);
    refused(at, "bench compare a.json a.json --json a.json", &["one of the benchmarks"]);

    // Runs in turns: each is a sample.
    for _ in 0..2 {
        succeeds(at, &format!("{bench} a.json --append"));
    }
    let file = json(&at.join("a.json"));
    assert_eq!(file["rounds"], serde_json::json!([3, 3, 3]));
    assert_eq!(file["parts"][0]["passes"][0]["ms"].as_array().unwrap().len(), 9);
    refused(at, "bench compare slow.json a.json", &["3 rounds of a run and 3 runs"]);
    assert!(succeeds(at, "bench compare a.json a.json").contains("9 rounds of 2 frames in 3 runs"));
    let other = bench.replace("33x18", "32x18");
    refused(at, &format!("{other} a.json --append"), &["a.json: holds another benchmark", "33x18 and 32x18"]);
    refused(at, &format!("bench stage indirect {SMALL} --set indirect.bounces=0"), &["indirect", "no pass"]);
}

/// Frames are shown with and without the panel, then the panel alone.
#[cfg(feature = "view")]
#[test]
fn what_the_panel_takes() {
    let folder = tempfile::tempdir().unwrap();
    let said = succeeds(folder.path(), "bench panel --scene flicker --size 48x27 --frames 2");
    let [frames, panel] = said.lines().collect::<Vec<_>>()[..] else { panic!("{said}") };
    let numbers = |line: &str| -> Vec<f64> {
        let words = line.split(|c: char| !c.is_ascii_digit() && c != '.');
        words.filter_map(|word| word.parse().ok()).collect()
    };
    // The size, then median, least and most, with the panel and without.
    let [48.0, 27.0, with, slow, fast, without, slower, faster, 5.0, 2.0] = numbers(frames)[..] else {
        panic!("{frames}")
    };
    assert!(0.0 < slow && slow <= with && with <= fast, "{frames}");
    assert!(0.0 < slower && slower <= without && without <= faster, "{frames}");
    assert!(panel.starts_with("panel at 48x27: ") && panel.contains("; 2 pictures"), "{panel}");
    refused(folder.path(), "bench panel --scene nowhere", &["nowhere", "built-in"]);
}
