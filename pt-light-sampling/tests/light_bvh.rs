//! The light tree: kernel against oracle, picks against the pmf, no light lost, variance below that of picks by power.

use crate::common::kernels;
use crate::common::lights::{Hall, direction, numbers};
use crate::common::records::{LightBvhPush, SampleRecord};
use glam::Vec3;
use pt_core::rng::pcg4d;
use pt_core::test_support::TestDevice;
use pt_core::test_support::statistics::{SIGNIFICANCE, chi_squared, sidak};
use pt_core::{Buffer, Kernel, Location, Recorder};
use pt_light_sampling::oracle::light_bvh::{LightBvhPoint, light_bvh_pick, light_bvh_pmf, light_bvh_pmfs};
use pt_light_sampling::{LightBounds, LightBvh};
use pt_scene::Bounds;
use pt_shaders::records::NONE;

/// Chi-squared tests in this program: the cases on device and host.
const TESTS: usize = 2 * 2 * 4 * 2;
const PICKS: u32 = 200_000;

#[derive(Clone, Copy)]
struct Point {
    position: Vec3,
    normal: Vec3,
    view: Vec3,
    roughness: f32,
}

impl Point {
    fn random(i: u32) -> Self {
        let normal = direction(i, 21);
        let view = (normal + 0.9 * direction(i, 22)).normalize();
        Self { position: Hall::place(i, 20), normal, view, roughness: numbers(i, 23)[0] }
    }

    fn oracle(&self, gaussian: bool) -> LightBvhPoint {
        LightBvhPoint::new(self.position, self.normal, self.view, self.roughness, gaussian)
    }
}

/// A tree on the device.
struct Uploaded<'a> {
    device: &'a TestDevice,
    kernel: Kernel,
    nodes: Buffer,
    trails: Buffer,
}

impl<'a> Uploaded<'a> {
    fn new(device: &'a TestDevice, bvh: &LightBvh) -> Self {
        Self {
            device,
            kernel: Kernel::compute::<LightBvhPush>(device, &kernels::LIGHT_BVH, &[]).unwrap(),
            nodes: Buffer::from_slice(device, "light bvh", bvh.nodes()).unwrap(),
            trails: Buffer::from_slice(device, "light trails", bvh.trails()).unwrap(),
        }
    }

    fn run(&self, point: &Point, gaussian: bool, picks: bool, count: u32) -> Vec<SampleRecord> {
        let push = LightBvhPush {
            nodes: self.nodes.address(),
            trails: self.trails.address(),
            position: point.position,
            roughness: point.roughness,
            normal: point.normal,
            count,
            view: point.view,
            seed: 5,
            gaussian: gaussian.into(),
            picks: picks.into(),
        };
        let size = u64::from(count) * size_of::<SampleRecord>() as u64;
        let samples = Buffer::new(self.device, "samples", size, Location::Device).unwrap();
        let mut recorder = Recorder::new(self.device).unwrap();
        let mut frame = recorder.begin().unwrap();
        let pass = frame.pass("light bvh", &self.kernel).write("samples", &samples).push(&push);
        pass.addresses(&self.nodes).addresses(&self.trails).dispatch([count, 1, 1]).unwrap();
        frame.submit().unwrap();
        samples.read().unwrap()
    }
}

fn bits(i: u32) -> [u32; 2] {
    let [x, y, ..] = pcg4d([i, 0, 0, 5]);
    [x, y]
}

fn point_light(position: Vec3, power: f32) -> LightBounds {
    LightBounds {
        bounds: Bounds { min: position, max: position },
        axis: Vec3::Y,
        cos_spread: -1.0,
        cos_emission: 0.0,
        power,
        irradiance: 0.0,
    }
}

/// Two lights, fifty in one place that shine in different directions, 600 of all kinds, 20,000.
fn cases() -> Vec<Vec<LightBounds>> {
    let two = vec![point_light(Vec3::new(3.0, 4.0, 2.0), 1.0), point_light(Vec3::new(9.0, 1.0, 7.0), 5.0)];
    let coincident = (0..50).map(|i| LightBounds {
        axis: direction(i, 30),
        cos_spread: 1.0,
        ..point_light(Vec3::new(10.0, 2.5, 10.0), 1.0 + (i % 5) as f32)
    });
    let many = (0..20_000).map(|i| point_light(Hall::place(i, 31), 0.01 + numbers(i, 32)[0]));
    vec![two, coincident.collect(), Hall::new(200).lights, many.collect()]
}

/// Counts of picks of each light, and of none at the end.
fn histogram(picks: impl IntoIterator<Item = Option<u32>>, lights: usize) -> Vec<u64> {
    let mut counts = vec![0; lights + 1];
    picks.into_iter().for_each(|light| counts[light.map_or(lights, |light| light as usize)] += 1);
    counts
}

/// Passes with the right pmf; fails if a fifth is taken from the likelier lights.
fn check(name: &str, observed: &[u64], pmf: &[f64]) {
    let expected: Vec<f64> = pmf.iter().map(|p| p * f64::from(PICKS)).collect();
    let p = chi_squared(observed, &expected);
    assert!(p > sidak(TESTS), "{name}: p = {p}");
    let bins = expected.iter().filter(|e| **e > 0.0).count() as f64;
    let middle = f64::from(PICKS) / bins;
    let wrong: Vec<f64> = expected.iter().map(|&e| if e > middle { 0.8 * e } else { e }).collect();
    let scale = f64::from(PICKS) / wrong.iter().sum::<f64>();
    let wrong: Vec<f64> = wrong.iter().map(|e| e * scale).collect();
    assert!(chi_squared(observed, &wrong) < SIGNIFICANCE, "{name}: a wrong pmf is not noticed");
}

/// A place that all lights of every case but a few can reach, and one with many lights behind it.
fn points() -> [Point; 2] {
    let view = Vec3::new(0.6, 0.8, 0.0);
    [
        Point { position: Vec3::new(8.0, -1.0, 9.0), normal: Vec3::Y, view, roughness: 0.4 },
        Point { position: Vec3::new(12.0, 2.0, 6.0), normal: Vec3::new(0.0, 0.6, 0.8), view, roughness: 0.8 },
    ]
}

#[test]
fn picks_follow_the_pmf() {
    let device = TestDevice::open();
    let mut lost: f64 = 0.0;
    for (case, lights) in cases().iter().enumerate() {
        let bvh = LightBvh::new(lights).unwrap();
        let uploaded = Uploaded::new(&device, &bvh);
        for (place, point) in points().iter().enumerate() {
            for gaussian in [false, true] {
                let name = format!("case {case}, point {place}, Gaussians {gaussian}");
                let oracle = point.oracle(gaussian);
                let (pmfs, none) = light_bvh_pmfs(&bvh, &oracle);
                let sum = pmfs.iter().sum::<f64>() + none;
                assert!((sum - 1.0).abs() < 1e-9, "{name}: {sum}");
                lost = lost.max(none);
                for (light, &pmf) in (0..).zip(&pmfs).step_by(1 + pmfs.len() / 500) {
                    assert_eq!(light_bvh_pmf(&bvh, &oracle, light), pmf, "{name}: light {light}");
                }
                let with_none: Vec<f64> = pmfs.iter().copied().chain([none]).collect();

                // A single light that may contribute leaves nothing to choose.
                let choice = pmfs.iter().filter(|p| **p > 1e-3 / pmfs.len() as f64).count() > 1;
                let picks = (0..PICKS).map(|i| {
                    let (light, pmf) = light_bvh_pick(&bvh, &oracle, bits(i))?;
                    assert_eq!(pmf, pmfs[light as usize], "{name}: light {light}");
                    Some(light)
                });
                let observed = histogram(picks, lights.len());
                if choice {
                    check(&format!("{name}, oracle"), &observed, &with_none);
                }

                let kernel = uploaded.run(point, gaussian, false, lights.len() as u32);
                let mut sum = none;
                for (light, (record, &pmf)) in kernel.iter().zip(&pmfs).enumerate() {
                    let actual = f64::from(record.pdf_again);
                    // Single precision, over up to 20 branches; near the horizon the cosine is a small difference.
                    assert!(
                        (actual - pmf).abs() <= 2e-3 * (pmf + 0.01 / pmfs.len() as f64),
                        "{name}, light {light}: {actual} for {pmf}"
                    );
                    sum += actual;
                }
                assert!((sum - 1.0).abs() < 1e-4, "{name}: the kernel's pmf sums to {sum}");
                let samples = uploaded.run(point, gaussian, true, PICKS);
                for sample in &samples {
                    assert_eq!(sample.pdf > 0.0, sample.word != NONE, "{name}: {sample:?}");
                    assert!((sample.pdf - sample.pdf_again).abs() <= 1e-5 * sample.pdf, "{name}: {sample:?}");
                }
                let same = (0..PICKS).zip(&samples).filter(|(i, sample)| {
                    light_bvh_pick(&bvh, &oracle, bits(*i)).map_or(NONE, |(light, _)| light) == sample.word
                });
                let same = same.count();
                // Single precision: a pick near a cut of one of up to 20 branches may fall on its other side.
                assert!(
                    same as f64 > 0.998 * f64::from(PICKS),
                    "{name}: {same} picks are those of the oracle"
                );
                let picks = samples.iter().map(|s| (s.word != NONE).then_some(s.word));
                if choice {
                    check(&format!("{name}, kernel"), &histogram(picks, lights.len()), &with_none);
                }
            }
        }
    }
    println!("picks without a light: at most {lost:.4}");
}

/// A light with a pmf of 0 gives no light, from random points; most of those without light have a pmf of 0.
#[test]
fn no_contribution_without_probability() {
    let device = TestDevice::open();
    let hall = Hall::new(150);
    let bvh = LightBvh::new(&hall.lights).unwrap();
    let uploaded = Uploaded::new(&device, &bvh);
    let (mut lit, mut dark, mut zero) = (0, 0, 0);
    for i in 0..120 {
        let point = Point::random(i);
        for gaussian in [false, true] {
            let (oracle, _) = light_bvh_pmfs(&bvh, &point.oracle(gaussian));
            let kernel = uploaded.run(&point, gaussian, false, hall.lights.len() as u32);
            for (light, (pmf, record)) in oracle.iter().zip(&kernel).enumerate() {
                let (irradiance, facing) = hall.irradiance(light, point.position, point.normal);
                // Cosines whose product rounding may take away count as 0.
                if irradiance > 1e-6 * facing {
                    assert!(
                        *pmf > 0.0 && record.pdf_again > 0.0,
                        "point {i}, light {light}: {irradiance} of {facing}"
                    );
                    lit += 1;
                } else {
                    dark += 1;
                    zero += usize::from(*pmf == 0.0);
                }
            }
        }
    }
    assert!(lit > 10_000 && zero > dark / 2, "{lit} lit, {dark} dark, {zero} of these have no probability");
}

/// Lights so weak that the first word of random bits can't tell them apart: the second word does.
#[test]
fn weak_lights_are_reached() {
    let at = Vec3::new(1.0, 0.0, 0.0);
    let powers = [1.0, 1e-9, 1e-18, 1e-18];
    let lights: Vec<LightBounds> =
        (0..4).zip(powers).map(|(i, power)| point_light(at + 0.001 * i as f32 * Vec3::Y, power)).collect();
    let bvh = LightBvh::new(&lights).unwrap();
    let point = Point { position: Vec3::ZERO, normal: Vec3::X, view: Vec3::X, roughness: 1.0 }.oracle(false);
    let pmfs: Vec<f64> = (0..4).map(|light| light_bvh_pmf(&bvh, &point, light)).collect();
    // Less than 2^-32, the least that one word can give.
    assert!(pmfs[2] > 0.0 && pmfs[2] < 1e-13 && (pmfs.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{pmfs:?}");
    // Bits that lead to the weakest two lie at ends of the ranges; they use up all but the last byte of the second word.
    let words = (0..16).flat_map(|k: u32| [k, !k]);
    let mut starts = words.flat_map(|word| [[word, 0], [word, 0xff_ffff]]);
    let start = starts.find(|start| matches!(light_bvh_pick(&bvh, &point, *start), Some((2 | 3, _))));
    let [word, low] = start.expect("the weak lights lie at ends of their ranges");
    let picks = (0..256).map(|byte| light_bvh_pick(&bvh, &point, [word, byte << 24 | low]).map(|p| p.0));
    let counts = histogram(picks, 4);
    assert_eq!(counts[2] + counts[3], 256, "{counts:?}");
    assert!(counts[2].abs_diff(counts[3]) <= 2, "{counts:?}: equal lights are picked alike");
}

/// Variance of picks from the light tree against that of picks by power: the estimate of the unshadowed irradiance has
/// E[x^2] = sum of irradiance^2 / pmf.
#[test]
fn variance_is_below_that_of_power() {
    let hall = Hall::new(334);
    let bvh = LightBvh::new(&hall.lights).unwrap();
    let total: f64 = hall.lights.iter().map(|light| f64::from(light.power)).sum();
    let points = 200;
    let mut relative = [0.0; 3];
    for i in 0..points {
        let point = Point { roughness: 1.0, ..Point::random(i) };
        let by_power: Vec<f64> = hall.lights.iter().map(|light| f64::from(light.power) / total).collect();
        let irradiance: Vec<f64> = (0..hall.lights.len())
            .map(|light| hall.irradiance(light, point.position, point.normal).0)
            .collect();
        let mean: f64 = irradiance.iter().sum();
        let pmfs = [
            by_power,
            light_bvh_pmfs(&bvh, &point.oracle(false)).0,
            light_bvh_pmfs(&bvh, &point.oracle(true)).0,
        ];
        for (sum, pmf) in relative.iter_mut().zip(&pmfs) {
            let squares: f64 = irradiance
                .iter()
                .zip(pmf)
                .filter(|(e, _)| **e > 0.0)
                .map(|(e, p)| e * e / p.max(1e-300))
                .sum();
            *sum += (squares / (mean * mean) - 1.0) / f64::from(points);
        }
    }
    let [power, bounds, gaussian] = relative;
    println!(
        "relative variance: power {power:.2}, bounds {bounds:.2} (1/{:.1}), Gaussians {gaussian:.2} (1/{:.1})",
        power / bounds,
        power / gaussian
    );
    assert!(bounds < power / 8.0 && gaussian < power / 40.0, "{relative:?}");
}
