//! The contract of the `pt` program: what it writes, that it repeats itself bit by bit, and how it refuses.

use pt_core::trace::CLEARLY_FASTER;
use pt_image::image_file::{LayeredImage, LinearImage, Samples};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// The program in a folder of its own, on the device that the tests are run on.
fn pt(folder: &Path, line: &str) -> Command {
    let mut program = Command::new(env!("CARGO_BIN_EXE_pt"));
    program.current_dir(folder).args(line.split_whitespace()).env_remove("RUST_BACKTRACE");
    let takes_device = ["render", "passes", "info", "bench"].iter().any(|command| line.starts_with(command));
    if let Some(device) =
        std::env::var_os("PT_TEST_DEVICE").filter(|_| takes_device && !line.contains("--device"))
    {
        program.arg("--device").arg(device);
    }
    program
}

fn succeeds(folder: &Path, line: &str) -> String {
    let done = pt(folder, line).output().unwrap();
    assert!(done.status.success(), "pt {line}: {done:?}");
    String::from_utf8(done.stdout).unwrap()
}

fn files(folder: &Path) -> BTreeSet<PathBuf> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect()
}

/// One line on standard error with all of `parts`, exit code 2, and no file more than before.
fn refused_by(mut program: Command, parts: &[&str]) {
    let folder = program.get_current_dir().unwrap().to_owned();
    let before = files(&folder);
    let Output { status, stdout, stderr } = program.output().unwrap();
    let message = String::from_utf8(stderr).unwrap();
    assert_eq!(status.code(), Some(2), "{program:?}: {message}");
    assert!(message.starts_with("error: ") && message.lines().count() == 1, "{program:?}: {message}");
    assert!(parts.iter().all(|part| message.contains(part)), "{program:?}: no {parts:?} in {message}");
    assert!(stdout.is_empty(), "{program:?}");
    assert_eq!(files(&folder), before, "{program:?} left something behind");
}

fn refused(folder: &Path, line: &str, parts: &[&str]) {
    refused_by(pt(folder, line), parts);
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

#[test]
fn unknown_names_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |line: &str, parts: &[&str]| {
        refused(
            folder.path(),
            &format!("render {line} --size 8x8 -o a.png -o a.exr --timings t.json"),
            parts,
        );
    };
    refused(
        "cornel",
        &[
            "cornel",
            "neither a file nor a built-in scene",
            "cornell, effects, field, flicker, furnace, gallery",
        ],
    );
    refused("cornell --camera side", &["camera side", "cornell has no such camera", "classic"]);
    refused("cornell --camera 7", &["camera 7", "0 \"classic\""]);
    refused("cornell --set gbufer.jitter=none", &["\"gbufer.jitter\"", "closest: \"gbuffer.jitter\""]);
    refused("cornell --set post.output=dispaly", &["post.output", "dispaly", "display"]);
    refused("cornell --backend cuda", &["cuda", "--device"]);
    refused("cornell --backend rays", &["rays", "auto, compute, ray-query, rt-pipeline, rt-reorder"]);
    refused("cornell --profile relatime", &["profile relatime", "still, realtime"]);
    refused("cornell --aov normal,albdo", &["--aov albdo", "pt passes lists them"]);
    refused("cornell --device voodoo", &["voodoo", "devices: 0"]);
    refused("cornell --env sky.hdr", &["sky.hdr", "no such file"]);
}

#[test]
fn impossible_sizes_and_outputs_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::create_dir(at.join("taken.exr")).unwrap();
    fs::write(at.join("file"), "").unwrap();
    for size in ["0x0", "0x8", "100000x100000"] {
        refused(
            at,
            &format!("render cornell --size {size} -o a.exr"),
            &[size, "each side must be 1 to 16384"],
        );
    }
    let refused = |output: &str, parts: &[&str]| {
        // A good output first: it must not be written either.
        refused(at, &format!("render cornell --size 8x8 -o good.png {output}"), parts);
    };
    refused("-o none/a.png", &["none/a.png", "does not exist, create it first"]);
    refused("-o taken.exr", &["taken.exr", "is a directory"]);
    refused("-o file/a.exr", &["file/a.exr", "not a folder"]);
    refused("-o a.bmp", &["a.bmp", "\"bmp\"", "png, jpg, exr"]);
    refused("-o a", &["png, jpg, exr"]);
    refused("--timings none/t.json", &["none/t.json", "does not exist"]);
    // No one can make files there, whatever the permissions say.
    if Path::new("/proc/self").exists() {
        refused("-o /proc/a.png", &["/proc/a.png", "not writable"]);
    }
}

#[test]
fn files_that_are_no_scenes_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let whole =
        br#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"name":"a node that is cut"}]}"#;
    fs::write(at.join("cut.gltf"), &whole[..70]).unwrap();
    fs::write(at.join("cut.glb"), b"glTF\x02\0\0\0\xff\0\0\0\x20\0\0\0JSON{").unwrap();
    fs::write(at.join("header.glb"), b"glTF\x02\0").unwrap();
    fs::write(at.join("empty.gltf"), "").unwrap();
    fs::write(at.join("empty.glb"), "").unwrap();
    fs::write(at.join("text.gltf"), "hello").unwrap();
    fs::write(at.join("cube.obj"), "v 0 0 0\n").unwrap();
    fs::write(at.join("list.gltf"), "[]").unwrap();
    fs::create_dir(at.join("scene.gltf")).unwrap();
    for (file, part) in [
        ("cut.gltf", "nodes[0].name: EOF while parsing"),
        ("cut.glb", "cut.glb"),
        ("header.glb", "cut short"),
        ("empty.gltf", "is empty"),
        ("empty.glb", "is empty"),
        ("text.gltf", "not a glTF 2.0 file"),
        ("cube.obj", "not a glTF 2.0 file"),
        ("list.gltf", "not a glTF 2.0 file"),
        ("scene.gltf", "is a folder"),
        ("none.gltf", "no such file"),
    ] {
        refused(at, &format!("render {file} --size 8x8 -o a.png"), &[file, part]);
        refused(at, &format!("bench trace {file} --size 8x8 --json rows.json"), &[file, part]);
    }
}

/// Broken files of others: each is refused, or rendered when only a stricter reader would mind. None may crash.
#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn broken_files_are_refused_or_rendered() {
    let broken = pt_test_data::shared("scenes_invalid");
    let mut scenes = Vec::new();
    let mut folders = vec![broken];
    while let Some(folder) = folders.pop() {
        for path in files(&folder) {
            match path.extension().and_then(|e| e.to_str()) {
                _ if path.is_dir() => folders.push(path),
                Some("gltf" | "glb") => scenes.push(path),
                _ => {}
            }
        }
    }
    scenes.sort();
    let folder = tempfile::tempdir().unwrap();
    let (mut rendered, mut refusals) = (0, 0);
    // All of them are the importer's test; the program is asked about some.
    for scene in scenes.iter().step_by(9) {
        let mut program = pt(folder.path(), "render --size 8x8 --backend compute -o a.png");
        program.arg(scene);
        if program.output().unwrap().status.success() {
            assert!(folder.path().join("a.png").is_file());
            fs::remove_file(folder.path().join("a.png")).unwrap();
            rendered += 1;
        } else {
            refused_by(program, &[&scene.display().to_string()]);
            refusals += 1;
        }
    }
    println!("{refusals} refused, {rendered} rendered");
    assert!(refusals > 0 && rendered > 0);
}

#[test]
fn without_vulkan_there_is_one_line() {
    let folder = tempfile::tempdir().unwrap();
    for line in ["render cornell --size 8x8 -o a.png", "info", "info --json", "passes", "bench trace cornell"]
    {
        let mut program = pt(folder.path(), line);
        program.env("VK_DRIVER_FILES", "/nonexistent").env("VK_ICD_FILENAMES", "/nonexistent");
        refused_by(program, &["Vulkan", "scripts/setup-vulkan.sh"]);
    }
    let mut scenes = pt(folder.path(), "scenes");
    scenes.env("VK_DRIVER_FILES", "/nonexistent").env("VK_ICD_FILENAMES", "/nonexistent");
    assert!(scenes.output().unwrap().status.success(), "what needs no device works");
}

#[test]
fn images_of_different_sizes_are_not_compared() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), "render cornell --size 8x8 --backend compute -o a.exr");
    succeeds(folder.path(), "render cornell --size 9x8 --backend compute -o b.exr");
    refused(folder.path(), "compare a.exr b.exr", &["differ in size", "8x8", "9x8"]);
}

/// The passes that `pt passes --json` prints.
fn listed_passes(text: &str) -> Vec<Value> {
    let listed: Value = serde_json::from_str(text).unwrap();
    listed["passes"].as_array().unwrap().clone()
}

#[test]
fn scenes_and_passes_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    let scenes = succeeds(folder.path(), "scenes");
    for name in ["cornell", "gallery", "lamps"] {
        assert!(scenes.lines().any(|line| line.split_whitespace().next() == Some(name)), "{scenes}");
    }
    let table = succeeds(folder.path(), "passes --accumulate --size 64x36 --json");
    let table = listed_passes(&table);
    let names: Vec<&str> = table.iter().map(|pass| pass["name"].as_str().unwrap()).collect();
    // The contract's order; stages yet to come stand between these.
    let order = [
        "primary rays",
        "choose lights",
        "shadow rays",
        "direct lighting",
        "choose bounces",
        "bounce rays",
        "bounce lights",
        "bounce shadow rays",
        "bounce rays 2",
        "bounce lights 2",
        "indirect lighting",
        "composite",
        "interleave",
        "accumulate",
        "histogram",
        "meter",
        "tone map",
    ];
    let at = order.map(|name| {
        let mut found = names.iter().enumerate().filter(|(_, n)| **n == name).map(|(i, _)| i);
        found.next().unwrap_or_else(|| panic!("no {name} in {names:?}"))
    });
    assert!(at.is_sorted(), "{names:?}");
    for pass in &table {
        assert!(
            !pass["writes"].as_array().unwrap().is_empty() && pass["bytes"].as_u64().unwrap() > 0,
            "{pass}"
        );
    }
    let has = |pass: usize, list: &str, name: &str| {
        table[at[pass]][list].as_array().unwrap().iter().any(|n| n == name)
    };
    assert!(has(1, "reads", "shading_position") && has(1, "writes", "shadow ray lights"), "{table:?}");
    assert!(has(2, "reads", "shadow ray ends") && has(2, "writes", "shadow ray states"), "{table:?}");
    assert!(has(3, "reads", "shadow ray lights") && has(3, "writes", "color_hf"), "{table:?}");
    assert!(has(4, "writes", "bounce ray origins") && has(5, "reads", "bounce ray origins"), "{table:?}");
    let hits = "hits of bounce rays, origins of bounce shadow rays";
    assert!(has(5, "writes", hits) && has(6, "reads", hits) && has(7, "reads", hits), "{table:?}");
    assert!(has(7, "reads", "bounce shadow ray lights") && has(7, "writes", "light of paths"), "{table:?}");
    assert!(has(10, "reads", "light of paths") && has(10, "writes", "color_lf_sh"), "{table:?}");
    // Five rays a pixel: 16 bytes for the end of each and 16 for its light are written and read.
    let bytes = |pass: usize| table[at[pass]]["bytes"].as_u64().unwrap();
    assert!((1..4).all(|pass| bytes(pass) >= 64 * 36 * 5 * 16), "{table:?}");
    // Place in the list, origin, direction and hit of each path; its light, what reflects it and the direction.
    assert!((4..11).all(|pass| bytes(pass) >= 64 * 36 * 44), "{table:?}");
    let half = succeeds(folder.path(), "passes --size 64x36 --set indirect.bounces=0.5 --json");
    let half = listed_passes(&half);
    let rays = |table: &[Value]| {
        let pass = table.iter().find(|pass| pass["name"] == "bounce rays").expect("bounce rays");
        pass["bytes"].as_u64().unwrap()
    };
    // Place in the list, origin, direction and hit of each second path.
    assert_eq!(
        rays(&table) - rays(&half),
        64 * 36 / 2 * (4 + 3 * 16),
        "half a bounce pays for its rows alone"
    );
    let text = succeeds(folder.path(), "passes --size 64x36");
    assert!(!text.contains("accumulate"), "a stage that is off is absent: {text}");
    assert!(text.find("primary rays").unwrap() < text.find("tone map").unwrap());
}

#[test]
fn the_memory_of_a_frame_is_what_the_allocator_gave() {
    let folder = tempfile::tempdir().unwrap();
    let memory = |knobs: &str| -> Value {
        let text = succeeds(folder.path(), &format!("passes --size 256x144 --json {knobs}"));
        serde_json::from_str::<Value>(&text).unwrap()["memory"].clone()
    };
    let (shared, all) = (memory(""), memory("--keep-all"));
    let bytes = |part: &Value| part["bytes"].as_u64().unwrap();
    let allocation = |memory: &Value, name: &str| -> u64 {
        let stages = memory["stages"].as_array().unwrap().iter();
        let all = stages.flat_map(|stage| stage["allocations"].as_array().unwrap());
        all.filter(|one| one[0] == name).map(|one| one[1].as_u64().unwrap()).sum()
    };
    for memory in [&shared, &all] {
        let stages = memory["stages"].as_array().unwrap();
        assert_eq!(stages.iter().map(bytes).sum::<u64>(), bytes(memory));
        for stage in stages {
            let parts = stage["allocations"].as_array().unwrap().iter();
            assert_eq!(parts.map(|one| one[1].as_u64().unwrap()).sum::<u64>(), bytes(stage), "{stage}");
        }
        let a_pixel = memory["bytes_a_pixel"].as_f64().unwrap();
        assert!((a_pixel * 256.0 * 144.0 / bytes(memory) as f64 - 1.0).abs() < 1e-9);
        // Twice 8 bytes, and what the driver adds for alignment.
        let base_color = allocation(memory, "base_color");
        assert!((16 * 256 * 144..17 * 256 * 144).contains(&base_color), "{base_color}");
    }
    // The image of the composite has memory of its own only where all do.
    assert!(allocation(&all, "color") > 0 && allocation(&shared, "color") == 0);
    // 6 GB for 3840 x 2160 pixels.
    let most = 6e9 / (3840.0 * 2160.0);
    assert!(shared["bytes_a_pixel"].as_f64().unwrap() < most, "{shared:#}");
    assert!(all["bytes_a_pixel"].as_f64().unwrap() > most, "{all:#}");
}

#[test]
fn planes_are_told_apart_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let knob = "--set gbuffer.decomposition=planes";
    let table = succeeds(folder.path(), &format!("passes --scene glass --size 32x24 {knob}"));
    let at = |name: &str| {
        table
            .lines()
            .position(|line| line.contains(&format!(" {name}  [")))
            .unwrap_or_else(|| panic!("no {name} in {table}"))
    };
    let order = ["primary rays", "interleave", "primary rays, plane 1", "add plane, plane 1", "histogram"];
    assert!(order.map(at).is_sorted(), "{table}");
    assert!(
        table.contains("memory of the frame: ") && table.contains("frame_uniforms of plane 1"),
        "{table}"
    );
    // All glass of the scene is clear.
    assert!(!table.contains("plane 2"), "{table}");

    // Without glass the frame is that of the replacement.
    let passes = |knob: &str| succeeds(folder.path(), &format!("passes --scene cornell --size 32x24 {knob}"));
    assert_eq!(passes(knob), passes(""));

    let parts = ["2 planes", "gbuffer.decomposition=replacement"];
    refused(
        folder.path(),
        &format!("capture glass --size 32x24 --frames 0..1 -o capture {knob}"),
        &[&parts[..], &["pt capture"]].concat(),
    );
    let render = format!("render glass --size 32x24 --backend compute -o a.exr {knob}");
    refused(folder.path(), &format!("{render} --aov motion"), &[&parts[..], &["--aov"]].concat());
    refused(folder.path(), &format!("{render} --oracle lights"), &["several planes", parts[1]]);
}

#[test]
fn info_says_what_auto_takes_and_why() {
    let folder = tempfile::tempdir().unwrap();
    let info: Value = serde_json::from_str(&succeeds(folder.path(), "info --json")).unwrap();
    let devices = info["devices"].as_array().unwrap();
    let usable: Vec<_> = devices.iter().filter(|d| d["device"]["unusable"].is_null()).collect();
    assert!(!usable.is_empty(), "{info}");
    for entry in usable {
        for field in ["name", "kind", "driver", "driver_version", "vulkan"] {
            assert!(entry["device"][field].as_str().is_some_and(|text| !text.is_empty()), "{field}: {entry}");
        }
        let rates = entry["auto"]["mrays_per_s"].as_array().unwrap();
        let rate = |row: &Value| row[1].as_f64().unwrap();
        let there = rates.len() + entry["auto"]["missing"].as_array().unwrap().len();
        if there == 3 && !rates.is_empty() {
            let taken = rates.iter().find(|row| row[0] == entry["auto"]["backend"]).unwrap();
            let best = rates.iter().map(rate).fold(0.0, f64::max);
            assert!(best <= CLEARLY_FASTER * rate(taken), "no other is clearly faster: {entry}");
        }
    }
}

#[test]
fn a_render_holds_what_was_asked_for_and_repeats_itself() {
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let line = "render cornell --size 64x48 --frames 3 -o x.exr -o x.png --timings t.json --aov all";
    let summary = folders.each_ref().map(|folder| succeeds(folder.path(), line));
    let last = summary[0].lines().last().unwrap();
    assert!(last.contains("ms/frame") && last.contains("Mrays/s"), "{last}");
    let bytes = |name: &str| folders.each_ref().map(|folder| fs::read(folder.path().join(name)).unwrap());
    for name in ["x.exr", "x.png"] {
        let [first, second] = bytes(name);
        assert!(first == second, "{name} differs between two runs");
    }

    let at = folders[0].path();
    let image = LayeredImage::read_exr(&at.join("x.exr")).unwrap();
    assert_eq!((image.width, image.height), (64, 48));
    for (layer, channel) in [
        ("", "R"),
        ("normal", "X"),
        ("vertex_normal", "Z"),
        ("view_depth", "Z"),
        ("shading_position", "material"),
        ("view_direction", "flags"),
        ("motion", "W"),
        ("base_color", "A"),
        ("throughput", "R"),
        ("color_hf", "G"),
        ("color_spec", "B"),
        ("color_lf_sh", "W"),
        ("color_lf_cocg", "X"),
        ("flat_color", "R"),
    ] {
        assert!(
            image.channel(layer, channel).is_some_and(|samples| samples.len() == 64 * 48),
            "{layer}.{channel}"
        );
    }
    // What the eye sees and what the interleave made are one thing.
    assert_eq!(image.channel("", "G"), image.channel("flat_color", "G"));
    // What `auto` took depends on measured times and is not in the file.
    assert_eq!(image.metadata["backend"], "auto");
    let Some(Samples::U32(flags)) = image.channel("view_direction", "flags") else {
        panic!("flags are integers")
    };
    assert!(flags.iter().all(|flag| *flag == 1));
    for key in ["scene", "camera", "seed", "params", "device", "driver", "backend", "version"] {
        assert!(image.metadata.contains_key(key), "{key}");
    }
    let png = LinearImage::read(&at.join("x.png")).unwrap();
    assert_eq!((png.width, png.height), (64, 48));
    let mean = png.pixels.iter().map(|p| p[1]).sum::<f32>() / (64.0 * 48.0);
    assert!((0.02..0.9).contains(&mean), "neither black nor white: {mean}");
    steady(&at.join("t.json"), 3);

    succeeds(at, "render cornell --size 64x48 --frames 3 --seed 1 -o other.exr");
    let other = LayeredImage::read_exr(&at.join("other.exr")).unwrap();
    assert_ne!(other.channel("", "R"), image.channel("", "R"), "another seed, another noise");
    assert_eq!(other.layers.len(), 1);
}

#[test]
fn a_sequence_has_every_frame_as_if_rendered_by_itself() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let line = "render flicker --size 48x32 --aov motion --set post.taa.enabled=true";
    succeeds(at, &format!("{line} --frames 3 -o f_##.exr -o last.png"));
    let names = ["f_00.exr", "f_01.exr", "f_02.exr", "last.png"];
    assert_eq!(files(at), names.map(|name| at.join(name)).into());
    succeeds(at, &format!("{line} --frames 2 -o two.exr"));
    let bytes = |name: &str| fs::read(at.join(name)).unwrap();
    assert!(bytes("f_01.exr") == bytes("two.exr"));
    assert!(bytes("f_00.exr") != bytes("f_01.exr"));

    refused(at, &format!("{line} --frames 3 -o nowhere/f_#.png"), &["nowhere", "does not exist"]);
}

/// From the third frame on nothing is created.
fn steady(timings: &Path, frames: usize) {
    let timings = json(timings);
    let created: Vec<_> = timings["frames"]
        .as_array()
        .unwrap()
        .iter()
        .map(|frame| ["pipelines", "allocations"].map(|what| frame["created"][what].as_u64().unwrap()))
        .collect();
    assert_eq!(created.len(), frames);
    assert!(
        created[2..].iter().all(|counts| *counts == [0, 0]),
        "pipelines, allocations per frame: {created:?}"
    );
    assert!(created.iter().any(|counts| *counts != [0, 0]), "the counters count: {created:?}");
    let passes = timings["passes"].as_array().unwrap();
    assert!(passes.iter().any(|p| p["pass"] == "direct lighting" && p["median_ms"].as_f64().unwrap() > 0.0));
    for field in ["device", "driver", "backend", "scene"] {
        assert!(timings[field].is_string(), "{field}");
    }
}

#[test]
fn a_moving_camera_creates_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let render = "render gallery --camera tour --size 64x36";
    succeeds(at, &format!("{render} --frames 8 --aov motion -o x.exr --timings t.json"));
    steady(&at.join("t.json"), 8);
    let image = LayeredImage::read_exr(&at.join("x.exr")).unwrap();
    let moved = image.channel("motion", "X").unwrap().to_f32().iter().filter(|x| x.abs() > 1e-6).count();
    assert!(moved > 64 * 36 / 2, "the camera moves: {moved} pixels do");
}

#[test]
fn a_killed_render_leaves_no_image() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("old.exr"), "what was there").unwrap();
    let mut program = pt(at, "render cornell --size 32x32 --frames 1000000 --accumulate");
    let mut running = program
        .args("-o new.png -o old.exr --timings t.json".split(' '))
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The first line of progress says that frames are being rendered.
    let mut line = String::new();
    BufReader::new(running.stderr.take().unwrap()).read_line(&mut line).unwrap();
    assert!(line.starts_with("frame "), "{line}");
    running.kill().unwrap();
    assert!(!running.wait().unwrap().success());
    assert_eq!(fs::read_to_string(at.join("old.exr")).unwrap(), "what was there");
    assert_eq!(files(at), [at.join("old.exr")].into());
}
