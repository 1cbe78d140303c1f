//! What someone who uses the program for the first time does: wrong command lines, Ctrl-C, sizes that do not fit, files in the way.

use pt_image::image_file::LayeredImage;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

fn pt(folder: &Path, line: &str) -> Command {
    let mut program = Command::new(env!("CARGO_BIN_EXE_pt"));
    program.current_dir(folder).args(line.split_whitespace()).env_remove("RUST_BACKTRACE");
    program
}

fn run(folder: &Path, line: &str) -> (Option<i32>, String, String) {
    let Output { status, stdout, stderr } = pt(folder, line).output().unwrap();
    (status.code(), String::from_utf8(stdout).unwrap(), String::from_utf8(stderr).unwrap())
}

fn succeeds(folder: &Path, line: &str) -> (String, String) {
    let (code, out, said) = run(folder, line);
    assert_eq!(code, Some(0), "pt {line}: {said}");
    (out, said)
}

/// One line of plain words with all of `parts`, exit code 2.
fn refused(folder: &Path, line: &str, parts: &[&str]) {
    let (code, out, said) = run(folder, line);
    assert_eq!(code, Some(2), "pt {line}: {said}");
    assert!(said.starts_with("error: ") && said.lines().count() == 1, "pt {line}: {said}");
    assert!(out.is_empty(), "pt {line}: {out}");
    assert!(parts.iter().all(|part| said.contains(part)), "pt {line}: no {parts:?} in {said}");
    is_plain(line, &said);
}

/// Nothing that only a programmer of Rust understands.
fn is_plain(line: &str, said: &str) {
    let marks = [
        "Some(",
        "None",
        "Ok(",
        "Err(",
        "Vec3(",
        " { ",
        "\\\"",
        "os error",
        "invalid digit",
        "float literal",
        "target type",
        "expected struct",
        "expected f32",
        "expected u32",
        "data did not match",
        "panicked",
        "unwrap",
        "PathBuf",
        "::",
        "RUST_BACKTRACE",
        "at line 1 column",
    ];
    for mark in marks {
        assert!(!said.contains(mark), "pt {line} says {mark:?}: {said}");
    }
}

#[test]
fn wrong_command_lines_are_answered_in_plain_words() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::create_dir(at.join("folder")).unwrap();
    fs::write(at.join("a.toml"), "[post]\ntonemap = 3\n").unwrap();
    fs::write(at.join("b.toml"), "[post\n").unwrap();
    for name in ["not.exr", "cube.obj", "picture.png", "index.json"] {
        fs::write(at.join(name), "text").unwrap();
    }
    fs::write(at.join("empty.exr"), "").unwrap();
    for (line, parts) in [
        // Names of other programs and of other commands.
        ("render cornell --spp 4 -o a.png", &["--spp", "use --frames <N>"][..]),
        ("render cornell --samples=4 -o a.png", &["use --frames <N>"]),
        ("reference cornell --frames 4 -o a.exr", &["use --spp <N>"]),
        ("reference cornell --bounces 4 -o a.exr", &["use --max-bounces <B>"]),
        ("render cornell --bounces 4 -o a.png", &["use --set indirect.bounces=4"]),
        ("render cornell --denoise svgf -o a.png", &["use --set denoise.variant=svgf"]),
        ("render cornell --denoiser=asvgf -o a.png", &["use --set denoise.variant=asvgf"]),
        ("render cornell --sampler ris -o a.png", &["use --set lights.sampler=ris"]),
        ("capture cornell --taa -o c", &["use --set post.taa.enabled=true"]),
        ("render cornell --checkerboard off -o a.png", &["pt knobs checkerboard"]),
        ("render cornell --variant svgf -o a.png", &["a material variant", "--set denoise.variant=svgf"]),
        ("render cornell --vfov 30 -o a.png", &["--vfov needs --look"]),
        ("render cornell --env-clamp -o a.png", &["--env-clamp needs --env"]),
        ("render cornell --backend cpu -o a.png", &["--device llvmpipe"]),
        ("render cornell --bloom gaussian -o a.png", &["--bloom takes its value with =, --bloom=gaussian"]),
        ("render cornell --verbose -o a.png", &["unexpected argument '--verbose' found (see"]),
        ("study s.toml --set a=b", &["knobs stand in the study file: set = {"]),
        ("study s.toml --size 8x8", &["sizes stand in the study file: sizes = ["]),
        ("replay c --from post --size 8x8 -o a.png", &["frames of a capture have its size"]),
        ("reference cornell --accumulate -o a.exr", &["the mean of all samples"]),
        ("render cornell --width 64 --height 48 -o a.png", &["--width", "use --size <WxH>"]),
        ("render cornell --resolution 64x48 -o a.png", &["use --size <WxH>"]),
        ("render --scene cornell -o a.png", &["the argument <SCENE>"]),
        ("render cornell --out a.png", &["use --output"]),
        ("render cornell --gpu 0 -o a.png", &["use --device <D>"]),
        ("render cornell --hdri sky.hdr -o a.png", &["use --env <F>"]),
        ("render cornell --fov 40 -o a.png", &["use --vfov <DEG>"]),
        ("passes cornell", &["--scene <S>"]),
        ("rendr cornell -o a.png", &["render"]),
        ("cornell", &["'cornell' is no command of pt", "render, "]),
        ("scene.gltf", &["use pt render scene.gltf"]),
        ("diff a.exr b.exr", &["use pt compare"]),
        // Wrong order and forgotten names.
        ("render cornell a.png", &["-o a.png"]),
        ("render -o a.png", &["<SCENE>"]),
        ("render cornell", &["pt render needs --output", "Image to write"]),
        ("-o a.png render cornell", &["stands after it, for example pt render -o"]),
        ("render cornell -o a.png -size 8x8", &["two dashes", "--size"]),
        ("render cornell -o a.png --Size 8x8", &["use --size"]),
        // Values.
        ("render cornell --size 8 -o a.png", &["WIDTHxHEIGHT"]),
        ("render cornell --size -8x8 -o a.png", &["negative", "-8x8 for --size"]),
        (
            "render cornell --frames 0 -o a.png",
            &["'--frames <N>': expected a whole number of 1 or more (see"],
        ),
        ("sheet a.png -o s.png --columns 0", &["expected a whole number of 1 to 1024 (see"]),
        ("reference cornell --checkpoint-interval nan -o a.exr", &["expected a number of 0 or more"]),
        ("reference cornell --spp 4 --spp-range 0..8 -o a.exr", &["0..8 goes beyond", "--spp 4"]),
        ("render cornell --size 65536x65536 -o a.png", &["65536x65536", "16384"]),
        ("render cornell --frames -5 -o a.png", &["-5", "--frames"]),
        ("render cornell --frames 1.5 -o a.png", &["1.5", "whole number"]),
        ("render cornell --frames 99999999999 -o a.png", &["99999999999"]),
        ("render cornell --seed x -o a.png", &["whole number"]),
        ("render cornell --time NaN -o a.png", &["finite"]),
        ("render cornell --fps -1 -o a.png", &["above 0"]),
        ("reference cornell --spp 0 -o a.exr", &["spp"]),
        ("reference cornell --spp 1e9 -o a.exr", &["spp", "a whole number"]),
        ("reference cornell --checkpoint-interval soon -o a.exr", &["expected a number"]),
        ("reference cornell --spp-range 4..2 -o a.exr", &["empty"]),
        // Knobs and profiles.
        ("render cornell --set post.tonmap=aces -o a.png", &["post.tonemap"]),
        ("render cornell --set reference.spp=3 -o a.png", &["reference.spp is a knob of pt reference"]),
        ("reference cornell --set denoise.variant=svgf -o a.exr", &["is a knob of pt render"]),
        ("render cornell --set denoise.variant=svfg -o a.png", &["closest: \"svgf\""]),
        ("render cornell --set denoise.variant=oidn -o a.png", &["is no pass of a frame"]),
        ("render cornell --profile realtme -o a.png", &["closest: \"realtime\""]),
        ("knobs denose", &["closest: \"denoise\""]),
        ("render galery -o a.png", &["closest: \"gallery\""]),
        ("render Cornell -o a.png", &["closest: \"cornell\""]),
        ("render missing.gltf -o a.png", &["missing.gltf: no such file"]),
        ("render cornell.gltf -o a.png", &["the built-in scene is called cornell"]),
        ("render cornell --aov nrmal -o a.exr", &["closest: \"normal\""]),
        ("render cornell --size 8x8 --oracle taa -o a.png", &["--profile realtime", "post.taa.enabled"]),
        ("render cornell -o a.png -o ./a.png", &["given twice"]),
        ("replay index.json --from post -o a.png", &["index.json: is a file of a capture; give its folder"]),
        ("render cornell --set post.tonemap=3 -o a.png", &["post.tonemap", "aces, aces-hill"]),
        ("render cornell --set post.taa=true -o a.png", &["post.taa"]),
        ("render cornell --set gbuffer.reflect_refract=many -o a.png", &["gbuffer.reflect_refract", "0 to"]),
        ("render cornell --set post.ev100=NaN -o a.png", &["post.ev100"]),
        ("render cornell --profile a.toml -o a.png", &["a.toml", "post.tonemap", "aces, aces-hill"]),
        ("render cornell --profile b.toml -o a.png", &["b.toml", "line 1"]),
        ("render cornell --profile folder -o a.png", &["folder"]),
        // Files.
        ("render folder -o a.png", &["folder"]),
        ("render not.exr -o a.png", &["not.exr", "is an image, not a glTF 2.0 file", "--env"]),
        ("reference cube.obj -o a.exr", &["cube.obj", "another format", "glTF"]),
        ("scenes picture.png", &["picture.png", "is an image"]),
        ("render cornell -o folder", &["folder: is a folder; give the name of an image"]),
        ("render cornell -o picture", &["no extension", "png, jpg, exr"]),
        ("render cornell -o /proc/a.png", &["/proc/a.png"]),
        ("compare a.exr b.exr", &["a.exr", "No such file"]),
        ("compare not.exr not.exr", &["not.exr"]),
        ("replay folder --from post -o a.png", &["folder: is no capture"]),
        ("merge empty.exr -o a.exr", &["empty.exr: the file is empty"]),
        ("merge not.exr -o a.exr", &["not.exr: it is no OpenEXR file"]),
        ("scenes folder", &["folder"]),
        ("knobs psot", &["psot", "post"]),
        ("render cornell --frames 2 -o a_%03d.png", &["a_%03d.png", "###"]),
        ("render cornell --size 8x8 --aov depth -o a.exr", &["close to it: view_depth"]),
        ("capture cornell -o not.exr", &["not.exr: is a file; -o takes a folder here"]),
        ("bake cornell -o folder", &["cornell: is a built-in scene"]),
        ("reference cornell --max-bounces -1 -o a.exr", &["-1", "--max-bounces"]),
        ("render cornell --background transparent -o a.jpg", &["a.jpg has no alpha"]),
        ("render cornell --background transparent --bloom -o a.png", &["--bloom=off"]),
        ("render cornell --background transparent --profile realtime -o a.png", &["--accumulate"]),
        (
            "render cornell --set denoise.fixed_albedo=dark -o a.png",
            &["denoise.fixed_albedo", "0 to 1, or none"],
        ),
    ] {
        refused(at, line, parts);
    }
    assert!(fs::read_dir(at).unwrap().count() == 8, "nothing was written");
}

/// What is not known is not printed as a number.
#[test]
fn figures_without_a_measurement_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let size = "--size 8x8 --backend compute";
    let (out, _) = succeeds(at, &format!("reference cornell {size} --spp 1 --no-aov -o a.exr"));
    assert!(out.contains("relative error unknown after one sample"), "{out}");
    let (out, _) = succeeds(at, &format!("reference cornell {size} --spp 2 --no-aov -o a.exr"));
    assert!(out.contains("relative error 0."), "{out}");
    let (out, _) = succeeds(at, &format!("render cornell {size} -o a.png"));
    assert!(out.contains("Mrays/s"), "{out}");
    let (out, _) = succeeds(at, &format!("render cornell {size} --oracle lights --oracle-spp 2 -o a.png"));
    assert!(!out.contains("Mrays/s"), "{out}");
    let help = succeeds(at, "reference --help").0 + &succeeds(at, "knobs").0;
    assert!(help.contains("none is no limit") && !help.contains("4294967295"), "{help}");
}

#[test]
fn without_arguments_there_is_an_overview() {
    let folder = tempfile::tempdir().unwrap();
    let (code, out, said) = run(folder.path(), "");
    assert_eq!((code, out.as_str()), (Some(2), ""));
    for part in ["render", "reference", "compare", "pt render gallery -o picture.png", "pt render --help"] {
        assert!(said.contains(part), "no {part} in {said}");
    }
    assert!(said.lines().count() < 50, "short: {said}");
    let (code, _, said) = run(folder.path(), "bench");
    assert!(code == Some(2) && said.contains("trace") && said.contains("path"), "{said}");
}

#[test]
fn the_content_of_a_scene_needs_no_option() {
    let folder = tempfile::tempdir().unwrap();
    let (stats, _) = succeeds(folder.path(), "scenes cornell");
    assert_eq!(stats, succeeds(folder.path(), "scenes --stats cornell").0);
    assert!(stats.contains("triangles"), "{stats}");
    succeeds(folder.path(), "scenes cornell --clusters 8 --json");
    refused(folder.path(), "scenes cornell --stats gallery", &["--stats"]);
}

/// Sizes that are possible in principle and fit into no machine that runs tests: refused before memory is taken.
#[test]
fn what_is_too_large_is_refused_with_what_fits() {
    let folder = tempfile::tempdir().unwrap();
    for line in [
        "render cornell --size 16384x16384 --aov all -o a.exr",
        "capture cornell --size 16384x16384 -o c",
        "reference cornell --size 16384x16384 --spp 1 -o a.exr",
        "passes --size 16384x16384",
        "bench path cornell --size 16384x16384",
        "bench post --size 16384x16384",
        "bench trace cornell --size 16384x16384",
    ] {
        if pt_core::memory::host_free_bytes().is_some_and(|free| free > 64 << 30) {
            return;
        }
        refused(folder.path(), line, &["16384x16384", "free memory", "fits"]);
    }
}

/// Starts the program and waits until it says that it renders.
fn start(folder: &Path, line: &str) -> (Child, BufReader<std::process::ChildStderr>) {
    let mut child = pt(folder, line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut first = String::new();
    stderr.read_line(&mut first).unwrap();
    assert!(first.contains(" of ") && first.contains(" left"), "{line}: {first}");
    (child, stderr)
}

fn interrupt(child: &Child) {
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
}

/// After SIGINT: exit code 0, and the last line says what was written.
#[cfg(unix)]
fn interrupted(folder: &Path, line: &str, says: &str) {
    let (mut child, stderr) = start(folder, line);
    interrupt(&child);
    let lines: Vec<_> = stderr.lines().map(Result::unwrap).collect();
    assert_eq!(child.wait().unwrap().code(), Some(0), "pt {line}: {lines:?}");
    let last = lines.last().unwrap();
    assert!(last.starts_with("warning: interrupted after ") && last.contains(says), "pt {line}: {lines:?}");
}

#[test]
#[cfg(unix)]
fn an_interrupted_command_writes_what_is_there() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let size = "--size 32x24 --backend compute";
    let line =
        format!("render cornell {size} --frames 1000000 --accumulate -o a.exr -o f_###.png --timings t.json");
    interrupted(at, &line, "of 1000000 frames, which are written");
    let image = LayeredImage::read_exr(&at.join("a.exr")).unwrap();
    let frames: usize = image.metadata["frames"].parse().unwrap();
    assert!((2..1_000_000).contains(&frames), "{frames}");
    let pictures =
        fs::read_dir(at).unwrap().filter(|e| e.as_ref().unwrap().path().extension().unwrap() == "png");
    assert_eq!(pictures.count(), frames, "every frame was written");
    let timings: serde_json::Value = serde_json::from_slice(&fs::read(at.join("t.json")).unwrap()).unwrap();
    assert_eq!(timings["frames_rendered"], frames);

    interrupted(
        at,
        &format!("reference cornell {size} --spp 100000000 --no-aov -o r.exr"),
        "of 100000000 samples a pixel, which are written",
    );
    let image = LayeredImage::read_exr(&at.join("r.exr")).unwrap();
    assert!(image.metadata["samples"].parse::<u64>().unwrap() > 0);

    interrupted(at, &format!("capture cornell {size} --frames 2..100000 -o c"), "of 99998 frames");
    succeeds(at, "replay c --from post -o p.png");
    assert!(at.join("p.png").is_file());
}

#[test]
#[cfg(unix)]
fn a_second_interrupt_stops_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let (mut child, _stderr) =
        start(at, "render gallery --size 256x192 --backend compute --frames 1000000 --accumulate -o a.exr");
    // A frame of this size takes much longer than the two signals.
    interrupt(&child);
    std::thread::sleep(std::time::Duration::from_millis(20));
    interrupt(&child);
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(!at.join("a.exr").exists());
}

/// A mirror with a coat: the real-time frame, which leaves the coat out, says so; the path tracer has it, and says nothing.
#[test]
fn lobes_that_mirrors_do_not_show_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let corners: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    fs::write(at.join("t.bin"), corners.map(f32::to_le_bytes).concat()).unwrap();
    let text = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
        "buffers":[{"uri":"t.bin","byteLength":36}],"bufferViews":[{"buffer":0,"byteLength":36}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
        "materials":[{"name":"lacquer","pbrMetallicRoughness":{"roughnessFactor":0},
            "extensions":{"KHR_materials_clearcoat":{"clearcoatFactor":1}}}],
        "extensionsUsed":["KHR_materials_clearcoat"]}"#;
    fs::write(at.join("t.gltf"), text).unwrap();
    let notices = |line: &str| {
        let (out, said) = succeeds(at, &format!("{line} --backend compute"));
        is_plain(line, &said);
        let count = |text: &str| text.lines().filter(|line| line.contains("lacquer (clearcoat): ")).count();
        [count(&out), count(&said)]
    };
    assert_eq!(notices("render t.gltf --size 8x8 -o a.png"), [0, 1]);
    assert_eq!(notices("capture t.gltf --size 8x8 -o c"), [0, 1]);
    assert_eq!(notices("render t.gltf --size 8x8 --set gbuffer.reflect_refract=0 -o a.png"), [0, 0]);
    assert_eq!(notices("reference t.gltf --size 8x8 --spp 1 --no-aov -o a.exr"), [0, 0]);
    let (out, _) = succeeds(at, "scenes t.gltf");
    assert_eq!(out.matches("lacquer (clearcoat): ").count(), 1, "{out}");
}
