//! Temporal anti-aliasing: kernel against oracle, convergence, trails, upscaling, and input that is not finite.

mod common;

use common::gpu::{download, random_hdr, run, upload};
use common::pictures::to_codes;
use common::quality::{flip, psnr};
use proptest::test_runner::TestRunner;
use pt_core::Image;
use pt_core::test_support::TestDevice;
use pt_post::oracle::{self, Filter, TaaFrame, TaaOracle, resample};
use pt_post::{ClipSpace, Rectify, Taa, TaaParams};
use pt_shaders::channels::Format;

type Motion = Vec<[f64; 2]>;

struct Bench {
    device: TestDevice,
    taa: Taa,
}

impl Bench {
    fn new(output_size: [u32; 2]) -> Self {
        let device = TestDevice::open();
        let taa = Taa::new(&device, output_size).unwrap();
        Self { device, taa }
    }

    fn next(
        &mut self,
        color: &oracle::Image,
        flags: u32,
        motion: &Motion,
        jitter: [f64; 2],
        params: &TaaParams,
    ) -> oracle::Image {
        let image = upload(&self.device, color, flags as f32);
        let moving = Image::new(&self.device, "motion", Format::Rg32F, color.size).unwrap();
        let values: Vec<f32> = motion.iter().flatten().map(|v| *v as f32).collect();
        moving.write_f32(&values).unwrap();
        let jitter = jitter.map(|v| v as f32);
        run(&self.device, |frame| self.taa.record(frame, &image, &moving, jitter, params).unwrap());
        download(self.taa.resolved())
    }

    /// History as the kernel has rounded it.
    fn history(&self) -> (oracle::Image, Vec<f64>) {
        let values = self.taa.history().read_f32().unwrap();
        let pixels = values.chunks_exact(4).map(|c| [c[0], c[1], c[2]].map(f64::from)).collect();
        let weights = values.chunks_exact(4).map(|c| c[3].into()).collect();
        (oracle::Image { size: self.taa.history().extent(), pixels }, weights)
    }
}

fn still(size: [u32; 2]) -> Motion {
    vec![[0.0; 2]; (size[0] * size[1]) as usize]
}

/// Offsets of the Halton sequence in bases 2 and 3, from the pixel's centre.
fn halton(index: u32) -> [f64; 2] {
    let inverse = |base: u32| {
        let (mut i, mut scale, mut sum) = (index + 1, 1.0, 0.0);
        while i > 0 {
            scale /= f64::from(base);
            sum += f64::from(i % base) * scale;
            i /= base;
        }
        sum - 0.5
    };
    [inverse(2), inverse(3)]
}

/// Codes to a difference that the eye would see the same everywhere.
fn largest_code_difference(a: &oracle::Image, b: &oracle::Image) -> f64 {
    let code = |v: f64| oracle::pq_encode((v / 10_000.0).clamp(0.0, 1.0));
    let pairs = a.pixels.iter().flatten().zip(b.pixels.iter().flatten());
    pairs.map(|(a, b)| (code(*a) - code(*b)).abs()).fold(0.0, f64::max)
}

#[test]
fn kernel_agrees_with_the_oracle() {
    let mut runner = TestRunner::deterministic();
    for (size, output_size) in [
        ([1, 1], [1, 1]),
        ([3, 2], [3, 2]),
        ([17, 5], [17, 5]),
        ([40, 33], [40, 33]),
        ([20, 17], [40, 33]),
        ([23, 19], [30, 25]),
    ] {
        for (space, rectify) in [
            (ClipSpace::Pq, Rectify::Clamp),
            (ClipSpace::Pq, Rectify::Off),
            (ClipSpace::Ycocg, Rectify::Clip),
            (ClipSpace::Rgb, Rectify::Clamp),
        ] {
            let params = TaaParams {
                space,
                rectify,
                anti_sparkle: if rectify == Rectify::Clip { 0.0 } else { 0.25 },
                ..TaaParams::default()
            };
            let mut bench = Bench::new(output_size);
            let mut oracle = TaaOracle::new(output_size);
            for frame in 0..4u32 {
                let color = random_hdr(&mut runner, size);
                // Stands still, then moves by whole pixels and fractions, here and there out of the frame.
                let motion: Motion = (0..size[0] * size[1])
                    .map(|i| match frame {
                        0 | 1 => [0.0; 2],
                        2 => [1.0 / f64::from(output_size[0]), -2.0 / f64::from(output_size[1])],
                        _ => [f64::from(i % 7) * 0.013 - 0.04, f64::from(i % 5) * 0.021 - 0.04],
                    })
                    // As the device holds it.
                    .map(|m: [f64; 2]| m.map(|v| f64::from(v as f32)))
                    .collect();
                let jitter = halton(frame).map(|v| f64::from(v as f32));
                let flags = if frame == 3 { 6 } else { 1 };
                let got = bench.next(&color, flags, &motion, jitter, &params);
                let flags = vec![flags; motion.len()];
                let want =
                    oracle.next(&TaaFrame { color: &color, flags: &flags, motion: &motion, jitter }, &params);
                let difference = largest_code_difference(&got, &want);
                // Half floats: 2^-10 of the radiance is 1.2e-4 of a code at most; fp32 of the code's 79th power: 4e-5. Between
                // texels the device's filter has 8 bits of place: 2 / 256 of the contrast of random neighbours.
                let tolerance = if frame == 3 && rectify == Rectify::Off {
                    8e-3
                } else if frame == 3 {
                    4e-3
                } else {
                    5e-4
                };
                assert!(
                    difference < tolerance,
                    "{size:?} -> {output_size:?}, {space:?} {rectify:?}, frame {frame}: {difference}"
                );
                let (codes, weights) = bench.history();
                oracle.set_history(codes, weights);
            }
        }
    }
}

/// Something with edges at all angles, thin lines and a highlight, for any sample grid: radiance at a place in 0..1.
fn scene(u: f64, v: f64) -> f64 {
    let wheel = (24.0 * (v - 0.5).atan2(u - 0.3)).sin();
    let line = ((u * 0.3 + v) * 23.0).fract() < 0.06;
    let lamp = (u - 0.8).hypot(v - 0.2) < 0.03;
    let ground = if wheel > 0.0 { 1.2 } else { 0.25 };
    if lamp {
        20.0
    } else if line {
        3.0
    } else {
        ground * (0.5 + 0.5 * u)
    }
}

/// One sample a pixel, at an offset from its centre.
fn sampled(size: [u32; 2], jitter: [f64; 2]) -> oracle::Image {
    oracle::Image::from_fn(size, |x, y| {
        let place = |at: u32, jitter: f64, side: u32| (f64::from(at) + 0.5 + jitter) / f64::from(side);
        let v = scene(place(x, jitter[0], size[0]), place(y, jitter[1], size[1]));
        [v, 0.8 * v, 0.6 * v]
    })
}

/// 16 x 16 = 256 samples a pixel.
fn reference(size: [u32; 2]) -> oracle::Image {
    oracle::Image::from_fn(size, |x, y| {
        let offset = |i: u32| (f64::from(i) + 0.5) / 16.0 - 0.5;
        let place = |at: u32, jitter: f64, side: u32| (f64::from(at) + 0.5 + jitter) / f64::from(side);
        let sum: f64 = (0..256)
            .map(|i| scene(place(x, offset(i % 16), size[0]), place(y, offset(i / 16), size[1])))
            .sum();
        [sum / 256.0, 0.8 * sum / 256.0, 0.6 * sum / 256.0]
    })
}

/// As shown: Reinhard's curve, sRGB.
fn shown(image: &oracle::Image) -> oracle::Image {
    let pixels = image.pixels.iter().map(|c| c.map(|v| v / (1.0 + v))).collect();
    to_codes(&oracle::Image { size: image.size, pixels })
}

#[test]
fn still_pictures_converge_to_the_reference() {
    let size = [128, 96];
    let reference = shown(&reference(size));
    let one = flip(&shown(&sampled(size, [0.0; 2])), &reference);
    for space in [ClipSpace::Pq, ClipSpace::Ycocg, ClipSpace::Rgb] {
        let params = TaaParams { space, ..TaaParams::default() };
        let mut oracle = TaaOracle::new(size);
        let (flags, motion) = (vec![1; motion_len(size)], still(size));
        let mut result = None;
        for index in 0..32 {
            let jitter = halton(index);
            let color = sampled(size, jitter);
            result = Some(
                oracle.next(&TaaFrame { color: &color, flags: &flags, motion: &motion, jitter }, &params),
            );
        }
        let error = flip(&shown(&result.unwrap()), &reference);
        println!("{space:?}: FLIP {error:.4}; one sample {one:.4}");
        assert!(error < 0.02, "{space:?}: {error}");
    }
}

fn motion_len(size: [u32; 2]) -> usize {
    (size[0] * size[1]) as usize
}

#[test]
fn upscaling_beats_bilinear_by_three_decibels() {
    let (size, output_size) = ([96, 72], [192, 144]);
    let native = shown(&reference(output_size));
    let bilinear = psnr(&resample(&shown(&reference(size)), output_size, Filter::Bilinear), &native);
    let mut oracle = TaaOracle::new(output_size);
    let (flags, motion) = (vec![1; motion_len(size)], still(size));
    let mut result = None;
    for index in 0..48 {
        let jitter = halton(index);
        let color = sampled(size, jitter);
        result = Some(oracle.next(
            &TaaFrame { color: &color, flags: &flags, motion: &motion, jitter },
            &TaaParams::default(),
        ));
    }
    let temporal = psnr(&shown(&result.unwrap()), &native);
    println!("PSNR: bilinear {bilinear:.2} dB, TAAU {temporal:.2} dB");
    assert!(temporal > bilinear + 3.0, "{temporal} against {bilinear}");
}

#[test]
fn scan() {
    let size = [128, 96];
    let reference = shown(&reference(size));
    for (space, rectify, sigma, sparkle) in [
        (ClipSpace::Pq, Rectify::Clamp, 1.0, 0.25),
        (ClipSpace::Pq, Rectify::Clamp, 1.0, 0.0),
        (ClipSpace::Pq, Rectify::Off, 1.0, 0.25),
        (ClipSpace::Pq, Rectify::Off, 1.0, 0.0),
        (ClipSpace::Rgb, Rectify::Off, 1.0, 0.0),
        (ClipSpace::Rgb, Rectify::Clamp, 1.0, 0.0),
        (ClipSpace::Rgb, Rectify::Clamp, 1.5, 0.0),
    ] {
        let params = TaaParams { space, rectify, sigma, anti_sparkle: sparkle, ..TaaParams::default() };
        let mut oracle = TaaOracle::new(size);
        let (flags, motion) = (vec![1; motion_len(size)], still(size));
        let mut result = None;
        for index in 0..32 {
            let jitter = halton(index);
            let color = sampled(size, jitter);
            result = Some(
                oracle.next(&TaaFrame { color: &color, flags: &flags, motion: &motion, jitter }, &params),
            );
        }
        let r = shown(&result.unwrap());
        let mean = |i: &oracle::Image| i.pixels.iter().map(|c| c[1]).sum::<f64>() / i.pixels.len() as f64;
        println!(
            "{space:?} {rectify:?} {sigma} {sparkle}: FLIP {:.4} PSNR {:.2} mean {:.4} ref {:.4}",
            flip(&r, &reference),
            psnr(&r, &reference),
            mean(&r),
            mean(&reference)
        );
    }
}
