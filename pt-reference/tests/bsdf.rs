//! bsdf.glsl: kernels against the oracle, samples against densities, energy.

use crate::common::records::{BsdfCase, BsdfResult, HistogramPush};
use crate::common::*;
use glam::{DVec3, Vec2, Vec3, Vec4};
use pt_core::rng::random4;
use pt_core::test_support::TestDevice;
use pt_core::test_support::statistics::{SIGNIFICANCE, chi_squared, sidak};
use pt_core::{Buffer, Kernel, Location};
use pt_reference::oracle::bsdf::bend_normal;
use std::f32::consts::TAU;

const SAMPLES: u32 = 1_000_000;
/// Cosines between view direction and normal, the last one grazing.
const INCIDENCES: [f32; 3] = [0.95, 0.5, 0.04];
/// Charts that are tested, for the correction of the significance.
const TESTS: usize = 19 * INCIDENCES.len();

fn bumped(c: BsdfCase) -> BsdfCase {
    BsdfCase { face_normal: Vec3::new(0.25, -0.15, 1.0).normalize(), ..c }
}

/// Everything at once.
fn mixture(flags: u32) -> BsdfCase {
    BsdfCase {
        base_color: Vec3::new(0.9, 0.6, 0.3),
        metallic: 0.3,
        alpha: Vec2::new(0.35, 0.12),
        specular: 0.8,
        specular_color: Vec3::new(1.0, 0.9, 0.7),
        transmission: 0.4,
        coat: 0.6,
        coat_alpha: 0.09,
        coat_normal: direction(0.97, 2.0),
        sheen_color: Vec3::new(0.1, 0.3, 0.5),
        sheen_alpha: 0.2,
        flags,
        ..plastic(0.5)
    }
}

/// Name, surface, and width of its lobe round the mirror direction.
fn families() -> Vec<(&'static str, BsdfCase, f32)> {
    let tinted = Vec3::new(0.9, 0.6, 0.3);
    vec![
        ("metal, roughness 0.1", metal(0.1), 0.02),
        ("metal, roughness 0.5", metal(0.5), 0.3),
        ("metal, roughness 1", metal(1.0), 1.0),
        ("anisotropic metal", BsdfCase { alpha: Vec2::new(0.5, 0.04), ..metal(0.5) }, 0.2),
        ("compensated metal", BsdfCase { flags: ENERGY_COMPENSATION, base_color: tinted, ..metal(0.8) }, 0.7),
        ("Lambertian", lambertian(), 1.0),
        ("plastic", BsdfCase { base_color: tinted, ..plastic(0.3) }, 0.1),
        ("compensated plastic", BsdfCase { flags: ENERGY_COMPENSATION, ..plastic(0.4) }, 0.2),
        ("glass from outside", glass(0.3, 1.5), 0.1),
        ("glass from inside", glass(0.4, 1.0 / 1.5), 0.15),
        ("thin sheet", BsdfCase { flags: 0, base_color: tinted, ..glass(0.3, 1.5) }, 0.1),
        (
            "coated metal",
            BsdfCase {
                coat: 1.0,
                coat_alpha: 0.01,
                coat_normal: direction(0.98, 1.0),
                base_color: tinted,
                ..metal(0.6)
            },
            0.1,
        ),
        ("iridescent metal", BsdfCase { film: Vec3::new(1.0, 1.33, 400.0), ..metal(0.4) }, 0.2),
        ("iridescent plastic", BsdfCase { film: Vec3::new(0.7, 1.6, 550.0), ..plastic(0.3) }, 0.2),
        ("sheen on a Lambertian", BsdfCase { sheen_color: tinted, sheen_alpha: 0.09, ..lambertian() }, 1.0),
        ("bumped metal", bumped(metal(0.4)), 0.15),
        ("bumped glass", bumped(glass(0.4, 1.5)), 0.15),
        ("everything, solid", mixture(SOLID), 0.2),
        ("everything, thin, compensated", mixture(ENERGY_COMPENSATION), 0.2),
    ]
}

/// p-value of a histogram for densities of the bins.
fn p_value(h: &Histogram, density: &[f64]) -> f64 {
    let n = h.counts.iter().sum::<u64>() as f64;
    let bins = density.len();
    let mut observed = h.counts[..bins].to_vec();
    let mut expected: Vec<f64> = density.iter().map(|d| (d * n).max(1e-6)).collect();
    // What is left of one: no samples.
    let rest = n - expected.iter().sum::<f64>();
    if h.counts[bins] > 0 {
        observed.push(h.counts[bins]);
        expected.push(rest.max(1e-9));
    }
    chi_squared(&observed, &expected)
}

/// A million samples each; a density that is off by 5 % on half of the sphere must not pass.
#[test]
fn samples_follow_their_density() {
    let device = TestDevice::open();
    let statistics = Statistics::new(&device);
    let families = families();
    assert_eq!(families.len() * INCIDENCES.len(), TESTS);
    let mut failures = Vec::new();
    for (k, (name, case, width)) in families.iter().enumerate() {
        for (j, cos) in INCIDENCES.into_iter().enumerate() {
            let case = BsdfCase { wo: direction(cos, 0.7), ..*case };
            let chart = Chart::mirror(&case, *width);
            let h = statistics.histogram(&case, chart, SAMPLES, (10 * k + j) as u32);
            let integrals = statistics.integrals(&case, chart, 48);
            let density: Vec<f64> = integrals.0.iter().map(|v| v.w).collect();
            let none = h.counts[density.len()] as f64 / f64::from(SAMPLES);
            let sum = integrals.density();
            let p = p_value(&h, &density);
            let tilted: Vec<f64> = (0..density.len())
                .map(|i| density[i] * if i % (BINS as usize) < 12 { 1.05 } else { 0.95 })
                .collect();
            let broken = p_value(&h, &tilted);
            let mean_error = (h.mean - integrals.albedo()).abs().max_element();
            println!(
                "{name}, cos {cos}: p {p:.4}, integral of the pdf {sum:.5}, rejected {none:.5}, weight {:.1e}, albedo {:.4} ({mean_error:.1e} off, se {:.1e})",
                h.worst_weight, h.mean.x, h.error
            );
            let mut check = |ok: bool, what: &str| {
                if !ok {
                    failures.push(format!("{name}, cos {cos}: {what}"));
                }
            };
            check(p > sidak(TESTS), "samples do not follow the density");
            check(broken < SIGNIFICANCE, "a wrong density is not noticed");
            check(sum < 1.002 && (sum + none - 1.0).abs() < 0.004, "the density does not integrate to one");
            check(h.worst_weight < 1e-3, "the weight is not f cos / pdf");
            check(mean_error < 5.0 * h.error + 3e-3, "the mean weight is not the albedo");
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// Deltas are taken with the probability that they say.
#[test]
fn deltas_follow_their_probability() {
    let device = TestDevice::open();
    let statistics = Statistics::new(&device);
    let smooth = |c: BsdfCase| BsdfCase { alpha: Vec2::ZERO, ..c };
    let cases = [
        ("mirror", smooth(metal(1.0)), [1.0, 0.0]),
        ("glass", smooth(glass(1.0, 1.5)), [0.0, 0.0]),
        ("thin glass", BsdfCase { flags: 0, ..smooth(glass(1.0, 1.5)) }, [0.0, 0.0]),
        ("index-matched glass", glass(0.5, 1.0), [0.0, 1.0]),
        ("lacquer", BsdfCase { coat: 1.0, ..plastic(0.5) }, [0.0, 0.0]),
        ("milk glass", BsdfCase { transmission: 0.5, ..smooth(glass(1.0, 1.5)) }, [0.0, 0.0]),
    ];
    for (name, case, exact) in cases {
        for cos in INCIDENCES {
            let case = BsdfCase { wo: direction(cos, 0.7), ..case };
            let surface = oracle(&case);
            let h = statistics.histogram(&case, Chart::mirror(&case, 0.5), 100_000 / 64 * 64, 3);
            let n = h.counts.iter().sum::<u64>() as f64;
            let found = &h.counts[(BINS * BINS + 1) as usize..];
            // The oracle's probabilities, by one sample of each kind.
            for (kind, transmission) in [false, true].into_iter().enumerate() {
                let probability = (0..400)
                    .filter_map(|i| {
                        let [a, b, c, d] = random4([i, 9], 0, 0, 0).map(f64::from);
                        surface.sample(case.wo.as_dvec3(), [a, b, c, d])
                    })
                    .find(|s| s.delta && s.transmission == transmission)
                    .map_or(0.0, |s| s.pdf);
                let share = found[kind] as f64 / n;
                let sigma = (probability * (1.0 - probability) / n).sqrt();
                assert!(
                    (share - probability).abs() <= 4.5 * sigma + 1e-4,
                    "{name}, cos {cos}, transmission {transmission}: {share} instead of {probability}"
                );
                if exact[kind] > 0.0 {
                    assert_eq!(share, exact[kind], "{name}");
                }
            }
            // Nothing is lost but what refraction scales, and what the coupled base of a lacquer gains or loses.
            if !name.contains("lacquer") && !name.contains("milk") {
                let transmitted =
                    1.0 / if case.flags & SOLID != 0 { f64::from(case.eta).powi(2) } else { 1.0 };
                let f = pt_reference::oracle::dielectric::fresnel(cos.into(), case.eta.into());
                let f = if case.metallic > 0.0 { 1.0 } else { f };
                let expected = f + (1.0 - f) * transmitted;
                assert!(
                    (h.mean.x - expected).abs() < 5.0 * h.error + 1e-4,
                    "{name}: {} {expected}",
                    h.mean.x
                );
            }
        }
    }
}

fn unit(random: [f32; 4], k: usize) -> f32 {
    random[k]
}

/// Surfaces of all kinds with random parameters, and directions.
fn random_cases(count: u32) -> Vec<BsdfCase> {
    (0..count)
        .map(|i| {
            let r: Vec<[f32; 4]> = (0..10).map(|k| random4([i, k], 0, 0, 11)).collect();
            let pick = |k: usize, c: usize, values: &[f32]| values[(r[k][c] * values.len() as f32) as usize];
            let color = |k: usize| Vec3::new(r[k][0], r[k][1], r[k][2]);
            let roughness = pick(0, 0, &[0.0, 0.1, 0.3, 0.7, 1.0]);
            let stretch = pick(0, 1, &[0.0, 0.0, 0.5]);
            let alpha = roughness * roughness;
            let wo = direction(0.03 + 0.97 * unit(r[1], 0), TAU * r[1][1]);
            let wi = direction(0.03 + 0.97 * unit(r[1], 2), TAU * r[1][3]);
            let solid = r[2][3] < 0.5;
            BsdfCase {
                base_color: color(2),
                metallic: pick(3, 0, &[0.0, 0.0, 0.4, 1.0]),
                alpha: if alpha == 0.0 {
                    Vec2::ZERO
                } else {
                    Vec2::new(alpha + (1.0 - alpha) * stretch * stretch, alpha)
                },
                eta: if solid { pick(3, 1, &[1.5, 1.0 / 1.5, 1.33, 2.4, 1.0, 0.9]) } else { 1.5 },
                specular: pick(3, 2, &[1.0, 1.0, 0.5, 0.0]),
                specular_color: if r[3][3] < 0.5 { Vec3::ONE } else { color(4) },
                transmission: pick(5, 0, &[0.0, 0.0, 0.5, 1.0]),
                coat: pick(5, 1, &[0.0, 0.0, 0.5, 1.0]),
                coat_alpha: pick(5, 2, &[0.0, 0.01, 0.3]),
                coat_normal: direction(1.0 - 0.03 * r[5][3], TAU * r[6][0]),
                sheen_color: if r[6][1] < 0.3 { color(7) } else { Vec3::ZERO },
                sheen_alpha: pick(6, 2, &[0.01, 0.1, 1.0]),
                // A tenth of the films is not there.
                film: Vec3::new(
                    if r[6][3] < 0.3 { r[5][3] } else { 0.0 },
                    1.1 + r[5][2],
                    1000.0 * (r[5][1] - 0.1).max(0.0),
                ),
                flags: u32::from(solid) * SOLID + u32::from(r[6][3] < 0.5) * ENERGY_COMPENSATION,
                face_normal: direction(1.0 - 0.05 * r[7][3], TAU * r[8][0]),
                wo,
                wi: if r[8][1] < 0.4 { wi * Vec3::new(1.0, 1.0, -1.0) } else { wi },
                u: Vec4::from_array(r[9]),
                ..metal(1.0)
            }
        })
        .collect()
}

#[test]
fn kernels_equal_the_oracle() {
    let device = TestDevice::open();
    let kernel = Kernel::compute::<HistogramPush>(&device, &kernels::BSDF_CASES, &[]).unwrap();
    let cases = random_cases(16384);
    let buffer = Buffer::from_slice(&device, "cases", &cases).unwrap();
    let size = (cases.len() * size_of::<BsdfResult>()) as u64;
    let results = Buffer::new(&device, "results", size, Location::Device).unwrap();
    let tables = tables(&device);
    let push = HistogramPush { count: cases.len() as u32, ..bytemuck::Zeroable::zeroed() };
    let results: Vec<BsdfResult> = run(&device, &kernel, &push, push.count, &results, |pass| {
        pass.read("cases", &buffer).read("bsdf_tables", &tables).write("results", &results)
    });
    let mut wrong = Vec::new();
    let (mut deltas, mut transmitted, mut sampled) = (0, 0, 0);
    for (case, r) in cases.iter().zip(&results) {
        let surface = oracle(case);
        let (wo, wi) = (case.wo.as_dvec3(), case.wi.as_dvec3());
        let value = surface.evaluate(wo, wi);
        // A sharp lobe magnifies the rounding of the half vector, the more so at grazing angles and for indices near 1.
        let sharp = |alpha: f64| if alpha > 0.0 { 1e-6 / alpha } else { 0.0 };
        let alpha = f64::from(case.alpha.min_element());
        let grazing = 1.0 + 0.05 / f64::from(case.wo.z).powi(2);
        let flat = if case.eta == 0.9 { 10.0 } else { 1.0 };
        let tolerance = 3e-4 + 4.0 * grazing * flat * (sharp(alpha) + sharp(case.coat_alpha.into()));
        let near = |a: f64, b: f64| (a - b).abs() <= tolerance * b.abs().max(1e-3);
        let near3 = |a: Vec3, b: DVec3| (0..3).all(|c| near(f64::from(a[c]), b[c]));
        let bent = bend_normal(case.coat_normal.as_dvec3(), case.face_normal.as_dvec3(), wo);
        assert!((bent - r.bent.as_dvec3()).length() < 2e-4, "{bent} {r:?} {case:?}");
        if !near3(r.f_cos, value.f_cos) || !near(r.pdf.into(), value.pdf) {
            wrong.push(format!("value {value:?}\n  {r:?}\n  {case:?}"));
        }
        // The choices can go either way when a number is near its threshold: the oracle then disagrees in kind.
        let u = case.u.to_array().map(f64::from);
        match surface.sample(wo, u) {
            None => {}
            Some(_) if r.sample_pdf == 0.0 => {}
            Some(s) => {
                sampled += 1;
                deltas += usize::from(s.delta);
                transmitted += usize::from(s.transmission);
                let flags = u32::from(s.delta) * DELTA + u32::from(s.transmission) * TRANSMISSION;
                // The weight of the oracle for the very direction of the kernel.
                let direction = r.direction.as_dvec3();
                let close = (direction - s.direction).length() < 2e-3 * grazing;
                let expected = if s.delta {
                    (s.weight, s.pdf)
                } else {
                    let v = surface.evaluate(wo, direction.normalize());
                    (v.f_cos / v.pdf.max(1e-20), v.pdf)
                };
                if flags != r.flags
                    || !close
                    || !near3(r.weight, expected.0)
                    || !near(r.sample_pdf.into(), expected.1)
                {
                    wrong.push(format!("sample {s:?} {expected:?}\n  {r:?}\n  {case:?}"));
                }
            }
        }
    }
    println!(
        "{sampled} samples, {deltas} deltas, {transmitted} transmitted; {} of {} differ",
        wrong.len(),
        cases.len()
    );
    assert!(sampled > 12_000 && deltas > 2000 && transmitted > 1500);
    // Thresholds of choices, and horizons.
    assert!(
        wrong.len() * 1000 <= cases.len(),
        "{} differ; {}",
        wrong.len(),
        wrong[..3.min(wrong.len())].join("\n")
    );
}

/// With energy compensation a white metal is a white furnace to within 1 %, whatever its roughness; without, this is its loss.
/// Opaque white dielectrics are one too.
#[test]
fn white_furnace() {
    let device = TestDevice::open();
    let statistics = Statistics::new(&device);
    let (mut worst_metal, mut worst_plastic): (f64, f64) = (0.0, 0.0);
    for roughness in [0.0f32, 0.05, 0.2, 0.4, 0.6, 0.8, 1.0] {
        for cos in [1.0f32, 0.6, 0.25, 0.05] {
            let wo = direction(cos, 0.3);
            let energy = |case: BsdfCase| {
                let case = BsdfCase { wo, ..case };
                // A narrow lobe over a wide one has no good chart; its samples have next to no variance.
                if roughness < 0.2 {
                    return statistics.histogram(&case, Chart::mirror(&case, 0.1), 1 << 16, 1).mean.x;
                }
                statistics.integrals(&case, Chart::mirror(&case, roughness * roughness * 1.5), 16).albedo().x
            };
            let smooth =
                |case: BsdfCase| if roughness < 0.02 { BsdfCase { alpha: Vec2::ZERO, ..case } } else { case };
            let plain = energy(smooth(metal(roughness)));
            let compensated = energy(smooth(BsdfCase { flags: ENERGY_COMPENSATION, ..metal(roughness) }));
            let plastic = energy(smooth(BsdfCase { flags: ENERGY_COMPENSATION, ..plastic(roughness) }));
            println!(
                "roughness {roughness}, cos {cos}: metal {plain:.4}, compensated {compensated:.4}, compensated dielectric {plastic:.4}"
            );
            assert!(plain < 1.001, "a white metal gains: roughness {roughness}, cos {cos}: {plain}");
            assert!(
                roughness < 1.0 || cos < 0.6 || plain < 0.5,
                "a rough metal loses more than half: {plain}"
            );
            worst_metal = worst_metal.max((compensated - 1.0).abs());
            worst_plastic = worst_plastic.max((plastic - 1.0).abs());
        }
    }
    println!("compensated metal: {worst_metal:.4} off at most, opaque dielectric {worst_plastic:.4}");
    assert!(worst_metal < 0.01);
    assert!(worst_plastic < 0.02);
}

/// Light goes both ways alike: f(v, l) = f(l, v), but for the coat, and for 1 / eta^2 of refraction. Of the oracle, which the kernels
/// equal.
#[test]
fn reciprocity() {
    let (mut reflected, mut refracted) = (0, 0);
    for case in random_cases(20_000) {
        let case = BsdfCase { coat: 0.0, face_normal: Vec3::Z, ..case };
        let (v, l) = (case.wo.as_dvec3().normalize(), case.wi.as_dvec3().normalize());
        let surface = oracle(&case);
        let forth = surface.evaluate(v, l).f_cos / l.z.abs();
        let back = if l.z > 0.0 {
            reflected += 1;
            surface.evaluate(l, v).f_cos / v.z
        } else {
            if forth == DVec3::ZERO || surface.sheen_color != DVec3::ZERO {
                continue;
            }
            refracted += 1;
            // From the other side; the surface turned round so that its normal is there.
            let turned = |d: DVec3| DVec3::new(d.x, d.y, -d.z);
            let eta2 = if surface.solid { surface.eta * surface.eta } else { 1.0 };
            let eta = if surface.solid { 1.0 / surface.eta } else { surface.eta };
            let other = pt_reference::oracle::bsdf::Bsdf { eta, ..surface };
            other.evaluate(turned(l), turned(v)).f_cos / v.z / eta2
        };
        assert!(
            (forth - back).abs().max_element() <= 1e-9 * forth.max_element().max(1e-3),
            "{forth} {back} {case:?}"
        );
    }
    assert!(reflected > 9000 && refracted > 700, "{reflected} {refracted}");
}

/// Tables against the quadrature that they are made of, between their entries.
#[test]
fn albedo_tables() {
    use pt_reference::oracle::albedo;
    let (mut whole, mut grazing, mut sheen): (f64, f64, f64) = (0.0, 0.0, 0.0);
    for i in 0..240u32 {
        let [x, y, ..] = random4([i, 5], 0, 0, 2).map(f64::from);
        let (cos, roughness) = (0.01 + 0.99 * x * x, 0.1 + 0.9 * y);
        let alpha = roughness * roughness;
        let (exact, table) = (albedo::ggx_quadrature(cos, alpha), albedo::ggx(cos, alpha));
        whole = whole.max((exact - table).element_sum().abs());
        grazing = grazing.max((exact.y - table.y).abs());
        if i % 4 == 0 && cos > 0.05 {
            sheen = sheen.max((albedo::charlie_quadrature(cos, alpha) - albedo::charlie(cos, alpha)).abs());
        }
    }
    println!("largest error: GGX {whole:.4}, its Fresnel part {grazing:.4}, sheen {sheen:.4}");
    assert!(whole < 0.006 && grazing < 0.02 && sheen < 0.01, "{whole} {grazing} {sheen}");
}

/// Whatever a normal map says, the mirror direction is above the triangle, and normals that are fine stay.
#[test]
fn bent_normals_reflect_upwards() {
    let mut bent = 0;
    for i in 0..20_000u32 {
        let [a, b, c, d] = random4([i, 6], 0, 0, 2);
        let wo = direction(0.002 + 0.998 * a, TAU * b).as_dvec3().normalize();
        let n = direction(2.0 * c - 1.0, TAU * d).as_dvec3().normalize();
        let result = bend_normal(n, DVec3::Z, wo);
        let mirrored = pt_reference::oracle::mirror(wo, result);
        assert!(
            (result.length() - 1.0).abs() < 1e-12 && result.dot(wo) > 0.0 && mirrored.z > 0.0,
            "{n} {wo} {result}"
        );
        let fine = n.z > 0.0 && n.dot(wo) > 0.0 && pt_reference::oracle::mirror(wo, n).z > 1e-3;
        assert!(!fine || result == n);
        bent += u32::from(!fine);
    }
    assert!(bent > 5000, "{bent}");
}
