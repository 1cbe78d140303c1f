//! The path tracer against closed forms.

use crate::common;
use crate::common::records::BsdfCase;
use crate::common::renders::{Stage, add_floor, add_mesh, add_sphere, assert_mean, glowing_sphere};
use glam::{DVec2, DVec3, Vec3, Vec4};
use pt_core::test_support::TestDevice;
use pt_reference::oracle::bsdf::Bsdf;
use pt_reference::{Heuristic, ReferenceParams, SamplerKind, Strategy};
use pt_scene::{Camera, Environment, Light, Lobes, Material, Scene};
use std::f32::consts::PI;
use std::f64::consts::FRAC_PI_2;

/// Looks down at a piece of the floor so small that its radiance is that of its middle.
fn down(x: f32, z: f32) -> Camera {
    Camera::look_at("down", Vec3::new(x, 1.0, z + 1e-3), Vec3::new(x, 0.0, z), 1e-3)
}

#[test]
fn inside_a_glowing_sphere() {
    let device = TestDevice::open();
    let camera = Camera::look_at("inside", Vec3::new(0.2, 0.1, 0.0), Vec3::X, 1.2);
    let mut stage = Stage::new(&device, glowing_sphere());
    // e / (1 - a) = 1, whatever the strategy and wherever the path begins.
    for (strategy, heuristic, sampler) in [
        (Strategy::Both, Heuristic::Power, SamplerKind::Sobol),
        (Strategy::Both, Heuristic::Balance, SamplerKind::Pcg),
        (Strategy::Lights, Heuristic::Power, SamplerKind::BlueNoise),
        (Strategy::Bsdf, Heuristic::Power, SamplerKind::Sobol),
    ] {
        let params = ReferenceParams { strategy, heuristic, sampler, spp: 32, ..Default::default() };
        let estimate = stage.render(&camera, [48, 48], &params, 1, 32);
        assert_mean(&estimate, 1.0, &format!("sphere, {strategy:?}, {heuristic:?}, {sampler:?}"));
    }
}

#[test]
fn a_few_bounces_inside_a_glowing_sphere() {
    let device = TestDevice::open();
    let camera = Camera::look_at("inside", Vec3::ZERO, Vec3::X, 1.0);
    let mut stage = Stage::new(&device, glowing_sphere());
    for bounces in 0..3 {
        let params = ReferenceParams { max_bounces: Some(bounces), ..Default::default() };
        let estimate = stage.render(&camera, [32, 32], &params, 2, 32);
        // Emission of the first hit, direct light, and one term for each bounce.
        let exact: f64 = (0..bounces + 2).map(|k| 0.5f64.powi(k as i32 + 1)).sum();
        assert_mean(&estimate, exact, &format!("{bounces} bounces"));
    }
}

#[test]
fn point_light_over_a_floor() {
    let device = TestDevice::open();
    let mut scene = Scene::default();
    add_floor(&mut scene, 50.0, Material::lambertian("floor", Vec3::splat(0.5)));
    scene.lights.push(Light::point("lamp", Vec3::new(0.0, 2.0, 0.0), Vec3::splat(100.0)));
    let mut stage = Stage::new(&device, scene);
    for (x, z) in [(0.0f32, 0.0f32), (1.5, -2.0), (7.0, 3.0)] {
        let r2 = f64::from(x * x + z * z);
        let exact = 0.5 / f64::from(PI) * 100.0 * 2.0 / (r2 + 4.0).powf(1.5);
        assert_mean(&stage.render(&down(x, z), [8, 8], &Default::default(), 0, 4), exact, "point light");
    }
}

#[test]
fn sun_over_a_floor() {
    let device = TestDevice::open();
    for angular_radius in [0.0, 0.00465, 0.2] {
        let mut scene = Scene::default();
        add_floor(&mut scene, 50.0, Material::lambertian("floor", Vec3::splat(0.5)));
        let sun = Light::directional("sun", Vec3::new(0.6, -0.8, 0.0), Vec3::splat(3.0));
        scene.lights.push(Light { angular_radius, ..sun });
        let mut stage = Stage::new(&device, scene);
        // The nominal lux are those of a surface that faces the sun; the cosine is linear over the disc.
        let exact = 0.5 / f64::from(PI) * 3.0 * 0.8;
        let estimate = stage.render(&down(0.0, 0.0), [64, 64], &Default::default(), 0, 16);
        assert_mean(&estimate, exact, &format!("sun of radius {angular_radius}"));
    }
}

/// A sphere in an environment of radiance 1; the image lies within its silhouette.
fn furnace(device: &TestDevice, material: Material) -> (Stage<'_>, Camera) {
    let mut scene = Scene { environment: Environment::constant(Vec3::ONE), ..Scene::default() };
    add_sphere(&mut scene, 1.0, 24, 1.0, material);
    (Stage::new(device, scene), Camera::look_at("furnace", Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, 0.2))
}

#[test]
fn lambertian_furnace() {
    let device = TestDevice::open();
    let (mut stage, camera) = furnace(&device, Material::lambertian("white", Vec3::ONE));
    assert_mean(&stage.render(&camera, [32, 32], &Default::default(), 0, 64), 1.0, "white furnace");
}

#[test]
fn metal_furnace_keeps_its_energy_with_compensation() {
    let device = TestDevice::open();
    for roughness in [0.0, 0.1, 0.3, 0.5, 0.7, 1.0] {
        let material = Material { base_color: Vec4::ONE, metallic: 1.0, roughness, ..Material::default() };
        let (mut stage, camera) = furnace(&device, material);
        let mean = |stage: &mut Stage<'_>, energy_compensation| {
            let params = ReferenceParams { energy_compensation, ..Default::default() };
            common::renders::image_mean(&stage.render(&camera, [48, 48], &params, 3, 16)).0.x
        };
        let (on, off) = (mean(&mut stage, true), mean(&mut stage, false));
        println!("roughness {roughness}: {on:.4} with energy compensation, {off:.4} without");
        assert!((on - 1.0).abs() < 0.01, "roughness {roughness}: {on}");
        assert!(off < 1.001 && (roughness < 0.6 || off < 0.95), "roughness {roughness} without: {off}");
    }
}

/// A floor under a white sky, along its normal and aslant: the directional albedo of its BSDF, by quadrature of the double precision twin.
#[test]
fn furnace_over_roughness_and_metalness() {
    let device = TestDevice::open();
    for (roughness, metallic) in
        [0.3f32, 0.6, 1.0].into_iter().flat_map(|r| [0.0f32, 0.5, 1.0].map(|m| (r, m)))
    {
        let mut scene = Scene { environment: Environment::constant(Vec3::ONE), ..Scene::default() };
        add_floor(
            &mut scene,
            50.0,
            Material { base_color: Vec4::ONE, metallic, roughness, ..Material::default() },
        );
        let mut stage = Stage::new(&device, scene);
        for (energy_compensation, cos) in [(false, 1.0f32), (false, 0.4), (true, 1.0), (true, 0.4)] {
            let wo = common::direction(cos, 0.0);
            let flags = if energy_compensation { common::ENERGY_COMPENSATION } else { 0 };
            let surface = common::oracle(&BsdfCase { metallic, flags, ..common::metal(roughness) });
            // The floor's +Y is the lobe's +Z.
            let camera = Camera::look_at("floor", 10.0 * Vec3::new(wo.x, wo.z, wo.y), Vec3::ZERO, 1e-3);
            let params = ReferenceParams { energy_compensation, ..Default::default() };
            // Many pixels rather than many samples of each: what a pass costs beside its threads would be most of the time.
            let estimate = stage.render(&camera, [64, 64], &params, 6, 32);
            let expected = albedo(&surface, wo.as_dvec3());
            assert_mean(
                &estimate,
                expected,
                &format!(
                    "roughness {roughness}, metalness {metallic}, cos {cos}, compensation {energy_compensation}"
                ),
            );
        }
    }
}

/// Integral of f cos over the hemisphere, which the plane of incidence halves; midpoints in polar angle and azimuth.
fn albedo(surface: &Bsdf, wo: DVec3) -> f64 {
    let (rows, columns) = (200, 200);
    let step = DVec2::new(FRAC_PI_2 / f64::from(rows), 2.0 * FRAC_PI_2 / f64::from(columns));
    let cell = |row: i32, column: i32| {
        let (theta, phi) = ((f64::from(row) + 0.5) * step.x, (f64::from(column) + 0.5) * step.y);
        let wi = DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
        surface.evaluate(wo, wi).f_cos.x * theta.sin()
    };
    (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))).map(|(r, c)| cell(r, c)).sum::<f64>()
        * 2.0
        * step.x
        * step.y
}

#[test]
fn glass_furnace() {
    // Clear glass neither takes nor gives: all that a path meets is the environment.
    let device = TestDevice::open();
    for roughness in [0.0, 0.3] {
        let (mut stage, camera) = furnace(&device, Material { roughness, ..Material::solid("glass", 1.5) });
        let estimate = stage.render(&camera, [24, 24], &Default::default(), 4, 64);
        let (mean, error) = common::renders::image_mean(&estimate);
        println!("glass of roughness {roughness}: {mean} +- {error}");
        // What single scattering loses between rough microfacets is lost.
        let least = if roughness == 0.0 { 1.0 - 3.0 * error.x - 1e-3 } else { 0.95 };
        assert!(mean.x > least && mean.x < 1.0 + 3.0 * error.x + 1e-3);
    }
}

#[test]
fn dispersion_keeps_energy() {
    let device = TestDevice::open();
    let lobes = Lobes { dispersion: 20.0 / 20.0, ..Lobes::default() };
    let diamond = Material { lobes: Some(Box::new(lobes)), ..Material::solid("diamond", 2.0) };
    let (mut stage, camera) = furnace(&device, diamond);
    let estimate = stage.render(&camera, [24, 24], &Default::default(), 4, 64);
    assert_mean(&estimate, 1.0, "dispersive furnace");
}

fn add_pane(scene: &mut Scene, y: f32, pane: Material) {
    let corners = [(-50.0, 50.0), (50.0, 50.0), (50.0, -50.0), (-50.0, -50.0)];
    let positions = corners.map(|(x, z)| Vec3::new(x, y, z)).to_vec();
    add_mesh(scene, positions, vec![Vec3::Y; 4], vec![[0, 1, 2], [0, 2, 3]], pane);
}

/// Where a floor lies under a large smooth thin pane, light without extent comes straight through it.
#[test]
fn sun_through_thin_glass() {
    let device = TestDevice::open();
    for (cos, ior) in [(1.0f32, 1.5f32), (0.6, 1.5), (0.8, 1.0)] {
        let mut scene = Scene::default();
        add_floor(&mut scene, 50.0, Material::lambertian("floor", Vec3::splat(0.5)));
        let pane = Material {
            thickness: 0.0,
            base_color: Vec4::new(0.3, 0.8, 0.3, 1.0),
            ..Material::solid("pane", ior)
        };
        add_pane(&mut scene, 3.0, pane);
        let direction = Vec3::new((1.0 - cos * cos).sqrt(), -cos, 0.0);
        scene.lights.push(Light::directional("sun", direction, Vec3::splat(3.0)));
        let mut stage = Stage::new(&device, scene);
        // One more vertex: as many surfaces may be passed.
        let params = ReferenceParams { max_bounces: Some(1), ..Default::default() };
        let estimate = stage.render(&down(0.0, 0.0), [8, 8], &params, 0, 4);
        let passed = 1.0 - pt_reference::oracle::dielectric::fresnel(cos.into(), ior.into());
        let exact = 0.5 / f64::from(PI) * 3.0 * f64::from(cos) * passed;
        let (mean, _) = common::renders::image_mean(&estimate);
        for (c, base) in [0.3, 0.8, 0.3].into_iter().enumerate() {
            assert!(
                (mean[c] / (exact * base) - 1.0).abs() < 1e-3,
                "{cos} {ior}: {mean} instead of {exact} x {base}"
            );
        }
        let blocked = ReferenceParams { max_bounces: Some(0), ..Default::default() };
        let estimate = stage.render(&down(0.0, 0.0), [8, 8], &blocked, 0, 4);
        assert_eq!(common::renders::image_mean(&estimate).0, DVec3::ZERO, "no vertex is left for the pane");
    }
}

/// Of an environment behind thin glass both strategies find the same light, and together they find it with less noise than the BSDF alone.
#[test]
fn environment_through_thin_glass() {
    let device = TestDevice::open();
    let mut scene = Scene { environment: Environment::constant(Vec3::ONE), ..Scene::default() };
    add_floor(&mut scene, 50.0, Material::lambertian("floor", Vec3::splat(0.5)));
    add_pane(&mut scene, 3.0, Material { thickness: 0.0, ..Material::solid("pane", 1.5) });
    let mut stage = Stage::new(&device, scene);
    let mut of = |strategy, seed| {
        let params = ReferenceParams { max_bounces: Some(2), strategy, ..Default::default() };
        common::renders::image_mean(&stage.render(&down(0.0, 0.0), [24, 24], &params, seed, 64))
    };
    let (bsdf, bsdf_error) = of(Strategy::Bsdf, 1);
    for (strategy, seed) in [(Strategy::Lights, 2), (Strategy::Both, 3)] {
        let (mean, error) = of(strategy, seed);
        println!("{strategy:?}: {mean} +- {error}, BSDF alone {bsdf} +- {bsdf_error}");
        assert!((mean - bsdf).abs().max_element() < 4.0 * error.x.hypot(bsdf_error.x), "{strategy:?}");
    }
}

#[test]
fn absorption_along_a_slab() {
    // Straight through a slab of index 1: exp(-sigma d) of the environment, by the colour at the attenuation distance.
    let device = TestDevice::open();
    let mut scene = Scene { environment: Environment::constant(Vec3::ONE), ..Scene::default() };
    let slab = Material {
        attenuation_color: Vec3::splat(0.25),
        attenuation_distance: 0.5,
        ..Material::solid("slab", 1.0)
    };
    let mut positions = Vec::new();
    let mut normals = Vec::new();
    let mut indices = Vec::new();
    for side in [1.0f32, -1.0] {
        let first = positions.len() as u32;
        for (x, y) in [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)] {
            positions.push(Vec3::new(x * side, y, 0.5 * side));
            normals.push(Vec3::Z * side);
        }
        indices.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    add_mesh(&mut scene, positions, normals, indices, slab);
    let mut stage = Stage::new(&device, scene);
    let camera = Camera::look_at("through", Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 1e-3);
    let inside = Camera::look_at("inside", Vec3::ZERO, Vec3::NEG_Z, 1e-3);
    // No noise at all: off by what the offset of the ray's origin takes from the metre.
    for (camera, expected) in [(camera, 0.0625), (inside, 0.25)] {
        for pixel in stage.render(&camera, [16, 16], &Default::default(), 0, 16).pixels {
            assert!((pixel.mean / expected - 1.0).abs().max_element() < 5e-5, "{}: {pixel:?}", camera.name);
        }
    }
}
