//! sampling.glsl and brdf.glsl: samples against their densities, kernels against the oracle, energy.

use crate::common::records::{BrdfCase, SampleRecord, SamplerPush};
use crate::common::{close, kernels, run_sampler};
use glam::{DVec2, DVec3, Vec3, Vec4};
use pt_core::rng::random4;
use pt_core::test_support::TestDevice;
use pt_core::test_support::statistics::{SIGNIFICANCE, chi_squared, sidak};
use pt_core::{Buffer, Kernel};
use pt_light_sampling::oracle::brdf::Brdf;
use pt_light_sampling::oracle::sampling;
use std::f64::consts::{PI, TAU};

const SAMPLES: u32 = 200_000;
/// Chi-squared tests of samplers in this program.
const TESTS: usize = 4 + INCIDENCES.len() * ALPHAS.len();
/// Cosines between view direction and normal, the last one grazing.
const INCIDENCES: [f32; 3] = [1.0, 0.6, 0.02];
/// GGX alpha: nearly a mirror to fully rough.
const ALPHAS: [f32; 4] = [0.01, 0.09, 0.4, 1.0];
const CONE: f32 = 0.1;

fn draw(
    device: &TestDevice,
    kernel: &Kernel,
    family: u32,
    parameter: f32,
    vector: Vec3,
) -> Vec<SampleRecord> {
    let push = SamplerPush { family, count: SAMPLES, seed: 1 + family, parameter, vector };
    run_sampler(device, kernel, &push, None, |pass| pass)
}

/// A 2D region in which samples are binned: where a sample lies in [0, 1]^2, and the density there per unit of it.
struct Chart<'a> {
    place: &'a dyn Fn(DVec3) -> DVec2,
    density: &'a dyn Fn(DVec2) -> f64,
}

/// p-value of the samples' places. Samples for which `counts` is false are left out on both sides.
fn p_value(samples: &[SampleRecord], chart: &Chart<'_>, counts: impl Fn(DVec3) -> bool) -> f64 {
    const N: usize = 24;
    /// Midpoints per bin and axis.
    const Q: usize = 24;
    let mut observed = vec![0; N * N + 1];
    for sample in samples {
        let value = sample.value.as_dvec3();
        if counts(value) {
            let p = (chart.place)(value) * N as f64;
            let cell = [p.x, p.y].map(|c| (c.max(0.0) as usize).min(N - 1));
            observed[cell[1] * N + cell[0]] += 1;
        } else {
            observed[N * N] += 1;
        }
    }
    let step = 1.0 / (N * Q) as f64;
    let mut expected: Vec<f64> = (0..N * N)
        .map(|bin| {
            let corner = DVec2::new((bin % N * Q) as f64, (bin / N * Q) as f64);
            let points = (0..Q * Q).map(|i| corner + DVec2::new((i % Q) as f64 + 0.5, (i / Q) as f64 + 0.5));
            let mean = points.map(|p| (chart.density)(p * step)).sum::<f64>() * step * step;
            // Where the horizon cuts off a corner of a bin, midpoints may all miss it.
            (mean * samples.len() as f64).max(1e-6)
        })
        .collect();
    // What is left of one: samples that lie outside of the chart.
    let rest = samples.len() as f64 - expected.iter().sum::<f64>();
    let outside = observed[N * N] as f64;
    assert!(rest > -0.002 * samples.len() as f64, "the density integrates to more than one: {rest}");
    if outside == 0.0 {
        assert!(rest < 0.002 * samples.len() as f64, "the density integrates to less than one: {rest}");
        observed.pop();
    } else {
        expected.push(rest.max(1e-9));
    }
    chi_squared(&observed, &expected)
}

/// Passes with the right density; fails with one that is off by 10 % somewhere: a test of the test.
fn check(name: &str, samples: &[SampleRecord], chart: &Chart<'_>, counts: impl Fn(DVec3) -> bool + Copy) {
    let p = p_value(samples, chart, counts);
    assert!(p > sidak(TESTS), "{name}: p = {p}");
    let tilted = |at: DVec2| (chart.density)(at) * if at.x < 0.5 { 1.1 } else { 0.9 };
    let broken = Chart { density: &tilted, ..*chart };
    assert!(
        std::panic::catch_unwind(std::panic::AssertUnwindSafe(
            || p_value(samples, &broken, counts) < SIGNIFICANCE
        ))
        .unwrap_or(true),
        "{name}: a wrong density is not noticed"
    );
}

fn everywhere(_: DVec3) -> bool {
    true
}

fn azimuth(v: DVec3) -> f64 {
    (v.y.atan2(v.x) / TAU).rem_euclid(1.0)
}

#[test]
fn points_on_triangle_and_disk() {
    let device = TestDevice::open();
    let kernel = Kernel::compute::<SamplerPush>(&device, &kernels::SAMPLERS, &[]).unwrap();
    // The triangle's uniform density as one over the square: b2 = y, b1 = x (1 - y).
    let triangle = draw(&device, &kernel, 0, 0.0, Vec3::ZERO);
    let chart =
        Chart { place: &|v| DVec2::new(v.x / (1.0 - v.y).max(1e-9), v.y), density: &|p| 2.0 * (1.0 - p.y) };
    check("triangle", &triangle, &chart, everywhere);
    let disk = draw(&device, &kernel, 1, 0.0, Vec3::ZERO);
    let chart = Chart { place: &|v| DVec2::new(azimuth(v), v.length_squared()), density: &|_| 1.0 };
    check("disk", &disk, &chart, everywhere);
    for (i, (t, d)) in triangle.iter().zip(&disk).enumerate().take(2000) {
        let of = |family: u32| random4([i as u32, 0], 0, 0, 1 + family).map(f64::from);
        let xi = of(0);
        assert!(close(t.value, sampling::sample_triangle(DVec2::new(xi[0], xi[1])).extend(0.0), 1e-6));
        let xi = of(1);
        assert!(close(d.value, sampling::sample_disk(DVec2::new(xi[0], xi[1])).extend(0.0), 1e-5));
    }
}

#[test]
fn directions_in_cone_and_hemisphere() {
    let device = TestDevice::open();
    let kernel = Kernel::compute::<SamplerPush>(&device, &kernels::SAMPLERS, &[]).unwrap();
    let cone = draw(&device, &kernel, 2, CONE, Vec3::ZERO);
    let k = f64::from(CONE);
    // Per unit of (azimuth, 1 - cos) the solid angle is constant.
    let chart = Chart {
        place: &|v| DVec2::new(azimuth(v), (1.0 - v.z) / k),
        density: &|_| sampling::cone_pdf(k) * TAU * k,
    };
    check("cone", &cone, &chart, everywhere);
    let cosine = draw(&device, &kernel, 3, 0.0, Vec3::ZERO);
    let chart = Chart {
        place: &|v| DVec2::new(azimuth(v), v.z),
        density: &|p| TAU * sampling::cosine_hemisphere_pdf(p.y),
    };
    check("cosine hemisphere", &cosine, &chart, everywhere);
    for (i, (c, h)) in cone.iter().zip(&cosine).enumerate().take(2000) {
        let of = |family: u32| random4([i as u32, 0], 0, 0, 1 + family).map(f64::from);
        let xi = of(2);
        assert!(close(c.value, sampling::sample_cone(DVec2::new(xi[0], xi[1]), k), 1e-5));
        assert!((f64::from(c.pdf) / sampling::cone_pdf(k) - 1.0).abs() < 1e-5);
        let xi = of(3);
        let expected = sampling::sample_cosine_hemisphere(DVec2::new(xi[0], xi[1]));
        // Near the horizon z is the root of a difference.
        assert!(close(h.value, expected, 1e-3) && (f64::from(h.pdf) - expected.z / PI).abs() < 1e-3);
    }
}

/// Reflections about visible normals. The chart is polar about the mirror direction, stretched where the lobe is narrow;
/// directions below the surface make up one bin.
#[test]
fn reflections_about_visible_normals() {
    let device = TestDevice::open();
    let kernel = Kernel::compute::<SamplerPush>(&device, &kernels::SAMPLERS, &[]).unwrap();
    for cos in INCIDENCES {
        for alpha in ALPHAS {
            let v = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
            let samples = draw(&device, &kernel, 4, alpha, v);
            let (v, a) = (v.as_dvec3().normalize(), f64::from(alpha));
            let mirror = DVec3::new(-v.x, -v.y, v.z);
            let frame = sampling::basis_around(mirror);
            // tan(theta / 2) = a s / (1 - s): s = 1/2 at the lobe's width.
            let place = |l: DVec3| {
                let local = frame.transpose() * l;
                let t = ((1.0 - local.z).max(0.0) / (1.0 + local.z).max(1e-300)).sqrt();
                DVec2::new(azimuth(local), t / (t + a))
            };
            let density = |p: DVec2| {
                let t = a * p.y / (1.0 - p.y);
                let (theta, phi) = (2.0 * t.atan(), TAU * p.x);
                let l = frame * DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
                if l.z <= 0.0 {
                    return 0.0;
                }
                let dtheta = 2.0 / (1.0 + t * t) * a / (1.0 - p.y).powi(2);
                sampling::ggx_reflection_pdf(v, l, a) * theta.sin() * dtheta * TAU
            };
            let name = format!("VNDF, cos {cos}, alpha {alpha}");
            // The horizon cuts bins: their quadrature is only as good as its step, so they are left to the pool.
            check(&name, &samples, &Chart { place: &place, density: &density }, |l| l.z > 0.0);
            for s in samples.iter().filter(|s| s.value.z > 1e-3).take(5000) {
                let expected = sampling::ggx_reflection_pdf(v, s.value.as_dvec3(), a);
                let error = (f64::from(s.pdf) / expected - 1.0).abs();
                // At grazing incidence the half vector is a small difference, and a sharp lobe magnifies its rounding.
                assert!(
                    error < 1e-4 + 2e-7 / (a * f64::from(cos)),
                    "{name}: {} instead of {expected}",
                    s.pdf
                );
            }
        }
    }
}

fn hemisphere(cos: f64, phi: f64) -> DVec3 {
    let sin = (1.0 - cos * cos).sqrt();
    DVec3::new(sin * phi.cos(), sin * phi.sin(), cos)
}

fn cases() -> Vec<BrdfCase> {
    (0..4096)
        .map(|i| {
            let [a, b, c, d] = random4([i, 1], 0, 0, 5);
            let [e, f, g, h] = random4([i, 2], 0, 0, 5);
            let [r0, r1, r2, r3] = random4([i, 3], 0, 0, 5);
            BrdfCase {
                base: Vec4::new(a, b, c, (4.0 * d).floor() / 3.0),
                f0: Vec3::new(0.04, 0.3 * a, 0.1 * b) * (4.0 * d).floor() / 3.0,
                metallic: (3.0 * e).floor() / 2.0,
                roughness: f,
                v: hemisphere(f64::from(0.01 + 0.99 * g), TAU * f64::from(h)).as_vec3(),
                l: hemisphere(f64::from(0.01 + 0.99 * r0), TAU * f64::from(r1)).as_vec3(),
                xi: Vec3::new(r2, r3, random4([i, 4], 0, 0, 5)[0]),
                mixed: i % 2,
                pad: 0,
            }
        })
        .collect()
}

fn oracle(c: &BrdfCase) -> Brdf {
    let base = c.base.as_dvec4();
    let dielectric = (c.f0.as_dvec3(), base.w);
    Brdf::new(base.truncate(), dielectric, f64::from(c.metallic), f64::from(c.roughness), c.mixed != 0)
}

#[test]
fn brdf_equals_its_oracle() {
    let device = TestDevice::open();
    let kernel = Kernel::compute::<SamplerPush>(&device, &kernels::BRDF_CASES, &[]).unwrap();
    let cases = cases();
    let push =
        SamplerPush { family: 0, count: cases.len() as u32, seed: 0, parameter: 0.0, vector: Vec3::ZERO };
    let buffer = Buffer::from_slice(&device, "cases", &cases).unwrap();
    let samples = run_sampler(&device, &kernel, &push, None, |pass| pass.read("cases", &buffer));
    for (case, sample) in cases.iter().zip(&samples) {
        let brdf = oracle(case);
        let (v, l) = (case.v.as_dvec3(), case.l.as_dvec3());
        let value = brdf.eval(v, l);
        let sharp = 1e-4 + 4e-6 / brdf.alpha;
        let near = |actual: f64, expected: f64| (actual - expected).abs() <= sharp * expected.abs().max(1e-3);
        for c in 0..3 {
            assert!(near(f64::from(sample.radiance[c]), value.diffuse[c]), "{case:?} {sample:?} {value:?}");
            assert!(near(f64::from(sample.target[c]), value.specular[c]), "{case:?} {sample:?} {value:?}");
        }
        let pdf = brdf.pdf(v, l);
        assert!(near(f64::from(sample.pdf_again), pdf), "{case:?} {sample:?} {pdf}");
        // The choice of the lobe can go either way when the number is near its threshold.
        if (brdf.specular_probability(v) - f64::from(case.xi.z)).abs() > 1e-5 {
            let expected = brdf.sample(v, case.xi.as_dvec3());
            match expected {
                Some(l) if l.z > 1e-3 => assert!(close(sample.value, l, 1e-3), "{case:?} {sample:?} {l:?}"),
                Some(_) => {}
                None => assert!(sample.value.z < 1e-5, "{case:?} {sample:?}"),
            }
        }
    }
}

/// Midpoint quadrature over the hemisphere, fine round the mirror direction. Returns the integral of `f`.
fn integrate(v: DVec3, alpha: f64, f: impl Fn(DVec3) -> DVec3) -> DVec3 {
    const N: usize = 256;
    let frame = sampling::basis_around(DVec3::new(-v.x, -v.y, v.z));
    let alpha = alpha.max(0.1);
    let mut sum = DVec3::ZERO;
    for i in 0..N {
        let s = (i as f64 + 0.5) / N as f64;
        let t = alpha * s / (1.0 - s);
        let dtheta = 2.0 / (1.0 + t * t) * alpha / (1.0 - s).powi(2) / N as f64;
        let theta = 2.0 * t.atan();
        for j in 0..N {
            let l = frame * hemisphere(theta.cos(), TAU * (j as f64 + 0.5) / N as f64);
            if l.z > 0.0 {
                sum += f(l) * (theta.sin() * dtheta * TAU / N as f64);
            }
        }
    }
    sum
}

/// F0 and f90 of a dielectric with ior 1.5.
const PLASTIC: (DVec3, f64) = (DVec3::splat(0.04), 1.0);

/// A surface of metalness 0.5 is half a metal and half a dielectric: their BRDFs are mixed, not their parameters.
#[test]
fn partial_metals_mix_two_brdfs() {
    let base = DVec3::new(0.9, 0.6, 0.2);
    let (v, l) = (hemisphere(0.6, 0.4), hemisphere(0.8, 3.0));
    let of = |metallic, mixed| Brdf::new(base, PLASTIC, metallic, 0.7, mixed).whole_times_cosine(v, l);
    let half = (of(0.0, false) + of(1.0, false)) / 2.0;
    assert!((of(0.5, false) - half).abs().max_element() < 1e-12, "{} {half}", of(0.5, false));
    assert!((of(0.5, true) - half).abs().max_element() > 0.02, "mixed parameters are darker");
}

/// No lobe reflects more than it gets, whatever the angle and the roughness; the whole surface neither, up to where the
/// glTF model itself gains energy: 1 - F takes the half vector's Fresnel term, which is small for the diffuse base even where
/// the specular lobe is a mirror at grazing incidence.
#[test]
fn white_furnace() {
    let mut worst: f64 = 0.0;
    for cos in [1.0, 0.7, 0.4, 0.2, 0.05] {
        for roughness in [0.1, 0.3, 0.6, 1.0] {
            let v = hemisphere(cos, 0.3);
            let metal = Brdf::new(DVec3::ONE, PLASTIC, 1.0, roughness, false);
            let specular = integrate(v, metal.alpha, |l| metal.whole_times_cosine(v, l)).x;
            assert!((0.2..=1.001).contains(&specular), "metal {cos} {roughness}: {specular}");
            let lambertian = Brdf::new(DVec3::ONE, (DVec3::ZERO, 0.0), 0.0, roughness, false);
            assert_eq!(lambertian.f0.max(DVec3::splat(lambertian.f90)), DVec3::ZERO);
            let diffuse = integrate(v, lambertian.alpha, |l| lambertian.whole_times_cosine(v, l)).x;
            assert!((diffuse - 1.0).abs() < 5e-3, "Lambertian {cos} {roughness}: {diffuse}");
            let plastic = Brdf::new(DVec3::ONE, PLASTIC, 0.0, roughness, false);
            let whole = integrate(v, plastic.alpha, |l| plastic.whole_times_cosine(v, l)).x;
            if cos >= 0.7 {
                assert!(whole <= 1.01, "plastic {cos} {roughness}: {whole}");
            }
            worst = worst.max(whole);
        }
    }
    assert!(
        (1.2..1.9).contains(&worst),
        "the gain of the model at grazing incidence is documented as up to 1.8: {worst}"
    );
}

/// f cos / pdf averaged over the samples is the reflectance, and the pdf integrates to the share of samples above the surface.
#[test]
fn weight_is_value_over_pdf() {
    for (cos, roughness, metallic) in [(0.9, 0.5, 0.0), (0.5, 0.3, 1.0), (0.1, 0.8, 0.5)] {
        let v = hemisphere(cos, 1.0);
        let brdf = Brdf::new(DVec3::new(0.8, 0.5, 0.3), PLASTIC, metallic, roughness, false);
        let (mut sum, mut squares, mut above) = (DVec3::ZERO, DVec3::ZERO, 0);
        let n = 100_000;
        for i in 0..n {
            let [x, y, z, _] = random4([i, 0], 0, 0, 3).map(f64::from);
            if let Some(l) = brdf.sample(v, DVec3::new(x, y, z)) {
                let weight = brdf.whole_times_cosine(v, l) / brdf.pdf(v, l);
                sum += weight;
                squares += weight * weight;
                above += 1;
            }
        }
        let n = f64::from(n);
        let mean = sum / n;
        let error = ((squares / n - mean * mean) / n).max_element().sqrt();
        let expected = integrate(v, brdf.alpha, |l| brdf.whole_times_cosine(v, l));
        assert!((mean - expected).abs().max_element() < 4.0 * error + 1e-3, "{mean} {expected} {error}");
        let mass = integrate(v, brdf.alpha, |l| DVec3::splat(brdf.pdf(v, l))).x;
        let share = f64::from(above) / n;
        assert!((mass - share).abs() < 4.0 * (share * (1.0 - share) / n).sqrt() + 2e-3, "{mass} {share}");
        // A pdf without its cosine, and a weight without the pdf, are both far outside of that.
        let wrong = integrate(v, brdf.alpha, |l| brdf.whole_times_cosine(v, l) / l.z);
        assert!((mean - wrong).abs().max_element() > 8.0 * error + 1e-3);
    }
}
