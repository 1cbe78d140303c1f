//! Temporal anti-aliasing: kernel against oracle, convergence, trails, upscaling, and input that is not finite.

use crate::common::gpu::{download, random_hdr, run, upload};
use crate::common::pictures::to_codes;
use crate::common::quality::quality;
use proptest::test_runner::TestRunner;
use pt_core::test_support::TestDevice;
use pt_core::{ChannelImages, FrameSizes, Image, StageInputs};
use pt_post::images::{RESOLVED, TAA_HISTORY};
use pt_post::oracle::{self, Filter, TaaFrame, TaaOracle, resample};
use pt_post::{ClipSpace, Rectify, Taa, TaaParams};
use pt_shaders::channels::Format;

type Motion = Vec<[f64; 2]>;

struct Bench {
    device: TestDevice,
    images: ChannelImages,
    taa: Taa,
}

impl Bench {
    fn new(output_size: [u32; 2]) -> Self {
        let device = TestDevice::open();
        let images = ChannelImages::alone(&device, FrameSizes::same(output_size), &[Taa::IO]).unwrap();
        let taa = Taa::new(&device).unwrap();
        Self { device, images, taa }
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
        self.images.begin_frame();
        let inputs = StageInputs::new(&self.images);
        run(&self.device, |frame| {
            self.taa.record(frame, &inputs, &image, &moving, jitter, params).unwrap();
        });
        download(self.images.current(RESOLVED))
    }

    /// What the last frame left for the next.
    fn history(&self) -> Vec<f32> {
        self.images.current(TAA_HISTORY).read_f32().unwrap()
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
                // The kernel's rounding is not carried on.
                oracle.set_history(&bench.history());
            }
        }
    }
}

/// Edges at all angles, lines about a pixel wide and a lamp: radiance at a place in 0..1.
fn scene(u: f64, v: f64) -> f64 {
    let wheel = (7.0 * (v - 0.5).atan2(u - 0.3)).sin();
    let line = ((u * 0.3 + v) * 5.0).fract() < 0.06;
    let lamp = (u - 0.8).hypot(v - 0.2) < 0.04;
    let ground = if wheel > 0.0 { 0.9 } else { 0.25 };
    if lamp {
        8.0
    } else if line {
        1.5
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
    let one = quality(&shown(&sampled(size, [0.0; 2])), &reference).flip;
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
        let error = quality(&shown(&result.unwrap()), &reference).flip;
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
    let bilinear = quality(&resample(&shown(&reference(size)), output_size, Filter::Bilinear), &native).psnr;
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
    let temporal = quality(&shown(&result.unwrap()), &native).psnr;
    println!("PSNR: bilinear {bilinear:.2} dB, TAAU {temporal:.2} dB");
    assert!(temporal > bilinear + 3.0, "{temporal} against {bilinear}");
}

/// A bright square moves over a striped ground, three pixels a frame; then it stops being there. For how many frames is what it
/// leaves behind seen, by more than a tenth of its contrast?
fn trail_length(space: ClipSpace, rectify: Rectify, temporal: f32) -> u32 {
    let size = [96, 24];
    let frame = |left: i64| {
        oracle::Image::from_fn(size, |x, y| {
            let inside = (left..left + 16).contains(&i64::from(x)) && (4..20).contains(&y);
            [if inside {
                4.0
            } else if (x / 3) % 2 == 0 {
                0.5
            } else {
                0.3
            }; 3]
        })
    };
    let motion = |left: i64| -> Motion {
        (0..motion_len(size))
            .map(|i| {
                let (x, y) = ((i % 96) as i64, i / 96);
                let inside = (left..left + 16).contains(&x) && (4..20).contains(&y);
                [if inside { -3.0 / 96.0 } else { 0.0 }, 0.0]
            })
            .collect()
    };
    let params = TaaParams { space, rectify, temporal, ..TaaParams::default() };
    let flags = vec![1; motion_len(size)];
    let mut oracle = TaaOracle::new(size);
    let mut last = None;
    for step in 0..20 {
        let left = 2 + 3 * step;
        let color = frame(left);
        let motion = motion(left);
        last = Some(
            oracle
                .next(&TaaFrame { color: &color, flags: &flags, motion: &motion, jitter: [0.0; 2] }, &params),
        );
    }
    // The trail: pixels behind the square, by how long ago it left them.
    let (result, ground) = (shown(&last.unwrap()), shown(&frame(-100)));
    let left = 2 + 3 * 19;
    let contrast = result.at(left + 8, 12)[1] - ground.at(left + 8, 12)[1];
    (1..20)
        .filter(|ago| {
            let columns = left - 3 * ago..left - 3 * (ago - 1);
            let seen = |x, y| (result.at(x, y)[1] - ground.at(x, y)[1]).abs() > 0.1 * contrast;
            columns.into_iter().any(|x| (6..18).any(|y| seen(x, y)))
        })
        .max()
        .unwrap_or(0) as u32
}

#[test]
fn trails_are_short_when_history_is_rectified() {
    let off = trail_length(ClipSpace::Pq, Rectify::Off, 0.0);
    println!("no rectification: {off} frames");
    assert!(off > 10, "this scene is no test: {off}");
    for space in [ClipSpace::Pq, ClipSpace::Ycocg, ClipSpace::Rgb] {
        for rectify in [Rectify::Clamp, Rectify::Clip] {
            let [plain, temporal] =
                [0.0, TaaParams::default().temporal].map(|t| trail_length(space, rectify, t));
            println!("{space:?} {rectify:?}: {plain} frames, {temporal} with the temporal deviation");
            assert!(plain < off && temporal < off, "{space:?} {rectify:?}");
        }
    }
}

/// Pixels that are not finite, black frames and frames of 1e30: finite results, nothing that stays.
#[test]
fn broken_frames_leave_nothing_behind() {
    let size = [24, 16];
    let mut bench = Bench::new(size);
    let params = TaaParams::default();
    let clean = oracle::Image::from_fn(size, |x, _| [0.5 + 0.1 * f64::from(x % 3); 3]);
    let mut broken = clean.clone();
    broken.pixels[100] = [f64::NAN; 3];
    broken.pixels[200] = [f64::INFINITY, 1.0, 1.0];
    broken.pixels[0] = [-5.0; 3];
    let everywhere = |v: f64| oracle::Image::from_fn(size, |_, _| [v; 3]);
    let nan_motion: Motion =
        (0..motion_len(size)).map(|i| if i % 7 == 0 { [f64::NAN; 2] } else { [0.0; 2] }).collect();
    let first = bench.next(&broken, 1, &still(size), [0.0; 2], &params);
    assert!(
        first.pixels.iter().flatten().all(|v| (0.0..1.0).contains(v)),
        "only the broken pixels' own mean"
    );
    // Two pixels away from all of them everything is as it was.
    let plain = oracle::Image::from_fn(size, |x, y| clean.at(x.into(), y.into()));
    let spared = |i: usize| {
        [100, 200, 0].iter().all(|b: &usize| (b % 24).abs_diff(i % 24) > 1 || (b / 24).abs_diff(i / 24) > 1)
    };
    for i in (0..plain.pixels.len()).filter(|&i| spared(i)) {
        assert!((first.pixels[i][0] - plain.pixels[i][0]).abs() < 1e-3, "{i}");
    }
    for frame in [everywhere(f64::NAN), everywhere(0.0), everywhere(1e30), broken.clone()] {
        let result = bench.next(&frame, 1, &nan_motion, [0.1, -0.2], &params);
        assert!(result.pixels.iter().flatten().all(|v| (0.0..=10_001.0).contains(v)));
    }
    bench.images.reset_history();
    let after = bench.next(&clean, 1, &still(size), [0.0; 2], &params);
    assert!(largest_code_difference(&after, &plain) < 5e-4);
}

/// Without a reset: a frame that is missing as a whole and one with broken pixels fade from history like any other sample.
#[test]
fn broken_pixels_do_not_stay_in_history() {
    let size = [24, 16];
    let clean = oracle::Image::from_fn(size, |x, y| [0.5 + 0.1 * f64::from((x + y) % 3); 3]);
    let mut broken = clean.clone();
    for (i, v) in [(100, f64::NAN), (200, f64::INFINITY), (201, f64::NEG_INFINITY)] {
        broken.pixels[i] = [v; 3];
    }
    let missing = oracle::Image::from_fn(size, |_, _| [f64::NAN; 3]);
    for space in [ClipSpace::Pq, ClipSpace::Ycocg, ClipSpace::Rgb] {
        let params = TaaParams { space, ..TaaParams::default() };
        let mut bench = Bench::new(size);
        for frame in [&broken, &missing, &broken] {
            bench.next(frame, 1, &still(size), [0.0; 2], &params);
            let history = bench.history();
            assert!(history.iter().all(|v| (0.0..=1.0).contains(v)));
        }
        let mut last = None;
        for _ in 0..100 {
            last = Some(bench.next(&clean, 1, &still(size), [0.0; 2], &params));
        }
        let difference = largest_code_difference(&last.unwrap(), &clean);
        assert!(difference < 2e-3, "{space:?}: {difference}");
    }
}
