//! Frames with a compact G-buffer or with histories in half floats: close to the full ones, recorded and replayed without loss.

use clap::Parser;
use pt_app::cli::{Cli, Command};
use pt_app::params::FrameParams;
use pt_core::trace::TraceBackend;
use pt_denoise::{Denoiser, HistoryFormat};
use pt_image::image_file::{LayeredImage, LinearImage, Samples};
use pt_shaders::channels::{FLAT_COLOR, GbufferFormat};
use pt_tests::{Frames, builtin};

const SIZE: [u32; 2] = [64, 36];
/// Compact channels, and what the denoiser makes with their help.
const NAMES: [&str; 5] = ["base_color", "metallic_roughness", "motion", "color", "flat_color"];

fn picture(params: FrameParams) -> LinearImage {
    let scene = builtin("gallery");
    let camera = scene.default_camera();
    let mut frames = Frames::with_params(scene, &camera, TraceBackend::Compute, SIZE, 7, false, params);
    // The denoiser has a history in the second frame.
    frames.render(0.0);
    frames.render(0.0);
    frames.image(FLAT_COLOR)
}

/// Base colour is off by up to 2 e / r of itself, where r is its root and e = 0.5 / 255: 2 % at a reflectance of 0.04, less than that above. What is off is
/// spread over the pixels in both directions.
#[test]
fn a_compact_frame_is_close_to_the_full_one() {
    let [full, compact] = [GbufferFormat::Full, GbufferFormat::Compact].map(|format| {
        let mut params = FrameParams::default();
        params.gbuffer.format = format;
        picture(params)
    });
    let luminance = |pixel: &[f32; 3]| pixel.iter().sum::<f32>();
    let sum = |image: &LinearImage| image.pixels.iter().map(luminance).sum::<f32>();
    let gain = sum(&compact) / sum(&full);
    let mut errors: Vec<f32> = (full.pixels.iter().zip(&compact.pixels))
        .map(|(a, b)| (luminance(a) - luminance(b)).abs() / luminance(a).max(1e-3))
        .collect();
    errors.sort_by(f32::total_cmp);
    let [median, most] = [0.5, 0.9].map(|share| errors[(share * errors.len() as f32) as usize]);
    println!("sum {gain}, error of half of the pixels below {median}, of 9 in 10 below {most}");
    assert!(most > 0.0, "the frames are the same");
    assert!((gain - 1.0).abs() < 0.002, "{gain}");
    assert!(median < 0.005 && most < 0.02, "{median}, {most}");
}

fn run(line: &str, paths: &[&str]) {
    let words = line.split(' ').chain(paths.iter().copied());
    let out = &mut Vec::new();
    let done = match Cli::try_parse_from(words).unwrap().command {
        Command::Capture(args) => pt_app::commands::capture::run(&args, out),
        Command::Replay(args) => pt_app::commands::replay::run(&args, out),
        _ => unreachable!("a command of this test"),
    };
    assert!(done.unwrap());
}

#[test]
fn a_compact_capture_is_replayed_to_the_bit() {
    replays_to_the_bit("--frames 0..2 --set gbuffer.format=compact --set denoise.variant=svgf");
}

/// With all that the composite takes: filtered light, and histories as they are.
#[test]
fn a_frame_with_histories_in_half_floats_is_close_to_the_full_one() {
    for variant in [Denoiser::Asvgf, Denoiser::Accumulate, Denoiser::Recurrent] {
        let [full, half] = [HistoryFormat::Full, HistoryFormat::Half].map(|histories| {
            let mut params = FrameParams::default();
            (params.denoise.variant, params.denoise.histories) = (variant, histories);
            picture(params)
        });
        let sum = |image: &LinearImage| image.pixels.iter().flatten().map(|v| f64::from(*v)).sum::<f64>();
        let gain = sum(&half) / sum(&full);
        let differ =
            |(a, b): (&[f32; 3], &[f32; 3])| (0..3).any(|k| (a[k] - b[k]).abs() > 0.01 * a[k].max(1e-3));
        let far = full.pixels.iter().zip(&half.pixels).filter(|pair| differ(*pair)).count();
        println!("{}: sum {gain}, {far} of {} pixels are far off", variant.name(), full.pixels.len());
        assert!(full.pixels != half.pixels, "the frames are the same");
        // A pixel's history is off by 2e-3 at most; the variance that the filters follow makes it more in few of them.
        assert!((gain - 1.0).abs() < 1e-3, "{}: {gain}", variant.name());
        assert!(50 * far < full.pixels.len(), "{}: {far}", variant.name());
    }
}

/// From the histories of the third frame on.
#[test]
fn histories_in_half_floats_are_replayed_to_the_bit() {
    replays_to_the_bit("--frames 2..5 --set denoise.variant=svgf --set denoise.histories=half");
}

/// The layers of the two forms hold other numbers: variances and means of squares.
#[test]
fn histories_of_the_other_form_are_not_taken() {
    let folder = tempfile::tempdir().unwrap();
    let [capture, replayed] =
        ["capture", "replayed.exr"].map(|name| folder.path().join(name).display().to_string());
    run(
        "pt capture cornell --size 33x18 --frames 2..3 --backend compute --set denoise.variant=svgf --set denoise.histories=half -o",
        &[&capture],
    );
    for (histories, longest) in [("half", 3), ("full", 1)] {
        let line =
            format!("pt replay --from denoise --aov denoise.surface --set denoise.histories={histories}");
        run(&line, &[&capture, "-o", &replayed]);
        let file = LayeredImage::read_exr(replayed.as_ref()).unwrap();
        let layer = file.layer("denoise.surface").unwrap();
        let Samples::U32(frames) = &layer.channel("y").unwrap().samples else {
            panic!("the lengths of the histories are integers")
        };
        assert_eq!(frames.iter().max(), Some(&longest), "{histories}");
    }
}

fn replays_to_the_bit(knobs: &str) {
    let folder = tempfile::tempdir().unwrap();
    let [capture, replayed] =
        ["capture", "replayed.exr"].map(|name| folder.path().join(name).display().to_string());
    run(&format!("pt capture cornell --size 33x18 --backend compute {knobs} -o"), &[&capture]);
    run(&format!("pt replay --from denoise --aov {}", NAMES.join(",")), &[&capture, "-o", &replayed]);
    let last = std::fs::read_dir(&capture).unwrap().map(|entry| entry.unwrap().path());
    let last = last.filter(|path| path.extension().is_some_and(|end| end == "exr")).max().unwrap();
    let [recorded, replayed] = [last, replayed.into()].map(|path| LayeredImage::read_exr(&path).unwrap());
    for name in NAMES {
        assert!(recorded.layer(name).is_some(), "{name}");
        assert!(recorded.layer(name) == replayed.layer(name), "{name} is another one when replayed");
    }
}
