//! EASU and RCAS: kernels against oracle, and what they promise.

use crate::common;
use crate::common::gpu::{download, largest_difference, random_codes, run, upload_as};
use crate::common::pictures::zone_plate;
use proptest::test_runner::TestRunner;
use pt_core::test_support::TestDevice;
use pt_core::{ChannelImages, FrameSizes, Image};
use pt_post::images::{DISPLAY_CODES, UPSCALED_CODES};
use pt_post::oracle::{self, easu, rcas};
use pt_post::{Encoding, Fsr, FsrParams, PostParams, Upscale};
use pt_shaders::channels::Format;

/// Half floats below 1 are at most 2^-11 apart, and drivers may round to either; and the kernel's fp32.
const STORED: f64 = 1.0 / 2048.0 + 1e-5;

fn params(fsr: FsrParams) -> PostParams {
    PostParams { upscale: Upscale::Fsr1, encoding: Encoding::Pq, dither: false, fsr, ..PostParams::default() }
}

fn fsr_images(device: &TestDevice, size: [u32; 2], output: [u32; 2]) -> ChannelImages {
    let sizes = FrameSizes { frame: size, resolved: size, output };
    ChannelImages::alone(device, sizes, &[Fsr::io(size != output)]).unwrap()
}

/// Codes in, upscaled codes and sharpened codes out.
fn upscale(
    device: &TestDevice,
    codes: &oracle::Image,
    output_size: [u32; 2],
    params: &PostParams,
    half: bool,
) -> (Option<oracle::Image>, oracle::Image) {
    let fsr = Fsr::with_precision(device, half).unwrap();
    let images = fsr_images(device, codes.size, output_size);
    let texels: Vec<f32> =
        codes.pixels.iter().flat_map(|c| [c[0] as f32, c[1] as f32, c[2] as f32, 1.0]).collect();
    images.current(DISPLAY_CODES).write_f32(&texels).unwrap();
    let target = Image::new(device, "target", Format::Rgba16F, output_size).unwrap();
    run(device, |frame| fsr.record(frame, &images, &target, params).unwrap());
    let upscaled = (codes.size != output_size).then(|| download(images.current(UPSCALED_CODES)));
    (upscaled, download(&target))
}

#[test]
fn kernels_agree_with_the_oracle() {
    let device = TestDevice::open();
    let mut runner = TestRunner::deterministic();
    for (size, output_size) in [
        ([1, 1], [1, 1]),
        ([1, 1], [3, 2]),
        ([2, 3], [4, 6]),
        ([17, 5], [22, 7]),
        ([33, 31], [66, 62]),
        ([40, 21], [60, 32]),
        ([9, 9], [36, 36]),
    ] {
        let codes = random_codes(&mut runner, size);
        for (sharpness, denoise) in [(0.0, false), (1.0, true)] {
            let knobs = params(FsrParams { sharpness, denoise, ..FsrParams::default() });
            let (upscaled, sharpened) = upscale(&device, &codes, output_size, &knobs, false);
            let source = match &upscaled {
                Some(upscaled) => {
                    let difference = largest_difference(upscaled, &easu(&codes, output_size), false);
                    assert!(difference < STORED, "easu {size:?} -> {output_size:?}: {difference}");
                    upscaled
                }
                None => &codes,
            };
            let want = rcas(source, (-f64::from(sharpness)).exp2(), denoise);
            let difference = largest_difference(&sharpened, &want, false);
            assert!(difference < STORED, "rcas {output_size:?}: {difference}");
        }
    }
}

/// The kernels in half floats: EASU, and RCAS into 8-bit codes, of which it may be off by one where half floats round the other way.
#[test]
fn half_floats_are_near_the_oracle() {
    let device = TestDevice::open();
    if !device.info().capabilities.half_floats {
        println!("skipped: the device has no arithmetic in half floats");
        return;
    }
    let decibels = |a: &oracle::Image, b: &oracle::Image| {
        let (a, b) = (a.pixels.iter().flatten(), b.pixels.iter().flatten());
        let squares: Vec<f64> = a.zip(b).map(|(a, b)| (a - b).powi(2)).collect();
        -10.0 * (squares.iter().sum::<f64>() / squares.len() as f64).log10()
    };
    let mut runner = TestRunner::deterministic();
    let plate = zone_plate([96, 64]);
    // In noise, gradients whose parts cancel turn by what half floats lose.
    for (what, codes, output_size, easu_least) in [
        ("noise", random_codes(&mut runner, [61, 40]), [122, 80], 48.0),
        ("noise, odd", random_codes(&mut runner, [33, 31]), [47, 43], 48.0),
        ("zone plate", plate.clone(), [192, 128], 60.0),
        ("zone plate x1.5", plate, [144, 96], 60.0),
    ] {
        for (sharpness, denoise) in [(0.0, false), (0.2, false), (1.0, true)] {
            let knobs = PostParams {
                encoding: Encoding::Srgb,
                ..params(FsrParams { sharpness, denoise, ..FsrParams::default() })
            };
            let fsr = Fsr::with_precision(&device, true).unwrap();
            let images = fsr_images(&device, codes.size, output_size);
            let source = upload_as(&device, &codes, 1.0, Format::Rgba16F);
            images.current(DISPLAY_CODES).write_f32(&source.read_f32().unwrap()).unwrap();
            let target = Image::new(&device, "target", Format::Rgba8Unorm, output_size).unwrap();
            run(&device, |frame| fsr.record(frame, &images, &target, &knobs).unwrap());
            let upscaled = download(images.current(UPSCALED_CODES));
            let want = rcas(&upscaled, (-f64::from(sharpness)).exp2(), denoise);
            let [easu_db, rcas_db] =
                [decibels(&upscaled, &easu(&codes, output_size)), decibels(&download(&target), &want)];
            let off = 255.0 * largest_difference(&download(&target), &want, false);
            println!(
                "{what}, sharpness {sharpness}: EASU {easu_db:.1} dB, RCAS {rcas_db:.1} dB, {off:.2} codes"
            );
            assert!(easu_db > easu_least && rcas_db > 57.0 && off < 1.5, "{what}");
        }
    }
}

/// A pixel darker or brighter than its neighbours bounds the sharpening too: it does not leave the range, which would clip it.
#[test]
fn isolated_pixels_are_not_clipped() {
    let spot = |spot: f64, ground: f64| {
        oracle::Image::from_fn([5, 5], |x, y| [if (x, y) == (2, 2) { spot } else { ground }; 3])
    };
    for (dark, ground) in [(0.1, 0.4), (0.02, 0.6), (0.9, 0.6), (0.98, 0.4)] {
        let sharp = rcas(&spot(dark, ground), 1.0, false);
        let at = sharp.at(2, 2)[0];
        assert!(at > 0.0 && at < 1.0 || (at - dark).abs() < 0.1, "{dark} on {ground} became {at}");
        assert!((at - ground).abs() > (dark - ground).abs(), "{dark} on {ground} is not sharper: {at}");
    }
}

/// At the native size only RCAS runs; strength 0 copies.
#[test]
fn sharpening_alone() {
    let device = TestDevice::open();
    let codes = random_codes(&mut TestRunner::deterministic(), [19, 13]);
    let off = PostParams { upscale: Upscale::None, ..params(FsrParams::default()) };
    let (upscaled, copied) = upscale(&device, &codes, codes.size, &off, false);
    assert!(upscaled.is_none());
    assert_eq!(copied, codes);
    let on = PostParams { fsr: FsrParams { sharpen: true, ..FsrParams::default() }, ..off };
    assert!(largest_difference(&upscale(&device, &codes, codes.size, &on, false).1, &codes, false) > 0.02);
}

#[test]
fn flat_ground_and_range_are_kept() {
    let device = TestDevice::open();
    let flat = oracle::Image::from_fn([7, 5], |_, _| [0.25, 0.5, 0.75]);
    for half in [false, true] {
        let (upscaled, sharpened) = upscale(&device, &flat, [13, 9], &params(FsrParams::default()), half);
        for image in [upscaled.unwrap(), sharpened] {
            assert!(image.pixels.iter().all(|c| *c == [0.25, 0.5, 0.75]), "half floats: {half}");
        }
    }
    // Black and white next to each other: nothing leaves the range.
    let hard = oracle::Image::from_fn([16, 16], |x, y| [f64::from((x / 2 + y / 3) % 2); 3]);
    let strongest = params(FsrParams { sharpness: 0.0, ..FsrParams::default() });
    for half in [false, true] {
        let (upscaled, sharpened) = upscale(&device, &hard, [32, 32], &strongest, half);
        for image in [upscaled.unwrap(), sharpened] {
            assert!(image.pixels.iter().flatten().all(|v| (0.0..=1.0).contains(v)), "half floats: {half}");
        }
    }
}

/// An edge at 30 degrees comes out with less stair than bilinear interpolation gives it: that is what EASU is for.
#[test]
fn slanted_edges_are_smoother_than_bilinear() {
    let edge = |scale: f64| {
        move |x: f64, y: f64| {
            if (x * scale - 32.0) * 0.5 - (y * scale - 32.0) * 0.866 > 0.0 { 0.9 } else { 0.1 }
        }
    };
    let native = common::pictures::supersampled([64, 64], edge(1.0));
    let low = common::pictures::supersampled([32, 32], edge(2.0));
    let error = |image: &oracle::Image| {
        let pairs = image.pixels.iter().zip(&native.pixels);
        (pairs.map(|(a, b)| (a[0] - b[0]).powi(2)).sum::<f64>() / native.pixels.len() as f64).sqrt()
    };
    let bilinear = error(&oracle::resample(&low, [64, 64], oracle::Filter::Bilinear));
    let adaptive = error(&easu(&low, [64, 64]));
    assert!(adaptive < 0.75 * bilinear, "{adaptive} against {bilinear}");
}

/// 8-bit sRGB output is the HDR output rounded.
#[test]
fn eight_bit_output_is_rounded() {
    let device = TestDevice::open();
    let codes = random_codes(&mut TestRunner::deterministic(), [21, 10]);
    let fsr = Fsr::new(&device).unwrap();
    let images = fsr_images(&device, codes.size, codes.size);
    let source = upload_as(&device, &codes, 1.0, Format::Rgba16F);
    images.current(DISPLAY_CODES).write_f32(&source.read_f32().unwrap()).unwrap();
    let target = Image::new(&device, "target", Format::Rgba8Unorm, codes.size).unwrap();
    let knobs = PostParams { encoding: Encoding::Srgb, ..params(FsrParams::default()) };
    run(&device, |frame| fsr.record(frame, &images, &target, &knobs).unwrap());
    let want = rcas(&codes, 0.5, false);
    let got = download(&target);
    assert!(largest_difference(&got, &want, false) <= 0.501 / 255.0);
}

/// scRGB is made from PQ codes at the end: linear light in Rec. 709, 1 = 80 cd/m2.
#[test]
fn scrgb_is_decoded_at_the_end() {
    let device = TestDevice::open();
    let grey = oracle::pq_encode(203.0 / 10_000.0);
    let codes = oracle::Image::from_fn([4, 4], |_, _| [grey; 3]);
    let knobs = PostParams { encoding: Encoding::Scrgb, ..params(FsrParams::default()) };
    let (_, shown) = upscale(&device, &codes, [4, 4], &knobs, false);
    // The code's half float: one step of 2^-12 is 0.5 % of the luminance.
    assert!(
        shown.pixels.iter().flatten().all(|v| (v / (203.0 / 80.0) - 1.0).abs() < 6e-3),
        "{:?}",
        shown.pixels[0]
    );
}

/// Input and output of both kernels, committed so that other implementations can be compared: `tests/vectors/fsr.json`. The
/// test recomputes them; `PT_WRITE_VECTORS=1` writes them anew.
#[test]
fn vectors_are_those_that_are_committed() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/vectors/fsr.json");
    let input = oracle::Image::from_fn([16, 12], |x, y| {
        let plate = zone_plate([16, 12]);
        let c = plate.at(x.into(), y.into())[0];
        // A ramp, a slanted edge and rings in one channel each, to 8 bits.
        [f64::from(x) / 15.0, if x + 2 * y > 18 { 0.9 } else { 0.15 }, c].map(|v| (v * 255.0).round() / 255.0)
    });
    let upscaled = easu(&input, [24, 18]);
    let sharpened = rcas(&upscaled, (-0.2f64).exp2(), false);
    let rounded = |image: &oracle::Image| {
        let values = image.pixels.iter().flatten().map(|v| (v * 1e6).round() / 1e6);
        serde_json::json!({ "size": image.size, "rgb": values.collect::<Vec<f64>>() })
    };
    let vectors = serde_json::json!({
        "about": "sRGB codes 0..1, rows from the top; input -> EASU x1.5 -> RCAS 0.2 stops",
        "input": rounded(&input), "easu": rounded(&upscaled), "rcas": rounded(&sharpened),
    });
    if std::env::var_os("PT_WRITE_VECTORS").is_some() {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, serde_json::to_string(&vectors).unwrap()).unwrap();
    }
    let committed: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    for part in ["input", "easu", "rcas"] {
        assert_eq!(committed[part]["size"], vectors[part]["size"]);
        let values = |v: &serde_json::Value| -> Vec<f64> {
            v["rgb"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
        };
        let (a, b) = (values(&committed[part]), values(&vectors[part]));
        assert!(a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 2e-6), "{part}");
    }
}
