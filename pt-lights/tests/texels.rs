//! The light of each texel against the same estimate in double precision: candidates and BRDF of the oracles from the same random numbers,
//! multiple importance sampling, and visibility by brute force. And what their storage costs.

mod common;

use common::pixels::{Pixel, Rig};
use glam::{DMat3, DVec3, Vec3};
use pt_core::pack::{pack_unit_vector, unpack_unit_vector};
use pt_core::rng::{pcg4d, random4};
use pt_core::test_support::TestDevice;
use pt_light_sampling::LightLists;
use pt_light_sampling::oracle::brdf::Brdf;
use pt_light_sampling::oracle::lights::{LightSample, LightSampler};
use pt_light_sampling::oracle::sampling::basis_around;
use pt_light_sampling::test_support::all_kinds;
use pt_lights::DirectParams;
use pt_lights::oracle::{RGBE_SCALE, round_rgb9e5};
use pt_lights::records::LightStorage;
use pt_scene::{Environment, Scene};
use pt_shaders::channels::{COLOR_HF, COLOR_SPEC};
use pt_shaders::dimensions::{
    DIM_EMISSIVE, DIM_ENVIRONMENT, DIM_LIGHT_STORAGE, DIM_POSITIONAL, DIM_REFLECTION, DIM_SUN,
};

const SIZE: [u32; 2] = [32, 32];
const SEED: u32 = 5;

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

/// Diffuse and specular light of a pixel with one light sample.
fn estimate(lights: &LightSampler, hidden: &[[DVec3; 3]], [x, y]: [u32; 2], p: &Pixel) -> [DVec3; 2] {
    let base = p.base.map(f64::from);
    let metallic = (f64::from(p.metallic) * 65535.0).round() / 65535.0;
    let dielectric = (DVec3::splat(base[3]), (base[3] / 0.04).min(1.0));
    let color = DVec3::new(base[0], base[1], base[2]);
    let brdf = Brdf::new(color, dielectric, metallic, f64::from(p.roughness), false);
    let world_from_local: DMat3 = basis_around(p.normal.as_dvec3());
    let local = world_from_local.transpose();
    let v = local * p.view.as_dvec3();
    let bits = |dimension| pcg4d([x | y << 16, 0, dimension, SEED]);
    let reflects = p.roughness <= DirectParams::default().reflection_roughness;
    let mut sum = [DVec3::ZERO; 2];
    let mut add = |sample: Option<LightSample>, weight: &dyn Fn(&LightSample) -> f64| {
        let Some(sample) = sample.filter(|s| s.pdf > 0.0) else { return };
        let l = local * sample.direction;
        if l.z <= 0.0 || p.normal.as_dvec3().dot(sample.direction) <= 0.0 {
            return;
        }
        if is_hidden(hidden, p.position.as_dvec3(), &sample) {
            return;
        }
        let light = sample.radiance * (weight(&sample) * l.z / sample.pdf);
        let value = brdf.eval(v, l);
        sum[0] += value.diffuse * light;
        sum[1] += value.specular * light;
    };
    add(lights.sun(bits(DIM_SUN)), &|_| 1.0);
    add(lights.positional(p.position, bits(DIM_POSITIONAL)), &|_| 1.0);
    add(lights.emissive(p.position, bits(DIM_EMISSIVE)), &|_| 1.0);
    let reflected = |s: &LightSample| brdf.pdf(v, local * s.direction);
    let environment = lights.environment(bits(DIM_ENVIRONMENT));
    add(environment, &|s| if reflects { power_weight(s.pdf, reflected(s)) } else { 1.0 });
    let xi = bits(DIM_REFLECTION).map(|word| f64::from(word >> 8) / 16_777_216.0);
    if let Some(l) = brdf.sample(v, DVec3::new(xi[0], xi[1], xi[2])).filter(|_| reflects) {
        let direction = world_from_local * l;
        let pdf = brdf.pdf(v, l);
        let sample =
            LightSample { direction, pdf, radiance: RADIANCE.as_dvec3(), delta: false, target: None };
        add(Some(sample), &|s| power_weight(pdf, lights.environment_pdf(s.direction.as_vec3())));
    }
    let demodulation = brdf.f0.max(DVec3::splat(0.01));
    [sum[0], sum[1] / demodulation]
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
    let mut rig = Rig::new(&device, scene.clone(), SIZE, &DirectParams::default());
    rig.frame(0, SEED, &|p| Some(surface(p)));
    let channels = [COLOR_HF, COLOR_SPEC].map(|id| rig.texels(id));
    let (mut wrong, mut worst) = (Vec::new(), 0.0_f64);
    for i in 0..SIZE[0] * SIZE[1] {
        let at = [i % SIZE[0], i / SIZE[0]];
        let expected = estimate(&lights, &triangles, at, &surface(at));
        for (expected, texels) in expected.into_iter().zip(&channels) {
            let texel = Vec3::from_slice(&texels[i as usize]).as_dvec3();
            let error = (texel - expected).abs().max_element() / expected.max_element().max(1e-3);
            if error > 1e-4 {
                wrong.push((at, texel, expected));
            } else {
                worst = worst.max(error);
            }
        }
    }
    // fp32 takes another lobe, or another side of an edge, where a number is next to the limit.
    println!("{} of {} values differ, the others by up to {worst:.1e}", wrong.len(), 2 * SIZE[0] * SIZE[1]);
    assert!(wrong.len() <= 8, "{} values differ: {:?}", wrong.len(), &wrong[..wrong.len().min(8)]);
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
