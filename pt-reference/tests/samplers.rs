//! sampler.glsl: its twin, and what the sequences promise.

use crate::common::records::{ListPush, SamplerCase};
use crate::common::{kernels, run};
use glam::UVec4;
use pt_core::rng::pcg4d;
use pt_core::sobol::sobol;
use pt_core::test_support::TestDevice;
use pt_core::test_support::statistics::{chi_squared, sidak};
use pt_core::{Buffer, Kernel, Location};
use pt_reference::oracle::sampler::{Sampler, SamplerKind};
use std::f64::consts::TAU;

const KINDS: [SamplerKind; 3] = [SamplerKind::Pcg, SamplerKind::Sobol, SamplerKind::BlueNoise];

fn sample(kind: SamplerKind, pixel: [u32; 2], index: u32, dimension: u32, seed: u32) -> [f64; 4] {
    let mut s = Sampler::new(kind, pixel, index, seed, 4);
    s.dimension = dimension;
    s.next_4d()
}

#[test]
fn kernel_equals_the_twin() {
    let device = TestDevice::open();
    let kernel = Kernel::compute::<ListPush>(&device, &kernels::SAMPLER_CASES, &[]).unwrap();
    let cases: Vec<SamplerCase> = (0..30_000u32)
        .map(|i| {
            let [a, b, c, d] = pcg4d([i, 1, 2, 3]);
            let wide = i % 5 == 0;
            SamplerCase {
                kind: i % 3,
                x: if wide { a >> 8 } else { a >> 21 },
                y: if wide { b >> 8 } else { b >> 21 },
                index: if wide { c } else { c >> 22 },
                seed: d,
                log2_spp: a % 17,
                dimension: b % 100,
            }
        })
        .collect();
    let buffer = Buffer::from_slice(&device, "cases", &cases).unwrap();
    let results = Buffer::new(&device, "results", cases.len() as u64 * 16, Location::Device).unwrap();
    let push = ListPush { count: cases.len() as u32, per_thread: 1 };
    let results: Vec<UVec4> = run(&device, &kernel, &push, push.count, &results, |pass| {
        pass.read("cases", &buffer).write("results", &results)
    });
    for (c, r) in cases.iter().zip(&results) {
        let mut s = Sampler::new(KINDS[c.kind as usize], [c.x, c.y], c.index, c.seed, c.log2_spp);
        s.dimension = c.dimension;
        assert_eq!(r.to_array(), s.bits(), "{c:?}");
    }
}

/// The first points by hand: the van der Corput sequence and the published second dimension.
#[test]
fn first_points_of_sobol() {
    let unit = |x: u32| f64::from(x) / 4_294_967_296.0;
    let points: Vec<[f64; 2]> = (0..8).map(|i| [unit(sobol(i)[0]), unit(sobol(i)[1])]).collect();
    let expected = [
        [0.0, 0.0],
        [0.5, 0.5],
        [0.25, 0.75],
        [0.75, 0.25],
        [0.125, 0.625],
        [0.625, 0.125],
        [0.375, 0.375],
        [0.875, 0.875],
    ];
    assert_eq!(points, expected);
}

/// Every block of 2^m samples of a pixel has one point in each elementary interval of the first two dimensions, and in each
/// of 2^m slices of the others.
#[test]
fn blocks_are_nets() {
    for (kind, log2) in [
        (SamplerKind::Sobol, 3),
        (SamplerKind::Sobol, 6),
        (SamplerKind::Sobol, 8),
        (SamplerKind::BlueNoise, 4),
    ] {
        let n = 1usize << log2;
        for (pixel, dimension, block) in [([0, 0], 0, 0), ([17, 5], 3, 1), ([511, 300], 40, 2)] {
            let first = if kind == SamplerKind::Sobol { block * n as u32 } else { 0 };
            let points: Vec<_> =
                (first..first + n as u32).map(|i| sample(kind, pixel, i, dimension, 9)).collect();
            for split in 0..=log2 {
                let (columns, rows) = (1usize << split, n >> split);
                let mut hit = vec![false; n];
                for p in &points {
                    hit[(p[0] * columns as f64) as usize * rows + (p[1] * rows as f64) as usize] = true;
                }
                assert!(hit.iter().all(|h| *h), "{kind:?}, {n} points, {columns} x {rows}");
            }
            for d in 0..4 {
                let mut hit = vec![false; n];
                points.iter().for_each(|p| hit[(p[d] * n as f64) as usize] = true);
                assert!(hit.iter().all(|h| *h), "{kind:?}, {n} points, dimension {d}");
            }
        }
    }
}

/// Uniform: over pixels at one sample, where even a sequence is random.
#[test]
fn numbers_are_uniform() {
    let tests = KINDS.len() * 4;
    for kind in KINDS {
        for d in 0..4 {
            let mut counts = vec![0u64; 32 * 32];
            let n = 128 * 128;
            for i in 0..n {
                // Pixels far from each other: near ones share strata by design.
                let p = sample(kind, [i % 128 * 4097, i / 128 * 4099], 3, 7, i);
                let q = p[(d + 1) % 4];
                counts[(p[d] * 32.0) as usize * 32 + (q * 32.0) as usize] += 1;
            }
            let expected = vec![f64::from(n) / 1024.0; 1024];
            let p = chi_squared(&counts, &expected);
            assert!(p > sidak(tests), "{kind:?}, dimension {d}: {p}");
        }
    }
}

/// Neither dimensions nor pixels nor seeds know of each other: correlations of 1024 samples stay below 4.5 standard errors.
#[test]
fn dimensions_pixels_and_seeds_are_independent() {
    const N: u32 = 1024;
    let series = |kind, pixel, dimension, seed, d: usize| -> Vec<f64> {
        (0..N).map(|i| sample_many(kind, pixel, i, dimension, seed)[d] - 0.5).collect()
    };
    let correlation = |a: &[f64], b: &[f64]| {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        dot(a, b) / (dot(a, a) * dot(b, b)).sqrt()
    };
    let limit = 4.5 / f64::from(N).sqrt();
    for kind in KINDS {
        let base = series(kind, [3, 4], 0, 1, 0);
        for dimension in 1..20 {
            for d in 0..4 {
                let r = correlation(&base, &series(kind, [3, 4], dimension, 1, d));
                assert!(r.abs() < limit, "{kind:?}, dimensions 0 and {dimension}.{d}: {r}");
            }
        }
        for d in 1..4 {
            let r = correlation(&base, &series(kind, [3, 4], 0, 1, d));
            assert!(r.abs() < limit, "{kind:?}, components 0 and {d}: {r}");
        }
        for k in 1..20 {
            let r = correlation(&base, &series(kind, [3, 4], 0, 1 + k, 0));
            assert!(r.abs() < limit, "{kind:?}, seeds 1 and {}: {r}", 1 + k);
            if kind != SamplerKind::BlueNoise {
                let r = correlation(&base, &series(kind, [3 + k, 4], 0, 1, 0));
                assert!(r.abs() < limit, "{kind:?}, pixels {k} apart: {r}");
            }
        }
    }
}

fn sample_many(kind: SamplerKind, pixel: [u32; 2], index: u32, dimension: u32, seed: u32) -> [f64; 4] {
    let mut s = Sampler::new(kind, pixel, index, seed, 10);
    s.dimension = dimension;
    s.next_4d()
}

/// Error of a pixel's estimate of the integral of a smooth and of a discontinuous function, at `spp` samples.
fn error(kind: SamplerKind, pixel: [u32; 2], log2_spp: u32, seed: u32) -> f64 {
    let spp = 1u32 << log2_spp;
    let sum: f64 = (0..spp)
        .map(|i| {
            let [x, y, ..] = Sampler::new(kind, pixel, i, seed, log2_spp).next_4d();
            f64::from(u8::from(x + y < 0.8)) + x * x * y
        })
        .sum();
    sum / f64::from(spp) - 0.32 - 1.0 / 6.0
}

/// Power of the error image at the lowest frequencies, over that at all of them; white noise has the share of the frequencies.
fn low_frequency_share(kind: SamplerKind, log2_spp: u32) -> f64 {
    const N: u32 = 64;
    const LOW: i32 = 6;
    let image: Vec<f64> = (0..N * N).map(|i| error(kind, [i % N, i / N], log2_spp, 5)).collect();
    let mean = image.iter().sum::<f64>() / image.len() as f64;
    let all: f64 = image.iter().map(|e| (e - mean).powi(2)).sum::<f64>() * image.len() as f64;
    let mut low = 0.0;
    let mut frequencies = 0;
    for (u, v) in (-LOW..=LOW).flat_map(|u| (-LOW..=LOW).map(move |v| (u, v))) {
        if (u, v) == (0, 0) || u * u + v * v > LOW * LOW {
            continue;
        }
        frequencies += 1;
        let (mut re, mut im) = (0.0, 0.0);
        for (i, e) in image.iter().enumerate() {
            let phase = TAU * f64::from(u * (i as i32 % N as i32) + v * (i as i32 / N as i32)) / f64::from(N);
            re += (e - mean) * phase.cos();
            im += (e - mean) * phase.sin();
        }
        low += re * re + im * im;
    }
    low / all / (f64::from(frequencies) / image.len() as f64)
}

#[test]
fn blue_noise_has_little_power_at_low_frequencies() {
    for log2_spp in [0, 2, 4] {
        let [white, blue] =
            [SamplerKind::Pcg, SamplerKind::BlueNoise].map(|k| low_frequency_share(k, log2_spp));
        println!(
            "{} spp: low-frequency power over white noise: PCG {white:.3}, blue noise {blue:.3}",
            1 << log2_spp
        );
        assert!((0.6..1.6).contains(&white), "{white}");
        assert!(blue < 0.35 * white, "{log2_spp}: {blue} {white}");
    }
}

/// Sobol's error falls faster than that of independent samples, and as fast as that of the sobol_burley crate.
#[test]
fn convergence_is_that_of_scrambled_sobol() {
    let mse = |f: &dyn Fn(u32) -> f64| (0..256).map(|seed| f(seed).powi(2)).sum::<f64>() / 256.0;
    for log2_spp in [4, 8] {
        let spp = 1u32 << log2_spp;
        let ours = mse(&|seed| error(SamplerKind::Sobol, [1, 2], log2_spp, seed));
        let random = mse(&|seed| error(SamplerKind::Pcg, [1, 2], log2_spp, seed));
        let theirs = mse(&|seed| {
            let points = (0..spp).map(|i| [0, 1].map(|d| f64::from(sobol_burley::sample(i, d, seed))));
            let sum: f64 = points.map(|[x, y]| f64::from(u8::from(x + y < 0.8)) + x * x * y).sum();
            sum / f64::from(spp) - 0.32 - 1.0 / 6.0
        });
        println!("{spp} spp: MSE {ours:.2e}, sobol_burley {theirs:.2e}, PCG {random:.2e}");
        assert!((0.5..2.0).contains(&(ours / theirs)), "{ours} {theirs}");
        assert!(ours < random * if log2_spp == 8 { 0.1 } else { 0.35 }, "{ours} {random}");
    }
}
