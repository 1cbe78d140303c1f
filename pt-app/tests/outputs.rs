//! What the image files of `pt render` and `pt reference` hold: alpha, JPEG, their size, and where they come from.

use pt_image::image_file::{Layer, LayeredImage, LinearImage, srgb_encode};
use std::fs;
use std::path::Path;
use std::process::Command;

fn run(folder: &Path, line: &str) -> (Option<i32>, String, String) {
    let mut program = Command::new(env!("CARGO_BIN_EXE_pt"));
    let done = program.current_dir(folder).args(line.split_whitespace()).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (done.status.code(), text(done.stdout), text(done.stderr))
}

fn succeeds(folder: &Path, line: &str) -> (String, String) {
    let (code, out, said) = run(folder, line);
    assert_eq!(code, Some(0), "pt {line}: {said}");
    (out, said)
}

/// A sky of one radiance.
const SKY: f32 = 3.0;

fn write_sky(path: &Path, radiance: f32) {
    let mut sky = LayeredImage::new(4, 2).unwrap();
    sky.layers.push(Layer::from_interleaved("", &["R", "G", "B"], 3, &[radiance; 24]));
    sky.write_exr(path).unwrap();
}

fn planes(image: &LayeredImage) -> [Vec<f32>; 4] {
    ["R", "G", "B", "A"].map(|name| image.channel("", name).map_or(Vec::new(), |samples| samples.to_f32()))
}

#[test]
fn a_transparent_background_has_alpha() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_sky(&at.join("sky.exr"), SKY);
    // From outside, so that the box has edges against the sky.
    let line = "render cornell --look -0.2,0.3,1.4,-0.278,0.27,-0.28 --size 48x32 --backend compute --env sky.exr --accumulate --ev 2 --tonemap none \
                --set post.dither=false";
    let transparent = "--background transparent";
    succeeds(at, &format!("{line} --frames 16 -o opaque.exr"));
    succeeds(at, &format!("{line} {transparent} --frames 16 -o a.exr -o a.png"));
    succeeds(at, &format!("{line} {transparent} -o one.exr"));

    let read = |name: &str| LayeredImage::read_exr(&at.join(name)).unwrap();
    let image = read("a.exr");
    let (opaque, found) = (planes(&read("opaque.exr")), planes(&image));
    let alpha = &found[3];
    let count = |test: &dyn Fn(f32) -> bool| alpha.iter().filter(|&&a| test(a)).count();
    assert!(count(&|a| a == 0.0) > 100 && count(&|a| a == 1.0) > 100 && count(&|a| a > 0.0 && a < 1.0) > 10);
    for channel in 0..3 {
        for (i, &whole) in opaque[channel].iter().enumerate() {
            // The same random numbers: over the sky it is the opaque image, but for the rounding of two means.
            let over = found[channel][i] + (1.0 - alpha[i]) * SKY;
            assert!((over - whole).abs() <= 1e-5 * whole.max(1.0), "pixel {i}: {over} and {whole}");
        }
    }
    let single = planes(&read("one.exr"));
    for (i, &a) in single[3].iter().enumerate() {
        assert!(a == 1.0 || (a == 0.0 && (0..3).all(|channel| single[channel][i] == 0.0)), "pixel {i}: {a}");
    }

    // PNG: straight alpha. The colour of an edge is that of the surface, without a dark rim.
    let mut reader = png::Decoder::new(std::io::BufReader::new(fs::File::open(at.join("a.png")).unwrap()))
        .read_info()
        .unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!(info.color_type, png::ColorType::Rgba);
    let scale: f32 = image.metadata["exposure"].parse().unwrap();
    for (i, pixel) in bytes.chunks_exact(4).enumerate() {
        assert!((f32::from(pixel[3]) - 255.0 * alpha[i]).abs() <= 0.51, "pixel {i}");
        for channel in 0..3 {
            let straight = if alpha[i] > 0.0 { found[channel][i] / alpha[i] } else { 0.0 };
            let code = 255.0 * srgb_encode((scale * straight).min(1.0));
            assert!((f32::from(pixel[channel]) - code).abs() <= 0.6, "pixel {i}: {pixel:?}, {code}");
        }
    }
    // The display values of an EXR are premultiplied too.
    succeeds(at, &format!("{line} {transparent} --frames 16 --set post.output=display -o shown.exr"));
    let shown = planes(&read("shown.exr"));
    for (i, &a) in alpha.iter().enumerate() {
        assert!((shown[3][i] - a).abs() <= 0.5 / 255.0 + 1e-6, "pixel {i}");
        assert!((0..3).all(|channel| shown[channel][i] <= shown[3][i] + 1e-6), "pixel {i}");
    }
    // A recorded frame knows its background.
    let capture = line.replacen("render", "capture", 1);
    succeeds(at, &format!("{capture} {transparent} --frames 0..2 -o c"));
    succeeds(at, "replay c --from denoise -o replayed.exr");
    succeeds(at, &format!("{line} {transparent} --frames 2 -o two.exr"));
    assert_eq!(planes(&read("replayed.exr")), planes(&read("two.exr")));
}

#[test]
fn a_jpeg_is_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    succeeds(
        at,
        "render cornell --size 64x48 --backend compute --frames 16 --accumulate -o a.png -o a.jpg -o b.jpeg",
    );
    let [png, jpg] = ["a.png", "a.jpg"].map(|name| LinearImage::read(&at.join(name)).unwrap());
    assert_eq!((jpg.width, jpg.height), (64, 48));
    let error: f32 =
        png.pixels.iter().flatten().zip(jpg.pixels.iter().flatten()).map(|(a, b)| (a - b).abs()).sum();
    let mean = error / (3.0 * 64.0 * 48.0);
    assert!(mean < 0.02, "{mean}");
    assert!(fs::read(at.join("a.jpg")).unwrap() == fs::read(at.join("b.jpeg")).unwrap());
    let (code, _, said) = run(at, "render cornell --size 8x8 --set post.encoding=pq -o c.jpg");
    assert!(code == Some(2) && said.contains("sRGB codes only") && said.lines().count() == 1, "{said}");
}

#[test]
fn an_exr_has_the_size_that_was_asked_for_or_a_line_says_why_not() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let size = |name: &str| {
        let image = LayeredImage::read_exr(&at.join(name)).unwrap();
        [image.width, image.height]
    };
    let render = |options: &str| {
        succeeds(at, &format!("render cornell --size 48x32 --backend compute {options} -o a.exr")).1
    };
    let said = render("--upscale fsr1 --render-scale 0.5");
    assert_eq!(size("a.exr"), [24, 16]);
    for part in ["24x16", "not 48x32", "fsr1", "post.output=display", "--upscale taau"] {
        assert!(said.starts_with("warning: ") && said.contains(part), "no {part} in {said}");
    }
    for options in [
        "",
        "--upscale taau --render-scale 0.5",
        "--upscale fsr1 --render-scale 0.5 --set post.output=display",
        "--upscale fsr1",
    ] {
        assert_eq!(render(options), "", "{options}");
        assert_eq!(size("a.exr"), [48, 32], "{options}");
    }
}

#[test]
fn inputs_are_never_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_sky(&at.join("sky.exr"), SKY);
    let text =
        r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[]}],"scene":0,"images":[{"uri":"paint.png"}]}"#;
    fs::write(at.join("scene.gltf"), text).unwrap();
    fs::write(at.join("paint.png"), "pixels").unwrap();
    fs::write(at.join("knobs.toml"), "").unwrap();
    fs::write(at.join("way.json"), "{}").unwrap();
    succeeds(at, "reference cornell --size 8x8 --spp-range 0..1 --backend compute --no-aov -o r0.exr");
    succeeds(at, "reference cornell --size 8x8 --spp-range 1..2 --backend compute --no-aov -o r1.exr");
    succeeds(at, "capture cornell --size 8x8 --backend compute -o c");
    let content = || {
        let mut files: Vec<_> = fs::read_dir(at).unwrap().map(|entry| entry.unwrap().path()).collect();
        files.sort();
        files.into_iter().map(|path| (fs::read(&path).unwrap_or_default(), path)).collect::<Vec<_>>()
    };
    let before = content();
    for (line, what) in [
        ("render cornell --size 8x8 --env sky.exr -o sky.exr", "it is the environment"),
        ("render cornell --size 8x8 --env sky.exr -o ./c/../sky.exr", "it is the environment"),
        ("render scene.gltf --size 8x8 -o paint.png", "it is a file that the scene names"),
        ("render scene.gltf --size 8x8 -o a.png --timings scene.gltf", "it is the scene"),
        ("render cornell --profile knobs.toml --size 8x8 -o a.png --timings knobs.toml", "it is the profile"),
        (
            "render cornell --camera-path way.json --size 8x8 -o a.png --timings way.json",
            "it is the way of the camera",
        ),
        ("render cornell --size 8x8 -o a.png -o a.png", "it is given twice"),
        ("reference cornell --size 8x8 --env sky.exr -o sky.exr", "it is the environment"),
        ("reference cornell --size 8x8 -o a.exr --checkpoint a.exr", "it is given twice"),
        ("merge r0.exr r1.exr -o r0.exr", "it is one of the slices"),
        ("sheet paint.png r0.exr -o paint.png", "it is one of the images"),
        ("replay c --from post -o c/frame_######.exr", "it is a file of the capture"),
        ("bench trace scene.gltf --json scene.gltf", "it is the scene"),
    ] {
        let (code, _, said) = run(at, line);
        assert_eq!(code, Some(2), "{line}: {said}");
        assert!(said.contains(what) && said.lines().count() == 1, "{line}: {said}");
    }
    assert!(content() == before);
}

#[test]
fn images_say_which_light_they_carry_and_are_compared_by_it() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_sky(&at.join("sky.exr"), SKY);
    let size = "--size 16x12 --backend compute";
    let (said, _) = succeeds(at, &format!("render cornell {size} -o default.exr"));
    assert!(said.lines().any(|line| line.starts_with("light: direct light and 1 bounce (")), "{said}");
    let (said, _) = succeeds(at, &format!("render cornell {size} --set indirect.bounces=0 -o frame.exr"));
    assert!(said.lines().any(|line| line.starts_with("light: direct light only")), "{said}");
    let (said, _) = succeeds(at, &format!("reference cornell {size} --spp 2 --no-aov -o all.exr"));
    assert!(said.lines().any(|line| line == "light: direct light and all bounces"), "{said}");
    let reference = |options: &str, name: &str| {
        succeeds(at, &format!("reference cornell {size} --spp 2 --no-aov {options} -o {name}"));
    };
    reference("--max-bounces 0", "direct.exr");
    reference("--max-bounces 0 --env sky.exr", "sky_lit.exr");
    reference("--max-bounces 0 --look 0,1,3,0,1,0", "moved.exr");
    let warnings = |b: &str| -> Vec<String> {
        let (_, said) = succeeds(at, &format!("compare frame.exr {b} --metric mse"));
        said.lines().map(str::to_owned).collect()
    };
    assert_eq!(
        warnings("all.exr"),
        [
            "warning: frame.exr and all.exr carry different light: direct light only, and direct light and all bounces"
        ]
    );
    assert!(warnings("direct.exr").is_empty(), "{:?}", warnings("direct.exr"));
    let lit = warnings("sky_lit.exr");
    assert!(lit.len() == 1 && lit[0].contains("different environments"), "{lit:?}");
    let moved = warnings("moved.exr");
    assert!(moved.len() == 1 && moved[0].contains("different cameras"), "{moved:?}");
    // Slices keep what they show when they are merged.
    succeeds(at, &format!("reference cornell {size} --spp-range 2..4 --no-aov -o more.exr"));
    succeeds(at, "merge all.exr more.exr -o merged.exr --no-aov");
    assert!(warnings("merged.exr")[0].contains("different light"));
}
