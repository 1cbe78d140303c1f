//! The environment as local lights: directions of quads against their densities, the look-up of a direction, densities of the choice, and
//! environments that are odd.

use crate::common::records::{SampleRecord, SamplerPush};
use crate::common::{close, kernels, run_sampler};
use glam::Vec3;
use pt_core::Kernel;
use pt_core::rng::pcg4d;
use pt_core::test_support::TestDevice;
use pt_core::test_support::statistics::{chi_squared, sidak};
use pt_core::trace::TraceBackend;
use pt_light_sampling::SamplerChoice;
use pt_light_sampling::oracle::environment_quads::sample_environment_quad;
use pt_light_sampling::test_support::{Uploaded, all_kinds, bright_spot};
use pt_scene::{Environment, EnvironmentImage, Scene};
use pt_shaders::named_enum::NamedEnum;
use pt_shaders::records::{LOCAL_ENVIRONMENT, LightSampler};
use std::f64::consts::PI;

const SAMPLES: u32 = 60_000;
const AT: Vec3 = Vec3::new(0.2, 0.1, 0.3);
/// Chi-squared tests in this program.
const TESTS: usize = 4;

const DIRECTIONS: u32 = 0;
const CELLS: u32 = 1;
const PICKS: u32 = 2;
const RECORDS: u32 = 3;

fn image(width: u32, height: u32, texel: impl Fn(u32, u32) -> f32) -> Environment {
    let texels = (0..width * height).map(|i| Vec3::splat(texel(i % width, i / width))).collect();
    Environment::new(EnvironmentImage { width, height, texels })
}

fn one_texel() -> Environment {
    Environment { rotation: 0.3, ..image(150, 75, |x, y| if (x, y) == (0, 4) { 5e4 } else { 0.0 }) }
}

/// A scene whose environment is listed.
struct Listed {
    uploaded: Uploaded,
    kernel: Kernel,
}

impl Listed {
    fn new(device: &TestDevice, environment: Environment, sampler: LightSampler) -> Self {
        let scene = Scene { environment, ..all_kinds() };
        let mut uploaded = Uploaded::new(device, scene, TraceBackend::Compute);
        let Uploaded { scene, lights, gpu } = &mut uploaded;
        let choice = SamplerChoice { environment_listed: true, ..sampler.into() };
        lights.prepare(device, scene, gpu, Some(choice)).unwrap();
        let constants = [("light_sampler", sampler.code().into())];
        let kernel = Kernel::compute::<SamplerPush>(device, &kernels::ENVIRONMENT_QUADS, &constants).unwrap();
        Self { uploaded, kernel }
    }

    fn run(&mut self, device: &TestDevice, family: u32, count: u32) -> Vec<SampleRecord> {
        let push = SamplerPush { family, count, seed: 5, parameter: 0.4, vector: AT };
        run_sampler(device, &self.kernel, &push, Some(&mut self.uploaded), |pass| pass)
    }

    fn cells(&mut self, device: &TestDevice) -> Vec<SampleRecord> {
        let [width, height] = self.uploaded.lights.lists().environment_quads.as_ref().unwrap().grid();
        self.run(device, CELLS, width * height)
    }

    /// Indices of the quads among the local lights.
    fn quads(&self) -> std::ops::Range<u32> {
        let range = self.uploaded.lights.lists().quad_range();
        range.start as u32..range.end as u32
    }
}

/// Directions of all quads in turn, in bins of several cells or in quarters of a cell, against the tables; their densities against those of
/// the look-up; their radiance against that of the picture.
#[test]
fn directions_follow_the_pdf() {
    let device = TestDevice::open();
    let spots = Environment { rotation: 1.1, intensity: 0.7, ..bright_spot(13, 9) };
    // Bins: columns and rows of cells; quarters.
    for (name, environment, bin, parts) in [
        ("spots", spots, [8, 4], 1),
        ("one texel", one_texel(), [1, 1], 2),
        ("constant", Environment::constant(Vec3::ONE), [4, 2], 1),
        ("rows", image(3, 64, |x, y| (x + 1) as f32 * (y % 5) as f32), [4, 1], 1),
    ] {
        let mut scene = Listed::new(&device, environment.clone(), LightSampler::Power);
        let samples = scene.run(&device, DIRECTIONS, SAMPLES);
        let range = scene.quads();
        let quads = scene.uploaded.lights.lists().environment_quads.clone().unwrap();
        let (count, grid) = (quads.quads().len() as u32, quads.grid());
        let columns = (grid[0] / bin[0] * parts) as usize;
        let bins = columns * (grid[1] / bin[1] * parts) as usize;
        let (mut observed, mut strays) = (vec![0u64; bins], 0);
        let numbers = |i: u32| pcg4d([i, 0, DIRECTIONS, 5]).map(|word| (word >> 8) as f32 / 16_777_216.0);
        let brightest = environment.image.texels.iter().map(|t| t.max_element()).fold(0.0, f32::max);
        for (i, sample) in (0..).zip(&samples) {
            assert!(sample.pdf > 0.0, "{name}: {sample:?}");
            assert!((sample.value.length() - 1.0).abs() < 1e-5, "{name}: {sample:?}");
            let [_, _, a, b] = numbers(i);
            let expected = sample_environment_quad(&quads, &environment, i % count, [a, b]).unwrap();
            assert!(close(sample.value, expected.direction, 1e-5), "{name} {i}: {sample:?} {expected:?}");
            assert!(
                (f64::from(sample.pdf) / expected.pdf - 1.0).abs() < 1e-4,
                "{name} {i}: {sample:?} {expected:?}"
            );
            // Texture units interpolate with weights of 8 bits.
            let radiance = environment.radiance(sample.value.normalize()).as_dvec3();
            let tolerance = f64::from(brightest * environment.intensity) / 64.0;
            assert!(
                (sample.radiance.as_dvec3() - radiance).abs().max_element() <= tolerance,
                "{name}: {sample:?}"
            );
            // On the border of its cell a direction may be looked up on the other side.
            let same =
                sample.word == range.start + i % count && (sample.pdf / sample.pdf_again - 1.0).abs() < 1e-4;
            strays += u32::from(!same);
            let uv = environment.uv(sample.value.normalize());
            let (x, y) = (uv.x.rem_euclid(1.0) * grid[0] as f32, uv.y * grid[1] as f32);
            let row = (y as u32).min(grid[1] - 1);
            let cos = |row: u32| (PI * f64::from(row) / f64::from(grid[1])).cos();
            let lower = f64::from(sample.value.y) < 0.5 * (cos(row) + cos(row + 1));
            let column = (x as u32).min(grid[0] - 1);
            let (part_x, part_y) =
                (u32::from(x.fract() >= 0.5) * (parts - 1), u32::from(lower) * (parts - 1));
            let at = [column / bin[0] * parts + part_x, row / bin[1] * parts + part_y];
            observed[at[1] as usize * columns + at[0] as usize] += 1;
        }
        assert!(strays < SAMPLES / 500, "{name}: {strays} directions belong to another cell");
        // Exact and wrong, the latter as if every cell of a quad had the same probability.
        let (mut expected, mut wrong) = (vec![0.0; bins], vec![0.0; bins]);
        for (i, quad) in quads.quads().iter().enumerate() {
            for place in 0..quad.size.x * quad.size.y {
                let (x, y) = (quad.corner.x + place % quad.size.x, quad.corner.y + place / quad.size.x);
                let share = f64::from(SAMPLES / count + u32::from((i as u32) < SAMPLES % count));
                let pmf = f64::from(quads.cells()[(quad.first + place) as usize].pmf);
                for part in 0..parts * parts {
                    let at = [x / bin[0] * parts + part % parts, y / bin[1] * parts + part / parts];
                    let at = at[1] as usize * columns + at[0] as usize;
                    expected[at] += share * pmf / f64::from(parts * parts);
                    wrong[at] += share / f64::from(quad.size.x * quad.size.y * parts * parts);
                }
            }
        }
        let black: u64 = observed.iter().zip(&expected).filter(|(_, e)| **e == 0.0).map(|(o, _)| o).sum();
        assert!(black < u64::from(SAMPLES) / 500, "{name}: {black} directions in black cells");
        let inside: Vec<u64> =
            observed.iter().zip(&expected).map(|(&o, &e)| if e == 0.0 { 0 } else { o }).collect();
        let p = chi_squared(&inside, &expected);
        assert!(p > sidak(TESTS), "{name}: p = {p}");
        if name == "spots" || name == "rows" {
            assert!(chi_squared(&observed, &wrong) < 1e-6, "{name}: a wrong density is not noticed");
        }
    }
}

/// For every sampler with a probability for each light: densities of the choice, and weights made from them.
#[test]
fn densities_belong_to_the_choice() {
    let device = TestDevice::open();
    let resamples = |s: &LightSampler| matches!(s, LightSampler::Ris | LightSampler::RestirDi);
    for sampler in LightSampler::VALUES.iter().copied().filter(|s| !resamples(s)) {
        let environment = Environment { rotation: 2.0, intensity: 3.0, ..bright_spot(13, 9) };
        let mut scene = Listed::new(&device, environment, sampler);
        densities_integrate_to_the_probability_of_the_quad(&device, &mut scene, sampler.name());
        weights_sum_to_one(&device, &mut scene, sampler.name());
    }
}

/// Over the cells of each quad, the density of the choice integrates to the probability of the quad; the look-up is that of the host; a cell with
/// radiance has a density if its light may be picked at all.
fn densities_integrate_to_the_probability_of_the_quad(device: &TestDevice, scene: &mut Listed, name: &str) {
    let cells = scene.cells(device);
    let range = scene.quads();
    let quads = scene.uploaded.lights.lists().environment_quads.clone().unwrap();
    let width = quads.grid()[0];
    let (mut sums, mut pmfs) = (vec![0.0; quads.quads().len()], vec![0.0; quads.quads().len()]);
    for (i, cell) in (0..).zip(&cells) {
        let expected = quads.find([i % width, i / width]);
        assert_eq!((cell.word != u32::MAX).then(|| (cell.word - range.start) as usize), expected, "cell {i}");
        let Some(quad) = expected else {
            assert_eq!((cell.pdf, cell.radiance.max_element()), (0.0, 0.0), "cell {i}");
            continue;
        };
        sums[quad] += f64::from(cell.pdf) * quads.cell_solid_angle(i / width);
        pmfs[quad] = f64::from(cell.pdf_again);
        let lit = cell.radiance.max_element() > 0.0;
        assert!(!lit || cell.pdf > 0.0 || cell.pdf_again == 0.0, "{name}: cell {i}");
    }
    for (quad, (sum, pmf)) in sums.iter().zip(&pmfs).enumerate() {
        assert!((sum - pmf).abs() <= 1e-4 * pmf, "{name}: quad {quad}: {sum} {pmf}");
    }
    assert!(pmfs.iter().any(|&pmf| pmf > 0.0), "{name}");
}

/// The density of the choice of a light and of a direction on it is that which the other strategy finds for the direction: with a
/// density of the other strategy, the weights of multiple importance sampling sum to 1.
fn weights_sum_to_one(device: &TestDevice, scene: &mut Listed, name: &str) {
    let weight = |pdf: f64, other: f64| if pdf > 0.0 { 1.0 / (1.0 + (other / pdf).powi(2)) } else { 0.0 };
    let range = scene.quads();
    let picks = scene.run(device, PICKS, 10_000);
    let distant: Vec<_> = picks.iter().filter(|p| range.contains(&p.word)).collect();
    assert!(distant.len() > 200, "{name}: {}", distant.len());
    for other in [0.01, 0.3, 4.0] {
        let off = |p: &&&SampleRecord| {
            let (own, found) = (f64::from(p.pdf), f64::from(p.pdf_again));
            (weight(own, other) + weight(other, found) - 1.0).abs() > 1e-5
        };
        let wrong = distant.iter().filter(off).count();
        // A direction on the border of two cells has the density of either.
        assert!(wrong * 200 <= distant.len(), "{name}: {wrong} weights");
    }
}

/// Environments that are black, of one colour, of one texel, without intensity: no light is lost and nothing is no number.
#[test]
fn odd_environments_are_sampled() {
    let device = TestDevice::open();
    let dark = |intensity| Environment { intensity, ..image(32, 16, |_, _| 1.0) };
    let cases = [
        ("black", Environment::black(), 0.0),
        ("no intensity", dark(0.0), 0.0),
        ("constant", Environment::constant(Vec3::ONE), 4.0 * PI),
        ("constant picture", dark(2.0), 8.0 * PI),
        ("one texel", one_texel(), one_texel_flux()),
    ];
    for (name, environment, flux) in cases {
        let mut scene = Listed::new(&device, environment, LightSampler::Power);
        let range = scene.quads();
        let picks = scene.run(&device, PICKS, 40_000);
        let distant = picks.iter().filter(|p| range.contains(&p.word));
        let values: Vec<f64> = distant.map(|p| f64::from(p.radiance.y) / f64::from(p.pdf)).collect();
        assert!(values.iter().all(|v| v.is_finite()), "{name}");
        let n = picks.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|v| v * v).sum::<f64>() / n - mean * mean;
        let error = (variance / n).sqrt();
        assert!((mean - flux).abs() <= 4.0 * error + 1e-3 * flux, "{name}: {mean} +- {error}, not {flux}");
        assert!(error <= 0.05 * flux, "{name}: too noisy to tell: {mean} +- {error}");
        if flux == 0.0 {
            assert!(values.is_empty(), "{name}: {} samples", values.len());
        }
    }
}

/// Integral of the bilinear lookups of [`one_texel`], by midpoints.
fn one_texel_flux() -> f64 {
    const N: u32 = 200;
    let environment = one_texel();
    let mut sum = 0.0;
    for (i, j) in (0..3 * N).flat_map(|j| (0..3 * N).map(move |i| (i, j))) {
        let at = |i: u32, first: f32| first + (i as f32 + 0.5) / N as f32;
        let (u, v) = (at(i, -1.0) / 150.0, at(j, 3.0) / 75.0);
        let radiance = environment.radiance(environment.direction(glam::Vec2::new(u.rem_euclid(1.0), v)));
        sum += f64::from(radiance.y) * (PI * f64::from(v)).sin();
    }
    sum * 2.0 * PI * PI / (150.0 * 75.0) / f64::from(N * N)
}

/// Intensity and rotation are those of the frame that is recorded, in the records and in the densities.
#[test]
fn changes_arrive_in_the_same_frame() {
    let device = TestDevice::open();
    for sampler in [LightSampler::ClusterCdf, LightSampler::LightBvh] {
        let mut changed = Listed::new(&device, bright_spot(13, 9), sampler);
        changed.run(&device, RECORDS, 1);
        for (intensity, rotation) in [(0.0, 1.0), (3.0, 2.0)] {
            let environment = Environment { intensity, rotation, ..bright_spot(13, 9) };
            changed.uploaded.scene.environment = environment.clone();
            let mut fresh = Listed::new(&device, environment, sampler);
            let count = fresh.uploaded.lights.lists().quad_count() as u32;
            let [now, expected] = [&mut changed, &mut fresh].map(|scene| scene.run(&device, RECORDS, count));
            assert_eq!(now, expected, "{}: {intensity} {rotation}", sampler.name());
            assert!(now.iter().all(|record| record.word == LOCAL_ENVIRONMENT));
            assert!(now.iter().all(|r| close(
                r.target,
                glam::DVec3::new(f64::from(rotation).cos(), f64::from(rotation).sin(), intensity.into()),
                1e-6
            )));
            let [now, expected] = [&mut changed, &mut fresh].map(|scene| scene.cells(&device));
            assert_eq!(now, expected, "{}: {intensity} {rotation}", sampler.name());
        }
    }
}
