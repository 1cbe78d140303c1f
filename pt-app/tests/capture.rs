//! Captures and replays: the rest of the frame gives the frame's own bits, and bad captures are refused by name.

use clap::Parser;
use pt_app::cli::Cli;
use pt_core::capture::folder::{CaptureFolder, INDEX};
use pt_image::image_file::{LayeredImage, decode_exr_parts, encode_exr_parts};
use std::path::Path;
use std::process::Command;

/// Runs a command line; the message of its error.
fn pt(line: &str) -> Result<(), String> {
    let words = std::iter::once("pt").chain(line.split_whitespace());
    let cli = Cli::try_parse_from(words).unwrap_or_else(|e| panic!("{line}: {e}"));
    cli.run(&mut Vec::new()).map(drop).map_err(|error| format!("{error:#}"))
}

fn run(line: &str) {
    pt(line).unwrap_or_else(|error| panic!("pt {line}: {error}"));
}

/// Compares frames that were rendered with replayed ones, layer by layer and bit by bit.
fn assert_same(folder: &Path, live: &str, replayed: &str, frames: std::ops::Range<u32>) {
    for frame in frames {
        let read = |name: &str| LayeredImage::read_exr(&folder.join(format!("{name}_{frame}.exr"))).unwrap();
        let (live, replayed) = (read(live), read(replayed));
        assert!(live.layers.len() > 1, "layers besides the picture are compared too");
        for layer in &live.layers {
            assert!(
                replayed.layer(&layer.name) == Some(layer),
                "frame {frame}: layer {:?} differs",
                layer.name
            );
        }
    }
}

const VIEW: &str = "gallery --camera tour --size 48x27 --fps 4";
/// What TAA leaves in its own images, beside the picture.
const TAA: &str = "--aov flat_color,post.resolved,post.taa_history";

#[test]
fn replays_are_the_frames_bit_by_bit() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path().display();
    let options = "--profile q2rtx --backend compute";
    run(&format!("render {VIEW} {options} --frames 8 -o {dir}/live_#.exr {TAA}"));
    run(&format!("capture {VIEW} {options} --frames 0..8 -o {dir}/all"));
    run(&format!("capture {VIEW} {options} --frames 4..8 -o {dir}/late"));
    for (capture, frames) in [("all", 0..8), ("late", 4..8)] {
        run(&format!("replay {dir}/{capture} --from checkerboard -o {dir}/{capture}_c_#.exr {TAA}"));
        assert_same(folder.path(), "live", &format!("{capture}_c"), frames.clone());
        run(&format!(
            "replay {dir}/{capture} --from post -o {dir}/{capture}_p_#.exr --aov post.resolved,post.taa_history"
        ));
        // The replay reads flat_color and so does not write it.
        for frame in frames {
            let read = |name: &str| LayeredImage::read_exr(&folder.path().join(name)).unwrap();
            let (live, replayed) =
                (read(&format!("live_{frame}.exr")), read(&format!("{capture}_p_{frame}.exr")));
            for name in ["", "post.resolved", "post.taa_history"] {
                assert!(
                    live.layer(name).is_some() && live.layer(name) == replayed.layer(name),
                    "{frame} {name:?}"
                );
            }
        }
    }
    // The picture too: the eye's adaptation and the noise-aware curve go on where the recorded run was.
    run(&format!("render {VIEW} {options} --frames 8 -o {dir}/live.png"));
    run(&format!("replay {dir}/late --from denoise -o {dir}/late.png"));
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert!(bytes("live.png") == bytes("late.png"));
}

#[test]
fn every_backend_s_captures_replay() {
    let device = pt_core::test_support::TestDevice::open();
    for backend in pt_core::trace::TraceBackend::available(&device) {
        let folder = tempfile::tempdir().unwrap();
        let dir = folder.path().display();
        let options = format!("cornell --size 33x18 --profile realtime --backend {backend}");
        run(&format!("render {options} --frames 3 -o {dir}/live_#.exr {TAA}"));
        run(&format!("capture {options} --frames 0..3 -o {dir}/c"));
        run(&format!("replay {dir}/c --from checkerboard -o {dir}/again_#.exr {TAA}"));
        assert_same(folder.path(), "live", "again", 0..3);
    }
}

#[test]
fn means_of_frames_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path().display();
    let options = "cornell --size 32x18 --accumulate --backend compute";
    let aov = "--aov accumulated,post.accumulate_residual";
    run(&format!("render {options} --frames 6 -o {dir}/live_#.exr {aov}"));
    run(&format!("capture {options} --frames 3..6 -o {dir}/c"));
    run(&format!("replay {dir}/c --from post -o {dir}/again_#.exr {aov}"));
    assert_same(folder.path(), "live", "again", 3..6);
}

#[test]
fn knobs_change_a_replay_and_references_are_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path().display();
    run(&format!("capture cornell --size 24x16 --backend compute --reference-spp 2 -o {dir}/c"));
    run(&format!("replay {dir}/c --from denoise -o {dir}/a.exr"));
    run(&format!("replay {dir}/c --from denoise --set denoise.scale_hf=0 -o {dir}/b.exr"));
    let output = Command::new(env!("CARGO_BIN_EXE_pt"))
        .args(["replay", &format!("{dir}/c"), "--from", "post", "--set", "indirect.bounces=4"])
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.status.success() && said.contains("indirect.bounces=4: this stage does not run"),
        "{said}"
    );
    let mean = |name: &str| {
        let image = LayeredImage::read_exr(&folder.path().join(name)).unwrap();
        image.channel("", "R").unwrap().to_f32().iter().sum::<f32>()
    };
    assert!(mean("b.exr") < 0.5 * mean("a.exr"));
    assert!(mean("c/reference_000000.exr") > 0.0);
    let error = pt(&format!("replay {dir}/c --from post --frames 0..2")).unwrap_err();
    assert!(error.contains("has the frames 0..1, not 0..2"), "{error}");
    let error = pt(&format!("capture cornell --size 24x16 -o {dir}/c")).unwrap_err();
    assert!(error.contains("holds a capture already"), "{error}");
}

/// Replaces a file of a capture, and its hash in the index.
fn replace(capture: &Path, name: &str, bytes: &[u8]) {
    let index = std::fs::read_to_string(capture.join(INDEX)).unwrap();
    let hash = |bytes: &[u8]| blake3::hash(bytes).to_hex().to_string();
    let old = hash(&std::fs::read(capture.join(name)).unwrap());
    assert!(index.contains(&old));
    std::fs::write(capture.join(INDEX), index.replace(&old, &hash(bytes))).unwrap();
    std::fs::write(capture.join(name), bytes).unwrap();
}

#[test]
fn bad_captures_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path().display();
    run(&format!("capture cornell --size 16x16 --frames 0..3 --backend compute -o {dir}/good"));
    assert_eq!(CaptureFolder::open(&folder.path().join("good")).unwrap().range(), 0..3);
    let refused = |name: &str, spoil: &dyn Fn(&Path)| {
        let capture = folder.path().join(name);
        std::fs::create_dir(&capture).unwrap();
        for entry in std::fs::read_dir(folder.path().join("good")).unwrap() {
            let entry = entry.unwrap();
            std::fs::copy(entry.path(), capture.join(entry.file_name())).unwrap();
        }
        spoil(&capture);
        let error = pt(&format!("replay {} --from post", capture.display())).unwrap_err();
        assert!(!error.contains('\n'), "one line: {error}");
        error
    };
    let edit = |capture: &Path, from: &str, to: &str| {
        let index = std::fs::read_to_string(capture.join(INDEX)).unwrap();
        assert!(index.contains(from), "{index}");
        std::fs::write(capture.join(INDEX), index.replacen(from, to, 1)).unwrap();
    };
    let version = format!("\"version\": \"{}\"", env!("CARGO_PKG_VERSION"));
    let error = refused("version", &|c| edit(c, &version, "\"version\": \"0.0.9\""));
    assert!(error.contains(INDEX) && error.contains("version 0.0.9"), "{error}");

    let error = refused("layer", &|c| {
        let name = "frame_000001.exr";
        let mut parts = decode_exr_parts(&std::fs::read(c.join(name)).unwrap()).unwrap();
        parts.iter_mut().for_each(|(_, image)| image.layers.retain(|layer| layer.name != "flat_color"));
        replace(c, name, &encode_exr_parts(&parts).unwrap());
    });
    assert!(error.contains("frame_000001.exr") && error.contains("no layer \"flat_color\""), "{error}");

    let error = refused("truncated", &|c| {
        let bytes = std::fs::read(c.join("frame_000002.exr")).unwrap();
        replace(c, "frame_000002.exr", &bytes[..bytes.len() / 2]);
    });
    assert!(error.contains("frame_000002.exr"), "{error}");

    let error = refused("hash", &|c| std::fs::write(c.join("frame_000001.json"), "{}").unwrap());
    assert!(error.contains("frame_000001.json") && error.contains("its hash is"), "{error}");

    let error = refused("hole", &|c| {
        let text = std::fs::read_to_string(c.join(INDEX)).unwrap();
        let mut index: serde_json::Value = serde_json::from_str(&text).unwrap();
        index["frames"].as_array_mut().unwrap().remove(1);
        std::fs::write(c.join(INDEX), index.to_string()).unwrap();
    });
    assert!(error.contains(INDEX) && error.contains("a hole: frame 2 follows frame 0"), "{error}");

    let error = refused("size", &|c| edit(c, "16,\n    16", "20,\n    16"));
    assert!(error.contains("16x16") && error.contains("20x16"), "{error}");

    let error = refused("gone", &|c| std::fs::remove_file(c.join("frame_000000.exr")).unwrap());
    assert!(error.contains("frame_000000.exr"), "{error}");
    let error = pt(&format!("replay {dir}/nowhere --from post")).unwrap_err();
    assert!(error.contains("nowhere"), "{error}");
}

/// The example reads what the program wrote.
#[test]
#[cfg_attr(not(python_openexr), ignore = "needs the Python modules of scripts/setup-python.sh")]
fn the_python_example_reads_a_capture() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path().display();
    run(&format!(
        "capture cornell --size 18x10 --frames 1..3 --profile q2rtx --backend compute --reference-spp 2 -o {dir}/c"
    ));
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    let output = Command::new("python3")
        .env("PYTHONPATH", format!("{root}/target/python"))
        .arg(format!("{root}/examples/read_capture.py"))
        .arg(folder.path().join("c"))
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    assert!(text.contains("frame 2: [18, 10] pixels") && text.contains("flat_color.R"), "{text}");
    assert!(
        text.contains("history.post.taa_history.R") && text.contains("MSE against the reference"),
        "{text}"
    );
}

/// Three frames of a wall of albedo 0.5 under noise, in the layout of the BMFR data set; the camera moves by 1.5 pixels a frame. `shift_of_frame`: how far its matrix is
/// off.
fn write_bmfr(folder: &Path, transposed: bool, shift_of_frame: impl Fn(u32) -> f32) {
    use pt_image::image_file::Layer;
    let (size, distance) = ([24u32, 16u32], 4.0f32);
    std::fs::create_dir_all(folder.join("inputs")).unwrap();
    let (mut matrices, mut offsets) = (String::new(), String::new());
    for frame in 0..3u32 {
        let x = 0.5 * frame as f32;
        let shown = x + shift_of_frame(frame);
        // Clip = (x - eye, 1.5 y, z, -z) for half a picture of 1 x 2/3 at distance 1.
        let rows =
            [[1.0, 0.0, 0.0, -shown], [0.0, 1.5, 0.0, 0.0], [0.0, 0.0, -1.0, -0.2], [0.0, 0.0, -1.0, 0.0]];
        let of = |r: usize, c: usize| if transposed { rows[c][r] } else { rows[r][c] };
        let row = |r: usize| (0..4).map(|c| format!("{:.4}f", of(r, c))).collect::<Vec<_>>().join(", ");
        let all: Vec<_> = (0..4).map(|r| format!("{{{}}}", row(r))).collect();
        matrices += &format!("{{{}}}, // frame {frame}\n", all.join(", "));
        offsets += "{0.5f, 0.5f}, ";
        let image = |name: &str, pixel: &dyn Fn(u32, u32) -> [f32; 3]| {
            let pixels: Vec<f32> = (0..size[1])
                .flat_map(|y| (0..size[0]).map(move |x| [x, y]))
                .flat_map(|[x, y]| pixel(x, y))
                .collect();
            let mut out = LayeredImage::new(size[0], size[1]).unwrap();
            out.layers.push(Layer::from_interleaved("", &["R", "G", "B"], 3, &pixels));
            out.write_exr(&folder.join(format!("inputs/{name}{frame}.exr"))).unwrap();
        };
        // The last column is sky.
        let is_wall = |x: u32| x + 1 < size[0];
        let noise = |x: u32, y: u32| {
            ((x + 24 * y + 400 * frame).wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 23) as f32
        };
        image("color", &|x, y| if is_wall(x) { [noise(x, y); 3] } else { [3.0; 3] });
        image("albedo", &|x, _| if is_wall(x) { [0.5; 3] } else { [1.0; 3] });
        image("shading_normal", &|x, _| if is_wall(x) { [0.0, 0.0, 1.0] } else { [0.0; 3] });
        image("world_position", &|px, py| {
            let u = 2.0 * (px as f32 + 0.5) / size[0] as f32 - 1.0;
            let v = 1.0 - 2.0 * (py as f32 + 0.5) / size[1] as f32;
            if is_wall(px) { [x + distance * u, distance * v / 1.5, -distance] } else { [0.0; 3] }
        });
        image("reference", &|x, _| if is_wall(x) { [0.5; 3] } else { [3.0; 3] });
    }
    let text = format!(
        "// matrices\nconst float camera_matrices[3][4][4] = {{\n{matrices}}};\nconst float pixel_offsets[3][2] = {{{offsets}}};\n"
    );
    std::fs::write(folder.join("camera_matrices.h"), text).unwrap();
}

/// Frames of another renderer become a capture that can be denoised; what they lack is named.
#[test]
fn bmfr_frames_become_a_capture() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path().display();
    let flat = |image: &LayeredImage, layer: &str, name: &str| image.channel(layer, name).unwrap().to_f32();
    for transposed in [false, true] {
        let (from, to) = (format!("{dir}/bmfr{transposed}"), format!("{dir}/capture{transposed}"));
        write_bmfr(Path::new(&from), transposed, |_| 0.0);
        run(&format!("import bmfr {from} -o {to}"));
        let capture = CaptureFolder::open(Path::new(&to)).unwrap();
        assert_eq!(capture.range(), 0..3);
        assert!(capture.index.frames.iter().all(|frame| frame.reference.is_some()));
        let frame = capture.frame(1).unwrap();
        let record = frame.sidecar.record();
        assert!((record.camera.world_from_view.w_axis.x - 0.5).abs() < 1e-5, "{:?}", record.camera);
        assert!((record.camera.half_extent.y - 1.0 / 1.5).abs() < 1e-5, "{:?}", record.camera);
        let image = frame.into_image();
        let (motion, depth) = (flat(&image, "motion", "X"), flat(&image, "view_depth", "Z"));
        // The camera went to the right by 1.5 pixels of the wall: what is at a pixel now was farther right.
        assert!((motion[24 * 8 + 5] - 1.5 / 24.0).abs() < 1e-4, "{}", motion[24 * 8 + 5]);
        let corner =
            (4.0f32 * 4.0 + (4.0 * 23.0f32 / 24.0).powi(2) + (4.0 * 15.0f32 / 16.0 / 1.5).powi(2)).sqrt();
        assert!((depth[0] - corner).abs() < 1e-4 && depth[23] == 1e18, "{} {}", depth[0], depth[23]);
        assert_eq!(flat(&image, "transparent", "A")[22..24], [0.0, 1.0]);
    }
    let to = format!("{dir}/capturefalse");
    run(&format!("replay {to} --from denoise --set denoise.variant=svgf -o {dir}/out.exr"));
    let out = LayeredImage::read_exr(&folder.path().join("out.exr")).unwrap();
    let red = flat(&out, "", "R");
    let wall: Vec<f32> = (0..24 * 16).filter(|i| i % 24 < 20).map(|i| red[i]).collect();
    let mean = wall.iter().sum::<f32>() / wall.len() as f32;
    let deviation = (wall.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / wall.len() as f32).sqrt();
    // Light of mean 1 on albedo 0.5; the input deviates by 0.29.
    assert!((mean - 0.5).abs() < 0.03 && deviation < 0.08, "{mean} +- {deviation}");
    assert!((red[23] - 3.0).abs() < 0.1, "the sky is seen: {}", red[23]);

    let missing = pt(&format!("replay {to} --from denoise --set denoise.variant=asvgf -o {dir}/out.exr"));
    assert!(missing.as_ref().is_err_and(|e| e.contains("gradient_sample")), "{missing:?}");
    let moved = format!("{dir}/moved");
    write_bmfr(Path::new(&moved), false, |frame| if frame == 1 { 2.0 } else { 0.0 });
    let lost = format!("{dir}/lost");
    write_bmfr(Path::new(&lost), false, |_| 0.0);
    std::fs::remove_file(format!("{lost}/inputs/albedo1.exr")).unwrap();
    for (from, wanted) in [
        (moved.as_str(), "the matrix of frame 1 does not fit world_position"),
        (lost.as_str(), "albedo1.exr"),
        (folder.path().to_str().unwrap(), "no color0.exr"),
    ] {
        let refused = pt(&format!("import bmfr {from} -o {from}_out"));
        assert!(refused.as_ref().is_err_and(|e| e.contains(wanted) && e.lines().count() == 1), "{refused:?}");
    }
}
