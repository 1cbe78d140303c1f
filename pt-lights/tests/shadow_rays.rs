//! What the passes of direct lighting tell each other: packed light, the list of rays, glass, light samples, and the distance of the light.
//! Each texel's light against the oracle is in `texels.rs`.

use crate::common;
use crate::common::pixels::{Pixel, Rig};
use crate::common::records::PackedRecord;
use glam::{Affine3A, DVec3, Vec3};
use pt_core::rng::random4;
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_core::{Buffer, Kernel, Location, Recorder};
use pt_light_sampling::test_support::polygon;
use pt_lights::DirectParams;
use pt_lights::oracle::{pack_light, unpack_light};
use pt_lights::records::LightRays;
use pt_scene::{Light, Material, Scene};
use pt_shaders::channels::{COLOR_HF, COLOR_SPEC};
use pt_shaders::records::{GlassShadows, LightSampler};
use std::f64::consts::PI;

const SIZE: [u32; 2] = [32, 32];

/// The kernel's codes are those of the oracle; their error is within 2^-18 of the largest number, and of both signs alike.
#[test]
fn packed_light_keeps_its_mean() {
    let device = TestDevice::open();
    let mut cases: Vec<Vec3> = (0..30_000)
        .map(|i| {
            let ([a, b, c, d], [e, f, g, _]) = (random4([i, 0], 0, 0, 3), random4([i, 1], 0, 0, 3));
            // All exponents; the other two are up to 2^8 smaller or larger.
            let scale = (-117.0 + 235.0 * d).exp2();
            Vec3::new(a * scale, b * scale * (16.0 * e - 8.0).exp2(), c * scale * (16.0 * f - 8.0).exp2())
                * (1.0 + g)
        })
        .collect();
    let ordinary = cases.len();
    let just_below = |x: f32| f32::from_bits(x.to_bits() - 1);
    cases.extend([
        Vec3::ZERO,
        Vec3::MAX,
        Vec3::INFINITY,
        Vec3::new(f32::NAN, 2.0, -1.0),
        Vec3::new(f32::MIN_POSITIVE, 0.0, 0.0),
        // Rounded up to the next power of two.
        Vec3::new(just_below(1.0), 0.5, 0.25),
        Vec3::new(just_below(1e-37_f32.log2().floor().exp2()), 0.0, 0.0),
        Vec3::new(1e-3, 1e3, 1e30),
    ]);
    let kernel = Kernel::compute::<()>(&device, &common::kernels::PACK_LIGHT, &[]).unwrap();
    let from = Buffer::from_slice(&device, "cases", &cases).unwrap();
    let size = (cases.len() * size_of::<PackedRecord>()) as u64;
    let codes = Buffer::new(&device, "codes", size, Location::Device).unwrap();
    let mut recorder = Recorder::new(&device).unwrap();
    let mut frame = recorder.begin().unwrap();
    let pass = frame.pass("pack", &kernel).read("cases", &from).write("codes", &codes);
    pass.dispatch([cases.len() as u32, 1, 1]).unwrap();
    frame.submit().unwrap();
    let packed: Vec<PackedRecord> = codes.read().unwrap();
    let mut errors = Vec::new();
    for (i, (case, packed)) in cases.iter().zip(&packed).enumerate() {
        assert_eq!(packed.code.to_array(), pack_light(case.to_array()), "{case}");
        let [x, y, z] = unpack_light(packed.code.to_array());
        let expected = DVec3::new(x, y, z);
        // What lies below the smallest normal number may be flushed to 0.
        let exact = (packed.light.as_dvec3() - expected).abs().max_element() <= f64::from(f32::MIN_POSITIVE);
        assert!(packed.light.is_finite() && exact, "{case}: {} {expected}", packed.light);
        if i < ordinary {
            let case = case.as_dvec3();
            let error = (expected - case) / case.max_element();
            assert!(error.abs().max_element() <= (-18_f64).exp2(), "{case} {expected}");
            errors.extend(error.to_array());
        }
    }
    assert_eq!(packed[ordinary + 3].light, Vec3::new(0.0, 2.0, 0.0), "what is no light is dark");
    assert!(packed[ordinary + 2].light.min_element() > 3.4e38);
    let n = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / n;
    let deviation = (errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt();
    assert!(mean.abs() < 4.0 * deviation / n.sqrt(), "energy changes by {mean}");
    assert!(deviation > 1e-7, "{deviation}");
}

fn floor_pixel([x, y]: [u32; 2]) -> Pixel {
    let at = |k: u32| (k as f32 + 0.5) / 4.0 - 4.0;
    Pixel { position: Vec3::new(at(x), 0.0, at(y)), ..Pixel::LAMBERTIAN }
}

fn square(scene: &mut Scene, x: f32, height: f32, material: Material) {
    let corners = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
    let corners = corners.map(|(dx, z)| Vec3::new(x + dx, height, z * 9.0));
    polygon(scene, &corners, Affine3A::IDENTITY, material);
}

/// Part of unpolarised light that a surface of index 1.5 reflects (Fresnel).
fn fresnel(cos: f64) -> f64 {
    let eta = 1.5;
    let inside = (1.0 - (1.0 - cos * cos) / (eta * eta)).sqrt();
    let s = (cos - eta * inside) / (cos + eta * inside);
    let p = (eta * cos - inside) / (eta * cos + inside);
    0.5 * (s * s + p * p)
}

/// Thin glass before and behind a board, and alone, under a sun: on every backend, whatever of them a ray meets first.
#[test]
fn glass_tints_what_nothing_else_hides() {
    let device = TestDevice::open();
    let tint = Vec3::new(0.9, 0.6, 0.3);
    let glass = || Material {
        transmission: 1.0,
        base_color: tint.extend(1.0),
        ..Material::diffuse("glass", Vec3::ONE)
    };
    let board = || Material::lambertian("board", Vec3::ONE);
    let mut scene = Scene::default();
    let down = Vec3::new(0.0, -1.0, 0.6).normalize();
    scene.lights.push(Light::directional("sun", down, Vec3::splat(PI as f32)));
    // Stripes along the sun's direction: board alone, glass alone, glass below a board, glass above a board, two panes.
    square(&mut scene, -3.0, 1.0, board());
    square(&mut scene, -1.0, 1.0, glass());
    square(&mut scene, 1.0, 1.0, glass());
    square(&mut scene, 1.0, 2.0, board());
    square(&mut scene, 1.5, 3.0, glass());
    square(&mut scene, 3.5, 2.0, glass());
    square(&mut scene, 3.5, 1.0, glass());
    let cos = f64::from(-down.y);
    let pane = |n: i32| (tint.as_dvec3() * (1.0 - fresnel(cos))).powf(f64::from(n)) * cos;
    let expected = |x: f32, shadows: GlassShadows| {
        let open = DVec3::splat(cos);
        let (panes, hidden) = match x {
            x if x < -2.0 => (0, x > -4.0),
            x if x < 0.0 => (1, false),
            x if x < 2.0 => (1, true),
            x if x < 2.5 => (1, false),
            _ => (2, false),
        };
        match shadows {
            _ if hidden => DVec3::ZERO,
            GlassShadows::Passed => open,
            GlassShadows::Stopped if panes > 0 => DVec3::ZERO,
            _ => pane(panes),
        }
    };
    for backend in TraceBackend::available(&device) {
        // What needs no second ray is the same everywhere.
        let others = [GlassShadows::Passed, GlassShadows::Stopped];
        let others = others.into_iter().filter(|_| backend == TraceBackend::Compute);
        for shadows in others.chain([GlassShadows::Tinted]) {
            let params = DirectParams { glass_shadows: shadows, ..DirectParams::default() };
            let mut rig = Rig::with_backend(&device, scene.clone(), backend, SIZE, &params);
            rig.frame(0, 1, &|p| Some(floor_pixel(p)));
            for (i, texel) in (0..).zip(rig.texels(COLOR_HF)) {
                let x = floor_pixel([i % SIZE[0], i / SIZE[0]]).position.x;
                let expected = expected(x, shadows);
                let light = Vec3::from_slice(&texel).as_dvec3();
                assert!(
                    (light - expected).abs().max_element() < 2e-4,
                    "{backend} {shadows:?} {x}: {light} {expected}"
                );
                // Light that has come through glass has its distance too.
                assert_eq!(texel[3] > 1e17, expected != DVec3::ZERO, "{backend} {shadows:?} {x}");
            }
        }
    }
}

/// A frame of four light samples has the mean of four frames of one: no sample is lost, doubled or added to another texel. Neither is it
/// where the number of rays does not fill the last row of workgroups.
#[test]
fn light_samples_add_up() {
    let device = TestDevice::open();
    let mut scene = pt_light_sampling::test_support::all_kinds();
    square(&mut scene, 0.5, 1.2, Material::lambertian("board", Vec3::ONE));
    for (rays, size) in [(LightRays::PerKind, SIZE), (LightRays::Merged, [11, 7])] {
        // Does not learn from frame to frame.
        let sampler = LightSampler::LightBvh;
        let params = DirectParams { rays, sampler, ..DirectParams::default() };
        let shiny =
            |p: [u32; 2]| Some(Pixel { roughness: 0.25, base: [0.5, 0.4, 0.3, 0.04], ..floor_pixel(p) });
        let channels = [COLOR_HF, COLOR_SPEC];
        let mut rig = Rig::new(&device, scene.clone(), size, &params);
        let single: Vec<_> = (0..4)
            .map(|index| {
                rig.frame(index, 1, &shiny);
                channels.map(|id| rig.texels(id))
            })
            .collect();
        let mut rig = Rig::new(&device, scene.clone(), size, &DirectParams { samples: 4, ..params });
        rig.frame(0, 1, &shiny);
        for (channel, id) in channels.into_iter().enumerate() {
            for (i, texel) in rig.texels(id).into_iter().enumerate() {
                let of =
                    |c: usize| single.iter().map(|frame| f64::from(frame[channel][i][c])).collect::<Vec<_>>();
                for (c, &value) in texel[..3].iter().enumerate() {
                    let mean = of(c).iter().sum::<f64>() / 4.0;
                    let error = (f64::from(value) - mean).abs();
                    assert!(error <= 1e-5 * mean, "{rays:?} {i}: {value} {mean}");
                }
                // Their distances lie between those of the samples.
                let distances: Vec<f64> = of(3).into_iter().filter(|d| *d > 0.0).collect();
                let near = distances.iter().fold(f64::INFINITY, |a, b| a.min(*b)) * (1.0 - 1e-5);
                let far = distances.iter().fold(0.0, |a: f64, b| a.max(*b)) * (1.0 + 1e-5);
                let distance = f64::from(texel[3]);
                assert!(
                    distances.is_empty() && distance == 0.0 || (near..=far).contains(&distance),
                    "{i}: {distance}"
                );
            }
        }
    }
}

/// Alpha of the light channels under a lamp, a sun and both; and where a board hides the lamp.
#[test]
fn alpha_is_the_mean_distance_of_the_light() {
    let device = TestDevice::open();
    let at = Vec3::new(0.0, 2.0, 0.0);
    let lamp = Light::point("lamp", at, Vec3::splat(10.0));
    let sun = Light::directional("sun", Vec3::NEG_Y, Vec3::splat(3.0));
    let mut board = Scene::default();
    // Above half of the floor, so that the lamp is hidden there.
    square(&mut board, 2.0, 1.0, Material::lambertian("board", Vec3::ONE));
    let metal = |p| Pixel { metallic: 1.0, roughness: 1.0, base: [0.5, 0.5, 0.5, 0.04], ..floor_pixel(p) };
    for lights in [vec![], vec![lamp.clone()], vec![sun.clone()], vec![lamp, sun]] {
        let scene = Scene { lights: lights.clone(), ..board.clone() };
        let mut rig = Rig::new(&device, scene, SIZE, &DirectParams::default());
        for (pixel, id) in
            [(floor_pixel as fn([u32; 2]) -> Pixel, COLOR_HF), (metal as fn([u32; 2]) -> Pixel, COLOR_SPEC)]
        {
            rig.frame(0, 1, &|p| Some(pixel(p)));
            let (mut near, mut hidden) = (0, 0);
            for (i, texel) in (0..).zip(rig.texels(id)) {
                let p = pixel([i % SIZE[0], i / SIZE[0]]).position;
                let d = f64::from(p.distance(at));
                let has = |name: &str| lights.iter().any(|l| l.name == name);
                // The board spans x from 1 to 3 at half of the lamp's height.
                let lamp_is_seen = has("lamp") && !(p.x > 2.0 && p.x < 6.0);
                let sun_is_seen = has("sun") && !(p.x > 1.0 && p.x < 3.0);
                let expected = match (lamp_is_seen, sun_is_seen) {
                    (false, false) => 0.0,
                    (false, true) => 1e18,
                    (true, false) => d,
                    // Lambertian: the share of the lamp in the light follows from the irradiances.
                    (true, true) if id == COLOR_HF => {
                        let lamp = 10.0 * 2.0 / d.powi(3);
                        (lamp + 3.0) / (lamp / d)
                    }
                    (true, true) => {
                        assert!(f64::from(texel[3]) > d, "{p}");
                        continue;
                    }
                };
                near += u32::from(expected > 0.0 && expected < 1e17);
                hidden += u32::from(expected == 0.0);
                assert!(
                    (f64::from(texel[3]) - expected).abs() <= 1e-4 * expected,
                    "{p}: {} {expected}",
                    texel[3]
                );
            }
            assert!(near > 100 || !lights.iter().any(|l| l.name == "lamp") || id == COLOR_SPEC, "{near}");
            assert!(hidden > 50, "{hidden}");
        }
    }
}
