//! lights.glsl: picks against their probabilities, directions against their densities, kernels against the oracle.

use crate::common::records::{SampleRecord, SamplerPush};
use crate::common::{close, kernels, run_sampler};
use glam::{Vec2, Vec3};
use pt_core::rng::pcg4d;
use pt_core::test_support::TestDevice;
use pt_core::test_support::statistics::{SIGNIFICANCE, chi_squared, sidak};
use pt_core::trace::TraceBackend;
use pt_core::{Buffer, Kernel, Recorder};
use pt_light_sampling::oracle::lights::{LightSample, LightSampler};
use pt_light_sampling::test_support::{Uploaded, all_kinds, bright_spot};
use pt_light_sampling::{AliasTable, LightLists};
use pt_scene::{Environment, Scene};
use pt_shaders::records::SceneRecord;
use std::f64::consts::PI;

const SUN: u32 = 1;
const POSITIONAL: u32 = 2;
const EMISSIVE: u32 = 3;
const ENVIRONMENT: u32 = 4;
const SAMPLES: u32 = 100_000;
/// Chi-squared tests in this program.
const TESTS: usize = 8;
const AT: Vec3 = Vec3::new(0.2, 0.1, 0.3);

fn draw(device: &TestDevice, scene: &mut Uploaded, family: u32, at: Vec3) -> Vec<SampleRecord> {
    let kernel = Kernel::compute::<SamplerPush>(device, &kernels::LIGHT_SAMPLERS, &[]).unwrap();
    let push = SamplerPush { family, count: SAMPLES, seed: 9, parameter: 0.0, vector: at };
    run_sampler(device, &kernel, &push, Some(scene), |pass| pass)
}

fn bits(i: usize, family: u32) -> [u32; 4] {
    pcg4d([i as u32, 0, family, 9])
}

#[test]
fn kernels_equal_the_oracle() {
    let device = TestDevice::open();
    let mut uploaded = Uploaded::new(&device, all_kinds(), TraceBackend::Compute);
    let scene = all_kinds();
    let lists = LightLists::new(&scene);
    let oracle = LightSampler::new(&scene, &lists);
    // The second point is above some lamps and beside others.
    for at in [AT, Vec3::new(1.2, 3.4, 0.5)] {
        for family in [SUN, POSITIONAL, EMISSIVE, ENVIRONMENT] {
            let samples = draw(&device, &mut uploaded, family, at);
            let mut found = 0;
            for (i, sample) in samples.iter().enumerate() {
                let bits = bits(i, family);
                let expected = match family {
                    SUN => oracle.sun(bits),
                    POSITIONAL => oracle.positional(at, bits),
                    EMISSIVE => oracle.emissive(at, bits),
                    _ => oracle.environment(bits),
                };
                match expected {
                    Some(expected) => {
                        // Texture units interpolate with weights of 8 bits, here between texels of up to 32.
                        let tolerance = if family == ENVIRONMENT { 32.0 / 256.0 } else { 2e-3 };
                        compare(&format!("{family} {i} at {at}"), sample, &expected, tolerance);
                    }
                    None => assert_eq!(sample.pdf, 0.0),
                }
                found += usize::from(expected.is_some());
            }
            assert!(found > samples.len() / 20, "{family}: {found} samples");
        }
    }
}

fn compare(name: &str, sample: &SampleRecord, expected: &LightSample, radiance: f64) {
    let relative = f64::from(sample.pdf) / expected.pdf - 1.0;
    // At grazing angles of an emitting triangle the cosine is a small difference.
    assert!(relative.abs() < 2e-3 || expected.pdf > 1e3, "{name}: {sample:?} {expected:?}");
    assert!(close(sample.value, expected.direction, 1e-4), "{name}: {sample:?} {expected:?}");
    assert!(close(sample.radiance, expected.radiance, radiance), "{name}: {sample:?} {expected:?}");
    assert_eq!(sample.word & 1 != 0, expected.delta, "{name}");
    assert_eq!(sample.word & 2 != 0, expected.target.is_some(), "{name}");
    if let Some(target) = expected.target {
        // Moved off its triangle by some hundred units in the last place.
        assert!(close(sample.target, target, 2e-4), "{name}: {sample:?} {expected:?}");
    }
}

/// Alias tables of the emissive triangles, and a large one with weights over six decades.
#[test]
fn picks_follow_the_pmf() {
    let device = TestDevice::open();
    let emissive = LightLists::new(&all_kinds()).emissive_alias.unwrap();
    let weights: Vec<f64> =
        (0..3000).map(|i| if i % 7 == 0 { 0.0 } else { 10f64.powf(-f64::from(i % 60) / 10.0) }).collect();
    for table in [emissive, AliasTable::new(&weights).unwrap()] {
        let n = table.entries().len();
        let sum: f64 = (0..n).map(|i| table.pmf(i)).sum();
        assert!((sum - 1.0).abs() < 1e-12);
        let entries = Buffer::from_slice(&device, "alias", table.entries()).unwrap();
        let record = SceneRecord { emissive_alias: entries.address(), ..bytemuck::Zeroable::zeroed() };
        let uniforms = Buffer::from_slice(&device, "scene_uniforms", &[record]).unwrap();
        let counts = Buffer::from_slice(&device, "counts", &vec![0u32; n]).unwrap();
        let kernel = Kernel::compute::<SamplerPush>(&device, &kernels::ALIAS_PICKS, &[]).unwrap();
        let count = 1_000_000;
        let push = SamplerPush { family: n as u32, count, seed: 3, parameter: 0.0, vector: Vec3::ZERO };
        let mut recorder = Recorder::new(&device).unwrap();
        let mut frame = recorder.begin().unwrap();
        let pass = frame.pass("picks", &kernel).read("scene_uniforms", &uniforms).update("counts", &counts);
        pass.addresses(&entries).push(&push).dispatch([count, 1, 1]).unwrap();
        frame.submit().unwrap();
        let observed: Vec<u64> = counts.read::<u32>().unwrap().into_iter().map(u64::from).collect();
        let expected: Vec<f64> = (0..n).map(|i| table.pmf(i) * f64::from(count)).collect();
        let p = chi_squared(&observed, &expected);
        assert!(p > sidak(TESTS), "{n} entries: p = {p}");
        // A tenth taken from the likelier entries is noticed.
        let middle = observed.iter().sum::<u64>() as f64 / n as f64;
        let wrong: Vec<f64> = expected.iter().map(|&e| if e > middle { 0.9 * e } else { e }).collect();
        let scale = f64::from(count) / wrong.iter().sum::<f64>();
        let wrong: Vec<f64> = wrong.iter().map(|e| e * scale).collect();
        assert!(chi_squared(&observed, &wrong) < SIGNIFICANCE, "{n} entries: a wrong pmf is not noticed");
    }
}

/// The environment's directions against the table: four bins of equal solid angle to a texel, found by the lookup's own
/// mapping. And the density of every sample against the one that environment_pdf gives for its direction.
#[test]
fn environment_directions_follow_the_pdf() {
    let device = TestDevice::open();
    for (width, height, rotation) in [(13, 9, 0.0), (32, 16, 1.1), (1, 1, 0.0)] {
        let environment = match width {
            1 => Environment::constant(Vec3::ONE),
            _ => Environment { rotation, ..bright_spot(width, height) },
        };
        let scene = Scene { environment, ..all_kinds() };
        let mut scene = Uploaded::new(&device, scene, TraceBackend::Compute);
        let samples = draw(&device, &mut scene, ENVIRONMENT, AT);
        let alias = scene.lights.lists().environment_alias.as_ref().unwrap();
        let (w, h) = (width as usize, height as usize);
        let mut observed = vec![0; 4 * w * h];
        let mut differing = 0;
        for sample in &samples {
            let uv = scene.scene.environment.uv(sample.value.normalize());
            let (x, y) = (uv.x.rem_euclid(1.0) * w as f32, uv.y * h as f32);
            let row = (y as usize).min(h - 1);
            let cos = |row: usize| (PI * row as f64 / h as f64).cos();
            let lower = f64::from(sample.value.y) < 0.5 * (cos(row) + cos(row + 1));
            let quarter = 2 * usize::from(lower) + usize::from(x.fract() >= 0.5);
            observed[4 * (row * w + (x as usize).min(w - 1)) + quarter] += 1;
            differing += u32::from((sample.pdf / sample.pdf_again - 1.0).abs() > 1e-4);
        }
        // A direction on the border between texels may be looked up on its other side.
        assert!(differing < SAMPLES / 1000, "{differing} samples whose pdf differs from environment_pdf");
        let expected: Vec<f64> =
            (0..4 * w * h).map(|bin| 0.25 * alias.pmf(bin / 4) * f64::from(SAMPLES)).collect();
        let p = chi_squared(&with_border(&observed, &expected), &expected);
        assert!(p > sidak(TESTS), "{width}x{height}: p = {p}");
        // Picks without the sine of the polar angle.
        let wrong: Vec<f64> = (0..4 * w * h)
            .map(|bin| expected[bin] / (PI * ((bin / 4 / w) as f64 + 0.5) / h as f64).sin())
            .collect();
        let scale = f64::from(SAMPLES) / wrong.iter().sum::<f64>();
        let wrong: Vec<f64> = wrong.iter().map(|e| e * scale).collect();
        let notices = chi_squared(&observed, &wrong) < SIGNIFICANCE;
        assert!(notices || h == 1, "a pdf with a wrong sine is not noticed");
    }
}

/// Takes out the few samples whose texel is black by rounding: they lie on the border of a lit one.
fn with_border(observed: &[u64], expected: &[f64]) -> Vec<u64> {
    let stray: u64 = observed.iter().zip(expected).filter(|(_, e)| **e == 0.0).map(|(o, _)| o).sum();
    assert!(stray < u64::from(SAMPLES) / 1000, "{stray} samples in black texels");
    observed.iter().zip(expected).map(|(&o, &e)| if e == 0.0 { 0 } else { o }).collect()
}

/// Every direction with radiance can be found: no lookup returns light where the pdf is zero.
#[test]
fn no_radiance_without_density() {
    let scene = Scene { environment: bright_spot(7, 5), ..all_kinds() };
    let lists = LightLists::new(&scene);
    let oracle = LightSampler::new(&scene, &lists);
    let mut dark = 0;
    for i in 0..200_000 {
        let xi = pcg4d([i, 0, 0, 0]).map(|w| (w >> 8) as f32 / 16_777_216.0);
        let d = scene.environment.direction(Vec2::new(xi[0], xi[1]));
        let lit = scene.environment.radiance(d).max_element() > 1e-6;
        assert!(!lit || oracle.environment_pdf(d) > 0.0, "{d}");
        dark += usize::from(!lit);
    }
    assert!(dark > 1000, "the test environment has black parts");
}

/// Emissive triangles: positions on each lamp are uniform in area and lamps are chosen by area x luminance.
#[test]
fn emissive_points_follow_the_density() {
    let device = TestDevice::open();
    let mut scene = Uploaded::new(&device, all_kinds(), TraceBackend::Compute);
    let below = Vec3::new(0.0, -40.0, 0.0);
    // From far below, all lamps show their front and the targets of samples are the points.
    let samples = draw(&device, &mut scene, EMISSIVE, below);
    let lists = scene.lights.lists();
    let alias = lists.emissive_alias.as_ref().unwrap();
    let lamps: [(f64, f64, usize); 3] = [(-1.5, 1.0, 0), (0.7, 0.3, 1), (-3.0, 0.5, 2)];
    let (mut observed, mut expected) = (vec![0u64; 3 * 16 + 1], vec![0.0; 3 * 16 + 1]);
    for sample in samples.iter().filter(|s| s.pdf > 0.0) {
        let p = sample.target.as_dvec3();
        let hit = lamps.iter().position(|&(x, size, i)| {
            let along = if i == 2 { x - p.x } else { p.x - x };
            (p.y - 2.5).abs() < 1e-2 && (0.0..=size).contains(&along) && (0.0..=size).contains(&p.z)
        });
        match hit {
            Some(i) => {
                let (x, size, _) = lamps[i];
                let cell = |along: f64| ((along / size * 4.0) as usize).min(3);
                observed[16 * i + 4 * cell(p.z) + cell((p.x - x).abs())] += 1;
            }
            None => observed[48] += 1,
        }
    }
    for (triangle, i) in lists.emissives.iter().zip(0..) {
        let share = alias.pmf(i) * f64::from(SAMPLES);
        match triangle.instance {
            // Two triangles, each over half of the 16 cells' area.
            lamp @ 0..3 => (0..16).for_each(|cell| expected[16 * lamp as usize + cell] += share / 16.0),
            _ => expected[48] += share,
        }
    }
    let p = chi_squared(&observed, &expected);
    assert!(p > sidak(TESTS), "p = {p}");
    let by_area: Vec<f64> =
        (0..49).map(|i| [1.0, 0.09, 0.25, 1.0][i / 16] / if i == 48 { 1.0 } else { 16.0 }).collect();
    let scale = f64::from(SAMPLES) / by_area.iter().sum::<f64>();
    let wrong: Vec<f64> = by_area.iter().map(|a| a * scale).collect();
    assert!(chi_squared(&observed, &wrong) < SIGNIFICANCE, "picks by area alone are not noticed");
}
