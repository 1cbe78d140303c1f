//! The kernel against its oracle, and the oracle against what the representation promises.

use glam::{DQuat, DVec3, Vec3};
use proptest::prelude::*;
use pt_core::rng::random4;
use pt_core::test_support::TestDevice;
use pt_core::{Buffer, Kernel, Recorder};
use pt_indirect::oracle::{ShLight, rgb_from_ycocg, ycocg_from_rgb};
use std::f64::consts::{PI, TAU};

#[path = "common/records.rs"]
mod records;
use records::ShRecord;

mod kernels {
    include!(concat!(env!("OUT_DIR"), "/test_kernels.rs"));
}

/// Uniform on the sphere.
fn sphere(u: f64, v: f64) -> DVec3 {
    let (z, phi) = (1.0 - 2.0 * u, TAU * v);
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * phi.cos(), r * phi.sin(), z)
}

fn direction() -> impl Strategy<Value = DVec3> {
    (0.0..1.0, 0.0..1.0).prop_map(|(u, v)| sphere(u, v))
}

/// Radiance up to 1000, also black and saturated.
fn radiance() -> impl Strategy<Value = DVec3> {
    let channel = prop_oneof![Just(0.0), 0.0..1.0, 0.0..1000.0];
    [channel.clone(), channel.clone(), channel].prop_map(DVec3::from_array)
}

/// Light from a few directions.
fn lights() -> impl Strategy<Value = Vec<(DVec3, DVec3)>> {
    prop::collection::vec((direction(), radiance()), 1..6)
}

fn encode(lights: &[(DVec3, DVec3)]) -> ShLight {
    lights.iter().map(|&(d, l)| ShLight::encode(d, l)).sum()
}

fn close(a: DVec3, b: DVec3, scale: f64) -> bool {
    (a - b).abs().max_element() <= 1e-12 * scale.max(1e-300)
}

#[test]
fn kernel_equals_the_oracle() {
    let device = TestDevice::open();
    let mut cases: Vec<ShRecord> = (0..4096)
        .map(|i| {
            let unit = |k: u32| {
                let [u, v, ..] = random4([i, k], 0, 0, 1);
                sphere(u.into(), v.into()).as_vec3().normalize()
            };
            // From 1e-3 to 1e3, every eighth black.
            let hdr = |k: u32| {
                let [r, g, b, black] = random4([i, k], 0, 1, 1);
                if black < 0.125 { Vec3::ZERO } else { Vec3::new(r, g, b).map(|x| 10f32.powf(6.0 * x - 3.0)) }
            };
            ShRecord {
                directions: [unit(0), unit(1)],
                radiances: [hdr(0), hdr(1)],
                normal: unit(2),
                ..bytemuck::Zeroable::zeroed()
            }
        })
        .collect();
    cases[0].radiances = [Vec3::ZERO; 2];
    let buffer = Buffer::from_slice(&device, "cases", &cases).unwrap();
    let kernel = Kernel::compute::<()>(&device, &kernels::SH, &[]).unwrap();
    let mut recorder = Recorder::new(&device).unwrap();
    let mut frame = recorder.begin().unwrap();
    frame.pass("sh", &kernel).update("cases", &buffer).dispatch([cases.len() as u32, 1, 1]).unwrap();
    frame.submit().unwrap();
    recorder.finish().unwrap();

    for (case, gpu) in cases.iter().zip(buffer.read::<ShRecord>().unwrap()) {
        let light = encode(&[0, 1].map(|k| (case.directions[k].as_dvec3(), case.radiances[k].as_dvec3())));
        let irradiance = light.irradiance(case.normal.as_dvec3());
        let [direction, other] = case.directions.map(|d| d.as_dvec3());
        let (first, normal) = (case.radiances[0].as_dvec3(), case.normal.as_dvec3());
        let of_irradiance = ShLight::encode_irradiance(direction, first, other).irradiance(normal);
        let of_constant = ShLight::constant(first).irradiance(normal);
        let vectors = [gpu.irradiance, gpu.of_irradiance, gpu.of_constant, gpu.luma1].map(|v| v.to_array());
        let actual = [vectors.as_flattened(), &[gpu.luma0], &gpu.chroma].concat();
        let vectors = [irradiance, of_irradiance, of_constant, light.luma1].map(|v| v.to_array());
        let expected = [vectors.as_flattened(), &[light.luma0], &light.chroma].concat();
        // Some ten roundings of sums whose terms are at most the radiance.
        let scale = f64::from((case.radiances[0] + case.radiances[1]).max_element());
        for (a, e) in actual.iter().zip(&expected) {
            assert!((f64::from(*a) - e).abs() <= 2e-6 * scale, "{case:?}\n{gpu:?}\n{light:?} {irradiance}");
        }
    }
}

/// Uniform sampling of the hemisphere, as bounce rays do it. At the hemisphere's own normal one sample is worth
/// 2 pi L (1/4 + cos/2); cos is uniform in 0..1, so the mean is pi L and its standard error pi L / sqrt(12 n).
#[test]
fn constant_radiance_gives_pi_times_radiance() {
    const SAMPLES: u32 = 4096;
    let radiance = DVec3::new(0.7, 2.0, 0.1);
    let standard_error = 1.0 / f64::from(12 * SAMPLES).sqrt();
    let (mut squares, normals) = (0.0, 64);
    for k in 0..normals {
        let normal = sphere(f64::from(k) / f64::from(normals), 0.618 * f64::from(k));
        let light: ShLight = (0..SAMPLES)
            .map(|i| {
                let [u, v, ..] = random4([i, k], 0, 0, 2);
                let d = sphere(u.into(), v.into());
                ShLight::encode(d * d.dot(normal).signum(), radiance * TAU)
            })
            .sum();
        let ratio = (light * f64::from(SAMPLES).recip()).irradiance(normal) / (PI * radiance);
        let error = (ratio.x - 1.0) / standard_error;
        assert!(error.abs() < 4.5, "{normal}: {error} standard errors");
        assert!((ratio - ratio.x).abs().max_element() < 1e-12, "the hue is kept: {ratio}");
        squares += error * error;
    }
    // The errors are as large as stated: their mean square is 1 +- sqrt(2 / 64).
    let spread = squares / f64::from(normals);
    assert!((0.3..1.7).contains(&spread), "{spread}");
}

proptest! {
    /// Radiance a + b . d is all that l <= 1 can hold: E = pi a + 2/3 pi b . n, here by integrating over the sphere.
    #[test]
    fn linear_environments_are_exact(b in direction(), k in 0.0..1.0f64, normal in direction()) {
        const N: usize = 64;
        let light = (0..2 * N * N)
            .map(|i| {
                // Centres of patches of equal solid angle.
                let d = sphere(((i / (2 * N)) as f64 + 0.5) / N as f64, ((i % (2 * N)) as f64 + 0.5) / (2 * N) as f64);
                ShLight::encode(d, DVec3::splat(1.0 + k * b.dot(d)) * (4.0 * PI / (2 * N * N) as f64))
            })
            .sum::<ShLight>();
        let exact = PI + 2.0 / 3.0 * PI * k * b.dot(normal);
        // Midpoint rule for z^2 on 64 intervals: 1 / (4 * 64^2) of the integral.
        prop_assert!((light.irradiance(normal).x - exact).abs() < 2e-4 * PI);
    }

    /// What l <= 1 makes of a beam: 1/4 + cos/2 of its power, where the truth is the clamped cosine.
    #[test]
    fn a_beam_is_smeared(d in direction(), l in radiance(), normal in direction()) {
        let expected = l * (0.25 + 0.5 * d.dot(normal)).max(0.0);
        prop_assert!(close(ShLight::encode(d, l).irradiance(normal), expected, l.max_element()));
    }

    #[test]
    fn encoding_is_linear(d in direction(), a in radiance(), b in radiance(), f in 0.0..100.0) {
        let sum = ShLight::encode(d, a) + ShLight::encode(d, b) * f;
        let whole = ShLight::encode(d, a + b * f);
        let scale = a.max_element() + f * b.max_element();
        prop_assert!(close(sum.luma1, whole.luma1, scale));
        let rest = |s: ShLight| DVec3::new(s.luma0, s.chroma[0], s.chroma[1]);
        prop_assert!(close(rest(sum), rest(whole), 4.0 * scale));
    }

    /// Luma adds up wherever no part is clamped; a factor passes through in any case.
    #[test]
    fn luma_of_the_irradiance_is_linear(a in lights(), b in lights(), normal in direction(), f in 0.0..100.0) {
        let (a, b) = (encode(&a), encode(&b));
        let luma = |light: ShLight| ycocg_from_rgb(light.irradiance(normal))[0];
        let scale = 1e-11 * (a.luma0 + f * b.luma0);
        prop_assert!((luma(b * f) - f * luma(b)).abs() <= scale);
        if luma(a) > 0.0 && luma(b) > 0.0 {
            prop_assert!((luma(a + b * f) - luma(a) - f * luma(b)).abs() <= scale);
        }
    }

    #[test]
    fn turning_light_and_normal_changes_nothing(
        lights in lights(), normal in direction(), axis in direction(), angle in 0.0..TAU,
    ) {
        let q = DQuat::from_axis_angle(axis, angle);
        let turned: Vec<_> = lights.iter().map(|&(d, l)| (q * d, l)).collect();
        let scale: f64 = lights.iter().map(|(_, l)| l.max_element()).sum();
        prop_assert!(close(encode(&lights).irradiance(normal), encode(&turned).irradiance(q * normal), 10.0 * scale));
        // Turning the light alone is turning the normal back.
        prop_assert!(close(encode(&turned).irradiance(normal), encode(&lights).irradiance(q.inverse() * normal), 10.0 * scale));
    }

    #[test]
    fn light_stays_light(lights in lights(), normal in direction()) {
        let scale: f64 = lights.iter().map(|(_, l)| l.max_element()).sum();
        let irradiance = encode(&lights).irradiance(normal);
        prop_assert!(irradiance.min_element() >= -1e-12 * scale, "{irradiance}");
        prop_assert!(irradiance.max_element() <= 4.0 * scale);
    }

    /// What bounce rays store: exact at the normal of the surface itself, whatever it is blurred with later.
    #[test]
    fn irradiance_is_exact_at_its_own_normal(lights in lights(), normal in direction()) {
        let lights: Vec<_> = lights.into_iter().map(|(d, e)| (d * d.dot(normal).signum(), e)).collect();
        let light: ShLight = lights.iter().map(|&(d, e)| ShLight::encode_irradiance(d, e, normal)).sum();
        let exact: DVec3 = lights.iter().map(|&(_, e)| e).sum();
        let luma = |c| ycocg_from_rgb(c)[0];
        prop_assert!((luma(light.irradiance(normal)) - luma(exact)).abs() <= 1e-11 * luma(exact).max(1e-300));
        let one = ShLight::encode_irradiance(lights[0].0, lights[0].1, normal).irradiance(normal);
        prop_assert!(close(one, lights[0].1, 4.0 * lights[0].1.max_element()), "with its hue: {one}");
    }

    #[test]
    fn constant_light_is_the_same_for_all_normals(e in radiance(), normal in direction()) {
        prop_assert!(close(ShLight::constant(e).irradiance(normal), e, 4.0 * e.max_element()));
    }

    #[test]
    fn ycocg_comes_back(c in radiance()) {
        let back = rgb_from_ycocg(ycocg_from_rgb(c));
        prop_assert!(close(back, c, c.max_element()));
    }
}

#[test]
fn no_light_is_black() {
    assert_eq!(ShLight::default().irradiance(DVec3::X), DVec3::ZERO);
    assert_eq!(ShLight::encode(DVec3::X, DVec3::ONE).irradiance(DVec3::NEG_X), DVec3::ZERO);
}
