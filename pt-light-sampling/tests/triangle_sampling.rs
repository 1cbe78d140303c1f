//! lights/triangle_sampling.glsl: samples against their densities and the oracle, estimates against Lambert's formula, noise.

use crate::common::records::{SampleRecord, SamplerPush};
use crate::common::{close, kernels, run_sampler};
use glam::{DVec2, DVec3, Vec3};
use pt_core::rng::random4;
use pt_core::test_support::TestDevice;
use pt_core::test_support::statistics::{SIGNIFICANCE, chi_squared, sidak};
use pt_core::{Buffer, Kernel};
use pt_light_sampling::oracle::triangle::{
    TrianglePoint, sample_triangle_point, triangle_irradiance, triangle_point_pdf, triangle_solid_angle,
};
use pt_shaders::records::AreaSampling;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

const SAMPLES: u32 = 200_000;
const SEED: u32 = 11;
/// Chi-squared tests in this program: kernel and oracle.
const TESTS: usize = 2 * 3 * CASES.len();
/// Largest relative difference of densities: the atan and the power of the driver have 2e-5 each, a point in fp32 the rest.
const PDF_TOLERANCE: f64 = 1e-3;

/// A triangle and its receiver.
#[derive(Clone, Copy)]
struct Case {
    name: &'static str,
    position: Vec3,
    normal: Vec3,
    v0: Vec3,
    e1: Vec3,
    e2: Vec3,
}

const fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

const fn case(name: &'static str, position: Vec3, normal: Vec3, [v0, e1, e2]: [Vec3; 3]) -> Case {
    Case { name, position, normal, v0, e1, e2 }
}

const CASES: [Case; 7] = [
    case("ordinary", v(2.0, -1.0, 0.5), Vec3::Z, [v(2.5, -1.3, 1.5), v(1.2, 0.2, 0.1), v(0.1, 1.0, 0.4)]),
    case("sliver", v(0.0, 0.0, 0.0), Vec3::Z, [v(-1.0, 0.2, 0.8), v(2.0, 0.001, 0.1), v(0.9, 0.003, 0.05)]),
    case(
        "tiny",
        v(1.0, 2.0, 3.0),
        v(0.0, 0.6, 0.8),
        [v(1.5, 2.3, 3.81), v(1e-4, 2e-5, 0.0), v(0.0, 1e-4, -3e-5)],
    ),
    case(
        "near",
        v(0.1, 0.2, 0.3),
        v(0.0, 0.28, 0.96),
        [v(-1.1, -1.2, 0.301), v(3.0, 0.2, 0.0), v(0.1, 3.0, 0.0)],
    ),
    case(
        "close",
        v(0.1, 0.2, 0.3),
        v(0.0, 0.28, 0.96),
        [v(-1.1, -1.2, 0.4), v(3.0, 0.2, 0.0), v(0.1, 3.0, 0.0)],
    ),
    case("horizon", v(0.0, 0.0, 0.0), Vec3::Z, [v(1.0, -1.0, -0.5), v(0.2, 2.0, 0.3), v(-0.5, 1.2, 1.9)]),
    case("nadir", v(0.0, 0.0, 0.0), Vec3::Z, [v(-1.0, -1.2, 0.8), v(2.5, 0.3, 0.2), v(0.4, 2.6, -0.1)]),
];

impl Case {
    /// First corner relative to the shading point, edges.
    fn relative(&self) -> [DVec3; 3] {
        [self.v0.as_dvec3() - self.position.as_dvec3(), self.e1.as_dvec3(), self.e2.as_dvec3()]
    }

    fn corners_from(&self, position: Vec3) -> [DVec3; 3] {
        let a = self.v0.as_dvec3() - position.as_dvec3();
        [a, a + self.e1.as_dvec3(), a + self.e2.as_dvec3()]
    }

    fn at(&self, b: DVec2) -> DVec3 {
        let [a, e1, e2] = self.relative();
        a + b.x * e1 + b.y * e2
    }

    /// Six times the volume between triangle and shading point: points at distance d have `volume / d^3` solid angle per unit of
    /// barycentrics.
    fn volume(&self) -> f64 {
        let [a, e1, e2] = self.relative();
        a.dot(e1.cross(e2)).abs()
    }

    fn pdf(&self, method: AreaSampling, point: DVec3) -> f64 {
        let ([_, e1, e2], position) = (self.relative(), self.position.as_dvec3());
        let normal = self.normal.as_dvec3();
        triangle_point_pdf(method, position, normal, self.v0.as_dvec3(), [e1, e2], position + point)
    }

    fn sample(&self, method: AreaSampling, position: Vec3, xi: [f32; 4]) -> Option<TrianglePoint> {
        let edges = [self.e1.as_dvec3(), self.e2.as_dvec3()];
        let xi = DVec2::new(f64::from(xi[0]), f64::from(xi[1]));
        let (normal, v0) = (self.normal.as_dvec3(), self.v0.as_dvec3());
        sample_triangle_point(method, position.as_dvec3(), normal, v0, edges, xi)
    }

    fn irradiance(&self, position: Vec3) -> f64 {
        triangle_irradiance(self.normal.as_dvec3(), self.corners_from(position))
    }

    /// Samples of the kernel, from shading points in a cube.
    fn draw(&self, device: &TestDevice, method: AreaSampling, cube: f32, count: u32) -> Vec<SampleRecord> {
        let constants = [("method", method.code().into())];
        let kernel = Kernel::compute::<SamplerPush>(device, &kernels::TRIANGLE_POINTS, &constants).unwrap();
        let vectors = [self.normal, self.v0, self.e1, self.e2];
        let buffer = Buffer::from_slice(device, "triangle", &vectors).unwrap();
        let push = SamplerPush { family: 0, count, seed: SEED, parameter: cube, vector: self.position };
        run_sampler(device, &kernel, &push, None, |pass| pass.read("triangle", &buffer))
    }

    fn chart(&self, method: AreaSampling) -> Chart<'_> {
        Chart { case: self, method, sphere: self.name == "near" && method != AreaSampling::Uniform }
    }
}

/// Where points lie in the unit square, and the density there. Densities that peak at the foot of the perpendicular take directions
/// round it, all others the triangle itself.
struct Chart<'a> {
    case: &'a Case,
    method: AreaSampling,
    sphere: bool,
}

impl Chart<'_> {
    fn foot(&self) -> DVec3 {
        let [a, e1, e2] = self.case.relative();
        let n = e1.cross(e2).normalize();
        n * a.dot(n).signum()
    }

    fn place(&self, barycentrics: DVec2, direction: DVec3) -> DVec2 {
        if !self.sphere {
            return DVec2::new(barycentrics.x / (1.0 - barycentrics.y).max(1e-9), barycentrics.y);
        }
        let frame = pt_light_sampling::oracle::sampling::basis_around(self.foot());
        let local = frame.transpose() * direction;
        DVec2::new((local.y.atan2(local.x) / TAU).rem_euclid(1.0), 1.0 - local.z)
    }

    fn density(&self, p: DVec2) -> f64 {
        if !self.sphere {
            let point = self.case.at(DVec2::new(p.x * (1.0 - p.y), p.y));
            let solid_angle = self.case.volume() / point.length().powi(3);
            return self.case.pdf(self.method, point) * solid_angle * (1.0 - p.y);
        }
        let (cos, phi) = (1.0 - p.y, TAU * p.x);
        let sin = (1.0 - cos * cos).sqrt();
        let frame = pt_light_sampling::oracle::sampling::basis_around(self.foot());
        let direction = frame * DVec3::new(sin * phi.cos(), sin * phi.sin(), cos);
        let [a, e1, e2] = self.case.relative();
        let n = e1.cross(e2);
        let d = direction * (a.dot(n) / direction.dot(n)) - a;
        let b = DVec2::new(d.cross(e2).dot(n), e1.cross(d).dot(n)) / n.length_squared();
        if b.min_element() < 0.0 || b.element_sum() > 1.0 {
            return 0.0;
        }
        TAU * self.case.pdf(self.method, a + d)
    }

    /// p-values of the places with the right density, and with one that is 10 % too high on one half and too low on the other.
    fn p_values(&self, places: &[DVec2]) -> [f64; 2] {
        const N: usize = 12;
        /// Midpoints per bin and axis.
        const Q: usize = 24;
        let mut observed = vec![0; N * N];
        for p in places {
            let cell = [p.x, p.y].map(|c| ((c.max(0.0) * N as f64) as usize).min(N - 1));
            observed[cell[1] * N + cell[0]] += 1;
        }
        let step = 1.0 / (N * Q) as f64;
        let expected: Vec<f64> = (0..N * N)
            .map(|bin| {
                let corner = DVec2::new((bin % N * Q) as f64, (bin / N * Q) as f64) + 0.5;
                let points = (0..Q * Q).map(|i| corner + DVec2::new((i % Q) as f64, (i / Q) as f64));
                points.map(|p| self.density(p * step)).sum::<f64>() * step * step * places.len() as f64
            })
            .collect();
        let whole = expected.iter().sum::<f64>() / places.len() as f64;
        assert!((whole - 1.0).abs() < 2e-3, "{}: the density integrates to {whole}", self.case.name);
        let tilt = |(bin, e): (usize, &f64)| e * if 2 * (bin % N) < N { 1.1 } else { 0.9 };
        let tilted: Vec<f64> = expected.iter().enumerate().map(tilt).collect();
        [chi_squared(&observed, &expected), chi_squared(&observed, &tilted)]
    }

    fn check(&self, who: &str, places: &[DVec2]) {
        let [p, tilted] = self.p_values(places);
        let name = format!("{who}, {}, {}", self.case.name, self.method.name());
        assert!(p > sidak(TESTS), "{name}: p = {p}");
        assert!(tilted < SIGNIFICANCE, "{name}: a wrong density is not noticed, p = {tilted}");
    }
}

fn barycentrics(sample: &SampleRecord) -> DVec2 {
    sample.radiance.as_dvec3().truncate()
}

#[test]
fn samples_follow_the_density() {
    let device = TestDevice::open();
    for case in &CASES {
        for method in AreaSampling::ALL {
            let samples = case.draw(&device, method, 0.0, SAMPLES);
            let chart = case.chart(method);
            let places: Vec<DVec2> =
                samples.iter().map(|s| chart.place(barycentrics(s), s.value.as_dvec3())).collect();
            chart.check("kernel", &places);
        }
    }
}

#[test]
fn oracle_follows_the_density() {
    for case in &CASES {
        for method in AreaSampling::ALL {
            let chart = case.chart(method);
            let points = (0..20_000).map(|i| case.sample(method, case.position, random4([i, 0], 0, 0, SEED)));
            let places: Vec<DVec2> =
                points.flatten().map(|p| chart.place(p.barycentrics, p.direction)).collect();
            assert_eq!(places.len(), 20_000);
            chart.check("oracle", &places);
        }
    }
}

/// Sample, its density and the density of its point.
#[test]
fn kernel_equals_the_oracle() {
    let device = TestDevice::open();
    for case in &CASES {
        for method in AreaSampling::ALL {
            let (mut worst_again, mut worst_pdf, mut worst_point) = (0.0f64, 0.0f64, 0.0f64);
            for (i, s) in case.draw(&device, method, 0.0, 4000).iter().enumerate() {
                let name = format!("{}, {}, {i}: {s:?}", case.name, method.name());
                let b = barycentrics(s);
                assert!(b.min_element() >= 0.0 && b.element_sum() <= 1.0 + 1e-6, "{name}");
                let on_triangle = case.at(b);
                let reached = s.value.as_dvec3() * f64::from(s.radiance.z);
                // A sum of a corner and shares of the edges.
                let rounding = 2e-7 * case.relative().map(DVec3::length).iter().sum::<f64>();
                assert!((reached - on_triangle).length() < rounding, "{name}");
                let again = f64::from(s.pdf_again) / f64::from(s.pdf) - 1.0;
                let pdf = f64::from(s.pdf) / case.pdf(method, on_triangle) - 1.0;
                worst_again = worst_again.max(again.abs());
                worst_pdf = worst_pdf.max(pdf.abs());
                let expected =
                    case.sample(method, case.position, random4([i as u32, 0], 0, 0, SEED)).unwrap();
                worst_point = worst_point.max((b - expected.barycentrics).length());
                // A point 1e-3 above the plane sees distant parts under angles of 1e-3: there a rounding is a step.
                let point = if case.name == "near" { 2e-2 } else { 1e-3 };
                assert!((b - expected.barycentrics).length() < point, "{name} instead of {expected:?}");
                assert!(close(s.value, expected.direction, 1e-3), "{name} instead of {expected:?}");
            }
            println!(
                "{:9} {:9} pdf again {worst_again:.1e}, pdf {worst_pdf:.1e}, point {worst_point:.1e}",
                case.name,
                method.name()
            );
            assert!(worst_again < PDF_TOLERANCE && worst_pdf < PDF_TOLERANCE, "{} {method:?}", case.name);
        }
    }
}

/// Mean, standard error of the mean and relative standard deviation.
fn statistics(values: impl Iterator<Item = f64>) -> (f64, f64, f64) {
    let (mut n, mut mean, mut squares) = (0.0, 0.0, 0.0);
    for value in values {
        n += 1.0;
        let d = value - mean;
        mean += d / n;
        squares += d * (value - mean);
    }
    let deviation = (squares / n).sqrt();
    (mean, deviation / n.sqrt(), deviation / mean)
}

/// Irradiance from constant radiance by every method.
#[test]
fn estimates_equal_lamberts_formula() {
    let device = TestDevice::open();
    for case in &CASES {
        let exact = case.irradiance(case.position);
        let mut noise = Vec::new();
        for method in AreaSampling::ALL {
            let samples = case.draw(&device, method, 0.0, SAMPLES);
            let cos = |s: &SampleRecord| s.value.dot(case.normal).max(0.0);
            let (mean, error, relative) = statistics(samples.iter().map(|s| f64::from(cos(s) / s.pdf)));
            let name = format!("{}, {}", case.name, method.name());
            println!("{name:22} exact {exact:.6e}, mean {mean:.6e} +- {error:.1e}, noise {relative:.4}");
            // Of points that are uniform in area, one in a million falls where most light comes from: no number of samples here shows the mean.
            let found = case.name != "near" || method != AreaSampling::Uniform;
            let equal = (mean - exact).abs() < 4.0 * error + 1e-4 * exact;
            assert!(equal || !found, "{name}: {mean}, not {exact}");
            noise.push(relative);
        }
        let [uniform, spherical, projected] = noise[..] else { unreachable!("three methods") };
        // The sliver spans 100 degrees in one direction, and round the nadir the cosine is flat: there a linear function cannot gain.
        let gain = if matches!(case.name, "sliver" | "nadir") { 1.2 } else { 1.0 };
        assert!(spherical < uniform, "{}: {noise:?}", case.name);
        assert!(projected < gain * spherical, "{}: {noise:?}", case.name);
        // Of the wrong method's density the estimate is wrong.
        let samples = case.draw(&device, AreaSampling::Spherical, 0.0, SAMPLES);
        let of = |s: &SampleRecord| {
            let pdf = case.pdf(AreaSampling::Uniform, s.value.as_dvec3() * f64::from(s.radiance.z));
            f64::from(s.value.dot(case.normal).max(0.0)) / pdf
        };
        let (mean, error, _) = statistics(samples.iter().map(of));
        let noticed = (mean - exact).abs() > 4.0 * error + 1e-4 * exact;
        assert!(noticed || case.name == "tiny", "{}: a wrong density is not noticed", case.name);
    }
}

/// Solid angle as the excess of the angles, in fp32.
fn classic_solid_angle(corners: [DVec3; 3]) -> f64 {
    let [a, b, c] = corners.map(|corner| corner.as_vec3().normalize());
    let [ab, bc, ca] = [a.cross(b), b.cross(c), c.cross(a)].map(Vec3::normalize);
    let angle = |n0: Vec3, n1: Vec3| (-n0.dot(n1)).clamp(-1.0, 1.0).acos();
    f64::from(angle(ca, ab) + angle(ab, bc) + angle(bc, ca) - std::f32::consts::PI)
}

/// A small triangle of constant radiance gives nearly the same light wherever it is sampled: what varies from sample to sample is rounding.
#[test]
fn tiny_triangles_are_not_noisy() {
    const BAR: f64 = 1e-2;
    let device = TestDevice::open();
    for size in [1e-3, 1e-4, 1e-5, 1e-6] {
        let edges = [size * v(1.0, 0.2, 0.0), size * v(0.0, 1.0, -0.3)];
        let tiny =
            case("tiny", v(3.0, 1.0, -2.0), v(0.0, 0.6, 0.8), [v(3.5, 1.3, -1.19), edges[0], edges[1]]);
        for method in AreaSampling::ALL {
            let samples = tiny.draw(&device, method, 0.1, 20_000);
            let of =
                |s: &SampleRecord| f64::from(s.value.dot(tiny.normal) / s.pdf) / tiny.irradiance(s.target);
            let (mean, _, noise) = statistics(samples.iter().map(of));
            println!("{size:e} {:9}: mean {mean:.6}, noise {noise:.1e}", method.name());
            assert!(noise < BAR && (mean - 1.0).abs() < BAR, "{size} {}: {mean} {noise}", method.name());
            let angle = |s: &SampleRecord| {
                let [a, b, c] = tiny.corners_from(s.target);
                (
                    f64::from(f32::from_bits(s.word)),
                    classic_solid_angle([a, b, c]),
                    triangle_solid_angle(a, b, c),
                )
            };
            // The corners are given in fp32: the bar is for triangles that these resolve.
            let (mean, _, noise) = statistics(samples.iter().map(|s| angle(s).0 / angle(s).2));
            assert!(
                size < 1e-4 || noise < BAR && (mean - 1.0).abs() < BAR,
                "{size}: solid angle {mean} {noise}"
            );
            let (mean, _, noise) = statistics(samples.iter().map(|s| angle(s).1 / angle(s).2));
            assert!(
                noise.abs() > BAR,
                "{size}: the bar does not notice the classic solid angle, {mean} {noise}"
            );
        }
    }
}

/// Triangles that are not seen have no sample; a triangle below the horizon has none that is drawn for the cosine.
#[test]
fn unseen_triangles_have_no_sample() {
    let device = TestDevice::open();
    let ordinary = &CASES[0];
    let degenerate = |name, triangle| case(name, ordinary.position, ordinary.normal, triangle);
    let (v0, e1, e2) = (ordinary.v0, ordinary.e1, ordinary.e2);
    for unseen in [
        degenerate("no area", [v0, Vec3::X, 2.0 * Vec3::X]),
        degenerate("one point", [v0, Vec3::ZERO, Vec3::ZERO]),
        degenerate("edge-on", [ordinary.position + Vec3::X, Vec3::X, Vec3::Y]),
        degenerate("at a corner", [ordinary.position, e1, e2]),
    ] {
        for method in AreaSampling::ALL {
            for s in unseen.draw(&device, method, 0.0, 64) {
                assert_eq!((s.pdf, s.pdf_again), (0.0, 0.0), "{} {}: {s:?}", unseen.name, method.name());
                assert!(s.value.is_finite(), "{} {}: {s:?}", unseen.name, method.name());
            }
        }
    }
    let below = Case { normal: -Vec3::Z, ..*ordinary };
    for method in AreaSampling::ALL {
        for s in below.draw(&device, method, 0.0, 64) {
            let sampled = method != AreaSampling::Projected;
            assert_eq!((s.pdf > 0.0, s.pdf_again > 0.0), (sampled, sampled), "{}: {s:?}", method.name());
        }
    }
}

/// An octant, and what the horizon leaves of triangles that reach below it.
#[test]
fn closed_forms_of_the_oracle() {
    let near = |actual: f64, expected: f64| assert!((actual - expected).abs() < 1e-12, "{actual} {expected}");
    let octant = [DVec3::X, DVec3::Y, DVec3::Z];
    near(triangle_solid_angle(DVec3::X, DVec3::Y, DVec3::Z), FRAC_PI_2);
    near(triangle_irradiance(DVec3::Z, octant), FRAC_PI_4);
    near(triangle_irradiance(-DVec3::Z, octant), 0.0);
    // It touches the horizon with an edge.
    near(triangle_irradiance(DVec3::Z, [DVec3::X, DVec3::Y, DVec3::new(1e-9, 1e-9, -1.0)]), 0.0);
    let tilted = DVec3::new(0.0, 1.0, 1.0).normalize();
    // The octant seen by a receiver that is turned by 45 degrees: by symmetry the projections on y and z add up.
    near(triangle_irradiance(tilted, octant), 2.0 * FRAC_PI_4 * 0.5f64.sqrt());
    // Half of a tent across the horizon.
    let tent = [DVec3::X, DVec3::new(0.0, 1.0, 1.0), DVec3::new(0.0, 1.0, -1.0)];
    let upper = [DVec3::X, DVec3::new(0.0, 1.0, 1.0), DVec3::Y];
    near(triangle_irradiance(DVec3::Z, tent), triangle_irradiance(DVec3::Z, upper));
    near(triangle_irradiance(DVec3::Z, upper), 0.5 * FRAC_PI_2 * (1.0 - FRAC_PI_4.cos()));
}
