//! The light of each texel against the same estimate in double precision: candidates and BRDF of the oracles from the same random numbers,
//! multiple importance sampling, and visibility by brute force. And what their storage costs.

use crate::common::pixels::{Pixel, Rig};
use glam::{DMat3, DVec2, DVec3, Vec3};
use pt_core::pack::{pack_unit_vector, unpack_unit_vector};
use pt_core::rng::{pcg4d, random4};
use pt_core::test_support::TestDevice;
use pt_light_sampling::LightLists;
use pt_light_sampling::oracle::brdf::Brdf;
use pt_light_sampling::oracle::lights::{LightSample, LightSampler};
use pt_light_sampling::oracle::sampling::{basis_around, cosine_hemisphere_pdf, sample_cosine_hemisphere};
use pt_light_sampling::test_support::all_kinds;
use pt_lights::DirectParams;
use pt_lights::oracle::{RGBE_SCALE, round_rgb9e5};
use pt_lights::records::{LightRays, LightStorage};
use pt_scene::{Environment, Scene};
use pt_shaders::channels::{COLOR_HF, COLOR_SPEC};
use pt_shaders::dimensions::{
    DIM_COSINE, DIM_EMISSIVE, DIM_ENVIRONMENT, DIM_LIGHT_STORAGE, DIM_POSITIONAL, DIM_REFLECTION, DIM_SUN,
};

const SIZE: [u32; 2] = [32, 32];
const SEED: u32 = 5;
/// The default of `cosine_share`, in 16 bits.
const COSINE_SHARE: f64 = 32768.0 / 65535.0;

/// Triangles of a scene in world space.
fn triangles(scene: &Scene) -> Vec<[DVec3; 3]> {
    let of = |instance: &pt_scene::Instance| {
        let mesh = &scene.meshes[instance.mesh as usize];
        let world = instance.world_from_object;
        let corners = |t| mesh.triangle(t).map(|p| world.transform_point3(p).as_dvec3());
        (0..mesh.triangle_count()).map(corners).collect::<Vec<_>>()
    };
    scene.instances.iter().flat_map(of).collect()
}

/// Whether one of them lies between the point and the sample.
fn is_hidden(triangles: &[[DVec3; 3]], from: DVec3, sample: &LightSample) -> bool {
    let d = sample.direction;
    let end = sample.target.map_or(f64::INFINITY, |target| from.distance(target) * (1.0 - 1e-5));
    triangles.iter().any(|&[a, b, c]| {
        let (e1, e2) = (b - a, c - a);
        let p = d.cross(e2);
        let determinant = e1.dot(p);
        let s = from - a;
        let (u, q) = (s.dot(p) / determinant, s.cross(e1));
        let (v, t) = (d.dot(q) / determinant, e2.dot(q) / determinant);
        u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 1e-5 && t < end
    })
}

fn power_weight(pdf: f64, other: f64) -> f64 {
    1.0 / (1.0 + (other / pdf).powi(2))
}

/// What the channels hold of a surface.
fn surface([x, y]: [u32; 2]) -> Pixel {
    let unit = |k: u32| random4([x, y], 7, k, 1);
    let ([a, b, c, d], [e, f, g, h]) = (unit(0), unit(1));
    let [sin, cos] = [(1.0 - (0.25 + 0.75 * g).powi(2)).sqrt(), 0.25 + 0.75 * g];
    let phi = std::f32::consts::TAU * h;
    let unorm = |v: f32| (v * 65535.0).round() / 65535.0;
    let stored = |v: Vec3| unpack_unit_vector(pack_unit_vector(v.normalize()));
    Pixel {
        position: Vec3::new(0.12 * x as f32 - 2.0, 0.0, 0.12 * y as f32 - 2.0),
        normal: stored(Vec3::new(0.2 * a - 0.1, 1.0, 0.2 * b - 0.1)),
        view: stored(Vec3::new(sin * phi.cos(), cos, sin * phi.sin())),
        base: [a, b, c, 0.04 * d].map(unorm),
        metallic: (3.0 * e).floor() / 2.0,
        // On both sides of the roughness up to which reflections look for the environment.
        roughness: unorm(0.2 + 0.4 * f),
        ..Pixel::LAMBERTIAN
    }
}

/// A pixel's surface in double precision.
#[derive(Clone, Copy)]
struct Point {
    position: DVec3,
    normal: DVec3,
    view: DVec3,
    base: [f64; 4],
    metallic: f64,
    roughness: f64,
    reflects: bool,
}

impl Point {
    fn of(p: &Pixel) -> Self {
        Self {
            position: p.position.as_dvec3(),
            normal: p.normal.as_dvec3(),
            view: p.view.as_dvec3(),
            base: p.base.map(f64::from),
            metallic: (f64::from(p.metallic) * 65535.0).round() / 65535.0,
            roughness: f64::from(p.roughness),
            reflects: p.roughness <= DirectParams::default().reflection_roughness,
        }
    }
}

/// Diffuse and specular light of a pixel with one light sample.
fn estimate(lights: &LightSampler, hidden: &[[DVec3; 3]], [x, y]: [u32; 2], p: &Point) -> [DVec3; 2] {
    let Point { position, normal, base, metallic, reflects, .. } = *p;
    let dielectric = (DVec3::splat(base[3]), (base[3] / 0.04).min(1.0));
    let color = DVec3::new(base[0], base[1], base[2]);
    let brdf = Brdf::new(color, dielectric, metallic, p.roughness, false);
    let world_from_local: DMat3 = basis_around(normal);
    let local = world_from_local.transpose();
    let v = local * p.view;
    let bits = |dimension| pcg4d([x | y << 16, 0, dimension, SEED]);
    let mut sum = [DVec3::ZERO; 2];
    let mut add = |sample: Option<LightSample>, weight: &dyn Fn(&LightSample) -> f64| {
        let Some(sample) = sample.filter(|s| s.pdf > 0.0) else { return };
        let l = local * sample.direction;
        if l.z <= 0.0 || normal.dot(sample.direction) <= 0.0 {
            return;
        }
        if is_hidden(hidden, position, &sample) {
            return;
        }
        let light = sample.radiance * (weight(&sample) * l.z / sample.pdf);
        let value = brdf.eval(v, l);
        sum[0] += value.diffuse * light;
        sum[1] += value.specular * light;
    };
    add(lights.sun(bits(DIM_SUN)), &|_| 1.0);
    add(lights.positional(position.as_vec3(), bits(DIM_POSITIONAL)), &|_| 1.0);
    add(lights.emissive(position.as_vec3(), bits(DIM_EMISSIVE)), &|_| 1.0);
    let reflected = |s: &LightSample| brdf.pdf(v, local * s.direction);
    // The environment by its radiance, or by the cosine: the density is that of both.
    let environment_pdf = |direction: DVec3, by_radiance: f64| {
        let by_cosine = cosine_hemisphere_pdf(normal.dot(direction));
        COSINE_SHARE * by_cosine + (1.0 - COSINE_SHARE) * by_radiance
    };
    let unit = |dimension| bits(dimension).map(|word| f64::from(word >> 8) / 16_777_216.0);
    let xi = unit(DIM_COSINE);
    let environment = if xi[0] < COSINE_SHARE {
        let direction = world_from_local * sample_cosine_hemisphere(DVec2::new(xi[1], xi[2]));
        let pdf = environment_pdf(direction, lights.environment_pdf(direction.as_vec3()));
        Some(LightSample { direction, pdf, radiance: RADIANCE.as_dvec3(), delta: false, target: None })
    } else {
        let by_radiance = lights.environment(bits(DIM_ENVIRONMENT));
        by_radiance.map(|s| LightSample { pdf: environment_pdf(s.direction, s.pdf), ..s })
    };
    add(environment, &|s| if reflects { power_weight(s.pdf, reflected(s)) } else { 1.0 });
    let xi = unit(DIM_REFLECTION);
    if let Some(l) = brdf.sample(v, DVec3::new(xi[0], xi[1], xi[2])).filter(|_| reflects) {
        let direction = world_from_local * l;
        let pdf = brdf.pdf(v, l);
        let sample =
            LightSample { direction, pdf, radiance: RADIANCE.as_dvec3(), delta: false, target: None };
        let by_radiance = lights.environment_pdf(direction.as_vec3());
        add(Some(sample), &|s| power_weight(pdf, environment_pdf(s.direction, by_radiance)));
    }
    let demodulation = brdf.f0.max(DVec3::splat(0.01));
    [sum[0], sum[1] / demodulation]
}

/// Roundings of about 30 operations in a row: the relative error of what fp32 makes of a number.
const ROUNDING: f64 = 1.0 / (1 << 21) as f64;

/// How many values of a frame may differ. A value differs where a decision (a lobe, the side of an edge, a horizon) hangs on the last digits of a
/// number, or where a narrow lobe magnifies them. How often that happens follows from the oracle alone: it is asked again with the
/// pixel's position, directions and roughness changed by the roundings of fp32, and the values that change are counted. The number in
/// one frame is then Poisson distributed; the bar is exceeded with a probability of 1e-4. Also returns the mean.
fn allowed_differences(
    lights: &LightSampler,
    triangles: &[[DVec3; 3]],
    exact: &[[DVec3; 2]],
) -> (usize, f64) {
    const ROUNDS: u32 = 16;
    let mut changed = 0;
    for round in 0..ROUNDS {
        for (i, exact) in (0..).zip(exact) {
            let at = [i % SIZE[0], i / SIZE[0]];
            let unit = |k: u32| random4(at, round, k, 99).map(|x| 2.0 * f64::from(x) - 1.0);
            let shake = |v: Vec3, [x, y, z, _]: [f64; 4]| {
                v.as_dvec3() + ROUNDING * v.as_dvec3().abs().max_element().max(1e-3) * DVec3::new(x, y, z)
            };
            let pixel = surface(at);
            let point = Point {
                position: shake(pixel.position, unit(0)),
                normal: shake(pixel.normal, unit(1)).normalize(),
                view: shake(pixel.view, unit(2)).normalize(),
                roughness: f64::from(pixel.roughness) * (1.0 + ROUNDING * unit(3)[0]),
                ..Point::of(&pixel)
            };
            let again = estimate(lights, triangles, at, &point);
            changed += again.iter().zip(exact).filter(|(again, exact)| differs(**again, **exact)).count();
        }
    }
    // Two standard errors above the mean that the rounds have.
    let mean = (f64::from(changed as u32) + 2.0 * f64::from(changed as u32).sqrt() + 2.0) / f64::from(ROUNDS);
    let (mut bar, mut term, mut below) = (0, (-mean).exp(), (-mean).exp());
    while 1.0 - below > 1e-4 {
        bar += 1;
        term *= mean / bar as f64;
        below += term;
    }
    (bar, mean)
}

/// By more than roundings of the sum explain.
fn differs(value: DVec3, expected: DVec3) -> bool {
    (value - expected).abs().max_element() / expected.max_element().max(1e-3) > 1e-4
}

/// Of the environment: constant, because texture units interpolate with 8 bits.
const RADIANCE: Vec3 = Vec3::new(0.3, 0.5, 0.7);

#[test]
fn every_texel_equals_the_oracle() {
    let device = TestDevice::open();
    let mut scene = all_kinds();
    scene.environment = Environment::constant(RADIANCE);
    let lists = LightLists::new(&scene);
    let lights = LightSampler::new(&scene, &lists);
    let triangles = triangles(&scene);
    let params = DirectParams { rays: LightRays::PerKind, ..DirectParams::default() };
    let mut rig = Rig::new(&device, scene.clone(), SIZE, &params);
    rig.frame(0, SEED, &|p| Some(surface(p)));
    let channels = [COLOR_HF, COLOR_SPEC].map(|id| rig.texels(id));
    let places = || (0..SIZE[0] * SIZE[1]).map(|i| [i % SIZE[0], i / SIZE[0]]);
    let exact: Vec<[DVec3; 2]> =
        places().map(|at| estimate(&lights, &triangles, at, &Point::of(&surface(at)))).collect();
    let (bar, mean) = allowed_differences(&lights, &triangles, &exact);
    let mut wrong = Vec::new();
    for (i, (at, expected)) in places().zip(&exact).enumerate() {
        for (&expected, texels) in expected.iter().zip(&channels) {
            let texel = Vec3::from_slice(&texels[i]).as_dvec3();
            if differs(texel, expected) {
                wrong.push((at, texel, expected));
            }
        }
    }
    let count = wrong.len();
    println!("{count} of {} values differ; {mean:.2} are expected, at most {bar} allowed", 2 * exact.len());
    assert!(count <= bar, "{count} values differ, of {bar}: {:?}", &wrong[..count.min(8)]);
    // A fault of one texel in a hundred is found.
    assert!(bar < exact.len() / 100, "{bar}");
}

/// `storage=rgbe` rounds every texel as the oracle does, and the light of the frame stays; rounding to the nearest would lose some of it.
#[test]
fn storage_keeps_the_energy() {
    let device = TestDevice::open();
    let mut scene = all_kinds();
    // Saturated light, whose blue has few bits left.
    scene.environment = Environment::constant(Vec3::new(1.0, 0.1, 8e-4));
    let channels = [(COLOR_HF, DIM_LIGHT_STORAGE), (COLOR_SPEC, DIM_LIGHT_STORAGE + 1)];
    let only_sky = DirectParams { sun: false, positional: false, emissive: false, ..DirectParams::default() };
    let light = |storage| {
        let mut rig = Rig::new(&device, scene.clone(), SIZE, &DirectParams { storage, ..only_sky.clone() });
        (0..4)
            .map(|index| {
                rig.frame(index, SEED, &|p| Some(surface(p)));
                channels.map(|(id, _)| rig.texels(id))
            })
            .collect::<Vec<_>>()
    };
    let (exact, stored) = (light(LightStorage::Fp32), light(LightStorage::Rgbe));
    for (channel, (id, dimension)) in channels.into_iter().enumerate() {
        let name = id.channel().name;
        let mut sums = [[0.0_f64; 3]; 3];
        let mut variance = [0.0_f64; 3];
        for (index, (exact, stored)) in (0..).zip(exact.iter().zip(&stored)) {
            for (i, (exact, stored)) in (0..).zip(exact[channel].iter().zip(&stored[channel])) {
                assert_eq!(exact[3], stored[3], "{name}: the distance is not stored with fewer bits");
                let scaled = [0, 1, 2].map(|c| exact[c] * RGBE_SCALE);
                let [a, b, c, _] = random4([i % SIZE[0], i / SIZE[0]], index, dimension, SEED);
                let expected = round_rgb9e5(scaled, [a, b, c]);
                let nearest = round_rgb9e5(scaled, [0.5; 3]);
                let unit = f64::from(scaled.into_iter().fold(2e-5, f32::max)) / 256.0;
                for c in 0..3 {
                    assert_eq!(stored[c] * RGBE_SCALE, expected[c], "{name} {i}: {exact:?}");
                    sums[0][c] += f64::from(scaled[c]);
                    sums[1][c] += f64::from(expected[c]);
                    sums[2][c] += f64::from(nearest[c]);
                    // At most that of one bit.
                    variance[c] += unit * unit / 4.0;
                }
            }
        }
        for c in 0..3 {
            let [rounded, nearest] = [1, 2].map(|of: usize| sums[of][c] / sums[0][c] - 1.0);
            let error = variance[c].sqrt() / sums[0][c];
            println!(
                "{name}, component {c}: energy changes by {rounded:+.1e} +- {error:.1e}; nearest {nearest:+.1e}"
            );
            assert!(rounded.abs() < 4.0 * error, "{name} {c}: {rounded} +- {error}");
            if channel == 0 && c == 2 {
                assert!(
                    error < 0.1 && nearest.abs() > 4.0 * error,
                    "the test is too weak: {nearest} +- {error}"
                );
            }
        }
    }
}
