//! Random numbers of the frame's stages: the kernels' against the host twin, and what each source promises.

use pt_core::blue_noise::{SIDE, mask_buffer};
use pt_core::frame::Uniforms;
use pt_core::random::{RandomSource, coverage_number, random_bits, random_coverage, random_numbers};
use pt_core::rng::pcg4d;
use pt_core::test_support::TestDevice;
use pt_core::test_support::statistics::{chi_squared, sidak};
use pt_core::{Buffer, Kernel, Recorder};
use pt_shaders::NamedEnum;
use pt_shaders::dimensions::{
    DIM_EMISSIVE, DIM_ENVIRONMENT, DIM_PIXEL, DIM_POSITIONAL, DIM_REFLECT_REFRACT, DIM_SUN,
};
use pt_shaders::records::{FrameRecord, SceneRecord};
use std::f64::consts::TAU;

#[allow(dead_code, reason = "each test file runs some of them")]
mod kernels {
    include!(concat!(env!("OUT_DIR"), "/test_kernels.rs"));
}

const DIMENSIONS: [u32; 6] =
    [DIM_PIXEL, DIM_SUN, DIM_POSITIONAL, DIM_EMISSIVE, DIM_ENVIRONMENT, DIM_REFLECT_REFRACT];
const SEED: u32 = 7;

fn numbers(source: RandomSource, pixel: [u32; 2], frame: u32, dimension: u32) -> [f64; 4] {
    random_numbers(source, pixel, frame, dimension, SEED).map(f64::from)
}

#[test]
fn kernels_draw_what_the_host_twin_draws() {
    let device = TestDevice::open();
    let cases: Vec<[u32; 4]> = (0..8192)
        .map(|i| {
            let [pixel, frame, c, triangle] = pcg4d([i, 1, 2, 3]);
            [pixel, if i % 4 == 0 { frame } else { frame % 300 }, DIMENSIONS[c as usize % 6], triangle]
        })
        .collect();
    let mask = mask_buffer(&device).unwrap();
    let input = Buffer::from_slice(&device, "cases", &cases).unwrap();
    let words = Buffer::from_slice(&device, "words", &vec![[0u32; 4]; cases.len()]).unwrap();
    let coverages = Buffer::from_slice(&device, "coverages", &vec![[0f32; 2]; cases.len()]).unwrap();
    let frames: Uniforms<FrameRecord> = Uniforms::new(&device, "frame_uniforms").unwrap();
    let scenes: Uniforms<SceneRecord> = Uniforms::new(&device, "scene_uniforms").unwrap();
    let mut recorder = Recorder::new(&device).unwrap();
    for source in RandomSource::VALUES.iter().copied() {
        let constants = [("random_source", source.code().into())];
        let kernel = Kernel::compute::<()>(&device, &kernels::RANDOM_CASES, &constants).unwrap();
        let record = FrameRecord { seed: SEED, ..bytemuck::Zeroable::zeroed() };
        let scene = SceneRecord { blue_noise: mask.address(), ..bytemuck::Zeroable::zeroed() };
        let mut frame = recorder.begin().unwrap();
        frames.upload(&mut frame, &record).unwrap();
        scenes.upload(&mut frame, &scene).unwrap();
        frame
            .pass("random cases", &kernel)
            .read("frame_uniforms", frames.buffer())
            .read("scene_uniforms", scenes.buffer())
            .addresses(&mask)
            .read("cases", &input)
            .write("words", &words)
            .write("coverages", &coverages)
            .dispatch([cases.len() as u32, 1, 1])
            .unwrap();
        frame.submit().unwrap();
        recorder.finish().unwrap();
        let (words, coverages) = (words.read::<[u32; 4]>().unwrap(), coverages.read::<[f32; 2]>().unwrap());
        for ((&[pixel, frame, dimension, triangle], word), coverage) in cases.iter().zip(words).zip(coverages)
        {
            let pixel = [pixel & 0xffff, pixel >> 16];
            assert_eq!(word, random_bits(source, pixel, frame, dimension, SEED), "{source:?}");
            let ray = random_coverage(source, pixel, frame, dimension, SEED);
            let [x, ..] = random_numbers(source, pixel, frame, dimension, SEED);
            assert_eq!(coverage, [coverage_number(source, ray, 3, triangle), x], "{source:?}");
        }
    }
}

/// Uniform in one and in two dimensions, over the pixels of a frame and over the frames of a pixel.
#[test]
fn numbers_and_pairs_are_uniform() {
    let tests = 3 * DIMENSIONS.len() * 2 * 4 * 2;
    let check = |what: &str, points: &[[f64; 4]]| {
        for d in 0..4 {
            let mut counts = vec![0u64; 64];
            let mut pairs = vec![0u64; 16 * 16];
            for p in points {
                counts[(p[d] * 64.0) as usize] += 1;
                pairs[(p[d] * 16.0) as usize * 16 + (p[(d + 1) % 4] * 16.0) as usize] += 1;
            }
            for counts in [counts, pairs] {
                let expected = vec![points.len() as f64 / counts.len() as f64; counts.len()];
                let p = chi_squared(&counts, &expected);
                assert!(p > sidak(tests), "{what}, number {d}, {} bins: {p}", counts.len());
            }
        }
    };
    for source in RandomSource::VALUES.iter().copied() {
        for dimension in DIMENSIONS {
            // One tile of the mask: the next one repeats it.
            let pixels: Vec<_> = (0..4096).map(|i| numbers(source, [i % 64, i / 64], 5, dimension)).collect();
            check(&format!("{source:?}, dimension {dimension}, pixels"), &pixels);
            let frames: Vec<_> = (0..4096).map(|i| numbers(source, [37, 11], i, dimension)).collect();
            check(&format!("{source:?}, dimension {dimension}, frames"), &frames);
        }
    }
}

/// 2^k frames of a pixel, from a multiple of 2^k on, have one number in each of 2^k strata, and one point in every elementary interval
/// of the first two numbers.
#[test]
fn sobol_is_stratified_over_the_frames() {
    for dimension in DIMENSIONS {
        for (pixel, block, log2) in
            [([0, 0], 0, 1), ([17, 5], 1, 4), ([511, 300], 2, 6), ([1919, 1079], 3, 8)]
        {
            let n = 1usize << log2;
            let points: Vec<_> = (0..n as u32)
                .map(|i| numbers(RandomSource::Sobol, pixel, block * n as u32 + i, dimension))
                .collect();
            for d in 0..4 {
                let mut hit = vec![false; n];
                points.iter().for_each(|p| hit[(p[d] * n as f64) as usize] = true);
                assert!(hit.iter().all(|h| *h), "dimension {dimension}, {n} frames, number {d}");
            }
            for split in 0..=log2 {
                let (columns, rows) = (1usize << split, n >> split);
                let mut hit = vec![false; n];
                for p in &points {
                    hit[(p[0] * columns as f64) as usize * rows + (p[1] * rows as f64) as usize] = true;
                }
                assert!(hit.iter().all(|h| *h), "dimension {dimension}, {columns} x {rows}");
            }
            // The same of the rays' coverage by a triangle.
            let mut hit = vec![false; n];
            for i in 0..n as u32 {
                let ray = random_coverage(RandomSource::Sobol, pixel, block * n as u32 + i, dimension, SEED);
                hit[(f64::from(coverage_number(RandomSource::Sobol, ray, 1, 9)) * n as f64) as usize] = true;
            }
            assert!(hit.iter().all(|h| *h), "coverage of dimension {dimension}, {n} frames");
        }
    }
}

/// Power of an image of one tile at its lowest frequencies, over what white noise of the same variance has there.
fn low_frequency_power(image: &[f64]) -> f64 {
    const LOW: i32 = 6;
    let mean = image.iter().sum::<f64>() / image.len() as f64;
    let variance = image.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / image.len() as f64;
    let (mut power, mut count) = (0.0, 0.0);
    for (u, v) in (-LOW..=LOW).flat_map(|u| (0..=LOW).map(move |v| (u, v))) {
        if u * u + v * v > LOW * LOW || v == 0 && u <= 0 {
            continue;
        }
        let (mut re, mut im) = (0.0, 0.0);
        for (i, value) in image.iter().enumerate() {
            let phase =
                TAU * f64::from((u * (i % SIDE) as i32 + v * (i / SIDE) as i32) % SIDE as i32) / SIDE as f64;
            re += (value - mean) * phase.cos();
            im += (value - mean) * phase.sin();
        }
        power += re * re + im * im;
        count += 1.0;
    }
    power / count / (variance * image.len() as f64)
}

/// What a blur of the frame would leave: little of a frame's numbers, of what lies below a threshold, and of what is seen through a
/// BLEND triangle.
#[test]
fn frames_are_blue() {
    let tile = |value: &dyn Fn([u32; 2]) -> f64| -> f64 {
        let image: Vec<_> = (0..4096).map(|i| value([i % 64 + 1000, i / 64 + 500])).collect();
        low_frequency_power(&image)
    };
    for source in RandomSource::VALUES.iter().copied() {
        let (mut plain, mut step, mut coverage) = (0.0, 0.0, 0.0);
        let frames = 4;
        for frame in 0..frames {
            for dimension in DIMENSIONS {
                let number = |pixel| numbers(source, pixel, frame, dimension);
                let ray = |pixel| random_coverage(source, pixel, frame, dimension, SEED);
                plain += tile(&|pixel| number(pixel)[2]);
                step += tile(&|pixel| f64::from(u8::from(number(pixel)[1] < 0.3)));
                coverage +=
                    tile(&|pixel| f64::from(u8::from(coverage_number(source, ray(pixel), 2, 40) < 0.6)));
            }
        }
        let mean = [plain, step, coverage].map(|sum| sum / f64::from(frames) / DIMENSIONS.len() as f64);
        println!("{source:?}: low-frequency power over white noise {mean:.4?}");
        let limits = match source {
            // 24 means of 56 exponentially distributed powers: 1, within 5 standard errors.
            RandomSource::White => [0.86..1.14, 0.86..1.14, 0.86..1.14],
            RandomSource::BlueNoise => [0.0..0.01, 0.0..0.05, 0.0..0.05],
            // The shift cuts the ranks into pieces.
            RandomSource::Sobol => [0.0..0.1, 0.0..0.15, 0.0..0.15],
        };
        for (power, limit) in mean.iter().zip(&limits) {
            assert!(limit.contains(power), "{source:?}: {power}");
        }
    }
}

/// Neither dimensions nor numbers, nor surfaces behind each other, know of each other: correlations over the frames of some pixels
/// stay within 4.5 standard errors. Only frames count for those: pixels go through the same sequence.
#[test]
fn dimensions_are_independent() {
    const FRAMES: u32 = 1024;
    let samples = || (0..FRAMES).flat_map(|frame| [[3, 4], [40, 9]].map(|p| (p, frame)));
    let limit = 4.5 / f64::from(FRAMES).sqrt();
    for source in RandomSource::VALUES.iter().copied() {
        let mut series: Vec<(String, Vec<f64>)> = Vec::new();
        for dimension in DIMENSIONS {
            for d in 0..4 {
                let values =
                    samples().map(|(pixel, frame)| numbers(source, pixel, frame, dimension)[d] - 0.5);
                series.push((format!("{dimension}.{d}"), values.collect()));
            }
            for triangle in [1, 2] {
                let values = samples().map(|(pixel, frame)| {
                    let ray = random_coverage(source, pixel, frame, dimension, SEED);
                    f64::from(coverage_number(source, ray, 0, triangle)) - 0.5
                });
                series.push((format!("coverage {dimension}, triangle {triangle}"), values.collect()));
            }
        }
        for (i, (a_name, a)) in series.iter().enumerate() {
            for (b_name, b) in &series[..i] {
                let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
                let r = dot(a, b) / (dot(a, a) * dot(b, b)).sqrt();
                assert!(r.abs() < limit, "{source:?}, {a_name} and {b_name}: {r}");
            }
        }
    }
}

/// The mean over the frames is the integral at every pixel, also of functions of several dimensions and of surfaces behind each other.
#[test]
fn means_over_the_frames_are_the_integrals() {
    const FRAMES: u32 = 4096;
    type Integrand = fn(&dyn Fn(u32) -> [f64; 4], &dyn Fn(u32) -> f64) -> f64;
    let integrands: [(&str, f64, Integrand); 4] = [
        ("a triangle", 0.32, |n, _| f64::from(u8::from(n(DIM_EMISSIVE)[2] + n(DIM_EMISSIVE)[3] < 0.8))),
        ("a corner of three numbers", 0.064, |n, _| {
            f64::from(u8::from(n(DIM_SUN)[..3].iter().all(|&x| x < 0.4)))
        }),
        ("two dimensions", 0.32, |n, _| f64::from(u8::from(n(DIM_PIXEL)[0] + n(DIM_EMISSIVE)[2] < 0.8))),
        ("two surfaces", 0.25, |_, coverage| f64::from(u8::from(coverage(5) < 0.5 && coverage(6) < 0.5))),
    ];
    for source in RandomSource::VALUES.iter().copied() {
        for (name, integral, f) in integrands {
            let pixels = [[0, 0], [5, 77], [640, 361], [63, 64]];
            for pixel in pixels {
                let sum: f64 = (0..FRAMES)
                    .map(|frame| {
                        let ray = random_coverage(source, pixel, frame, DIM_PIXEL, SEED);
                        f(&|dimension| numbers(source, pixel, frame, dimension), &|triangle| {
                            coverage_number(source, ray, 0, triangle).into()
                        })
                    })
                    .sum();
                let error = (sum / f64::from(FRAMES) - integral).abs();
                let standard_error = (integral * (1.0 - integral) / f64::from(FRAMES)).sqrt();
                assert!(error < 4.0 * standard_error, "{source:?}, {name}, {pixel:?}: off by {error}");
            }
        }
    }
}
