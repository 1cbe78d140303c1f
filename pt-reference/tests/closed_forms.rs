//! The integration against closed forms.

use glam::{Affine3A, DVec2, DVec3, Vec2, Vec3, Vec4};
use pt_reference::direct::{DirectError, DirectLight, Quality};
use pt_scene::{Camera, Environment, Instance, Light, Material, Mesh, Scene, builtin};
use std::f64::consts::PI;

fn polygon(scene: &mut Scene, corners: &[Vec3], material: Material) {
    let n = corners.len();
    let up = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
    scene.meshes.push(Mesh {
        name: "polygon".into(),
        positions: corners.to_vec(),
        normals: vec![up; n],
        tangents: vec![Vec4::X; n],
        uv0: vec![Vec2::ZERO; n],
        uv1: vec![Vec2::ZERO; n],
        colors: vec![Vec4::ONE; n],
        indices: (1..n as u32 - 1).map(|i| [0, i, i + 1]).collect(),
        triangle_materials: vec![scene.materials.len() as u32; n - 2],
        first_masked: n - 2,
        ..Mesh::default()
    });
    scene.materials.push(material);
    scene.instances.push(Instance::new("polygon", scene.meshes.len() as u32 - 1, Affine3A::IDENTITY));
}

fn square(y: f32, half: f32, up: bool) -> [Vec3; 4] {
    let corners =
        [(-half, half), (half, half), (half, -half), (-half, -half)].map(|(x, z)| Vec3::new(x, y, z));
    if up { corners } else { [corners[3], corners[2], corners[1], corners[0]] }
}

/// A white floor of 20 m.
fn floor() -> Scene {
    let mut scene = Scene::default();
    polygon(&mut scene, &square(0.0, 10.0, true), Material::lambertian("floor", Vec3::splat(0.5)));
    scene
}

/// Radiance of the floor at (x, 0, z), averaged over shifts of the grids.
fn floor_radiance(scene: &Scene, x: f64, z: f64) -> f64 {
    let light = DirectLight::new(scene, Quality { pixel: 1, emitter: 24, environment: 32 }).unwrap();
    let eye = DVec3::new(x + 0.3, 0.2, z - 0.1);
    let direction = (DVec3::new(x, 0.0, z) - eye).normalize();
    let shifts = (0..64).map(|k| (DVec2::new(0.7549, 0.5698) * f64::from(k)).fract());
    shifts.map(|shift| light.radiance(eye, direction, shift).x).sum::<f64>() / 64.0
}

fn assert_close(actual: f64, expected: f64, tolerance: f64) {
    assert!((actual / expected - 1.0).abs() < tolerance, "{actual} instead of {expected}");
}

#[test]
fn point_light_over_a_plane() {
    let scene = builtin("plane").unwrap();
    for (x, z) in [(0.0, 0.0), (1.5, -2.0), (30.0, 12.0)] {
        let r2 = f64::hypot(x, z).powi(2);
        assert_close(floor_radiance(&scene, x, z), 0.5 / PI * 100.0 * 2.0 / (r2 + 4.0f64).powf(1.5), 1e-6);
    }
    // The pixel in the middle of an even image borders on the axis; its mean differs from the foot's value by its size.
    let light = DirectLight::new(&scene, Quality::default()).unwrap();
    let pixel = light.pixel(&scene.cameras[1], [64, 64], 32, 32).unwrap();
    assert_close(pixel[1], 0.5 / PI * 100.0 / 4.0, 5e-3);
}

#[test]
fn sun_and_spot() {
    let mut scene = floor();
    scene.lights.push(Light::directional("sun", Vec3::new(0.0, -1.0, 1.0), Vec3::splat(2.0)));
    assert_close(floor_radiance(&scene, 0.0, 0.0), 0.5 / PI * 2.0 * 0.5f64.sqrt(), 1e-6);
    scene.lights[0] = Light::spot("spot", Vec3::Y * 2.0, Vec3::NEG_Y, 0.2, 0.6, Vec3::splat(4.0));
    assert_close(floor_radiance(&scene, 0.0, 0.0), 0.5 / PI * 4.0 / 4.0, 1e-6);
    // Half way between the cosines the attenuation is a quarter.
    let cos = 0.5 * (0.2f64.cos() + 0.6f64.cos());
    let distance = 2.0 / cos;
    let x = (distance * distance - 4.0).sqrt();
    assert_close(floor_radiance(&scene, x, 0.0), 0.5 / PI * 0.25 * 4.0 * cos / (distance * distance), 1e-5);
    assert_eq!(floor_radiance(&scene, 2.0, 0.0), 0.0);
}

/// Lambert's formula for the irradiance from a polygon of radiance 1: sum of angle x normal component over its edges.
fn lambert(point: DVec3, corners: &[Vec3]) -> f64 {
    let to = |i: usize| (corners[i % corners.len()].as_dvec3() - point).normalize();
    let edge = |i: usize| to(i).angle_between(to(i + 1)) * to(i).cross(to(i + 1)).normalize().y;
    0.5 * (0..corners.len()).map(edge).sum::<f64>().abs()
}

#[test]
fn rectangular_lamp() {
    let lamp = square(1.5, 0.4, false);
    let mut scene = floor();
    polygon(&mut scene, &lamp, Material::lamp("lamp", Vec3::splat(3.0)));
    for (x, z) in [(0.0, 0.0), (0.7, 0.2), (4.0, -3.0)] {
        let irradiance = 3.0 * lambert(DVec3::new(x, 0.0, z), &lamp);
        assert_close(floor_radiance(&scene, x, z), 0.5 / PI * irradiance, 2e-4);
    }
    // The camera sees the lamp from below, and a dark back from above.
    let light = DirectLight::new(&scene, Quality::default()).unwrap();
    let see = |eye: DVec3, direction: DVec3| light.radiance(eye, direction, DVec2::ZERO).x;
    assert_eq!(see(DVec3::Y, DVec3::Y), 3.0);
    assert_eq!(see(DVec3::Y * 2.0, DVec3::NEG_Y), 0.0);
    // From its back it lights nothing, unless it is double-sided.
    let mut turned = floor();
    polygon(&mut turned, &square(1.5, 0.4, true), Material::lamp("lamp", Vec3::splat(3.0)));
    assert_eq!(floor_radiance(&turned, 0.7, 0.2), 0.0);
    turned.materials[1].double_sided = true;
    assert_close(floor_radiance(&turned, 0.7, 0.2), floor_radiance(&scene, 0.7, 0.2), 2e-4);
}

/// A board that hides half of the lamp from the origin: exactly the other half's light is left.
#[test]
fn half_hidden_lamp() {
    let lamp = square(2.0, 0.4, false);
    let mut scene = floor();
    polygon(&mut scene, &lamp, Material::lamp("lamp", Vec3::splat(3.0)));
    let board = [(0.0, 1.0), (1.0, 1.0), (1.0, -1.0), (0.0, -1.0)].map(|(x, z)| Vec3::new(x, 1.0, z));
    polygon(&mut scene, &board, Material::lambertian("board", Vec3::ZERO));
    let irradiance = 0.5 * 3.0 * lambert(DVec3::ZERO, &lamp);
    assert_close(floor_radiance(&scene, 0.0, 0.0), 0.5 / PI * irradiance, 1e-2);
}

#[test]
fn furnace_and_open_sky() {
    let mut scene = floor();
    scene.environment = Environment::constant(Vec3::splat(2.0));
    assert_close(floor_radiance(&scene, 0.0, 0.0), 0.5 * 2.0, 1e-3);
    let light = DirectLight::new(&scene, Quality::default()).unwrap();
    assert_eq!(light.radiance(DVec3::Y, DVec3::new(0.0, 0.6, 0.8), DVec2::ZERO), DVec3::splat(2.0));
}

#[test]
fn what_is_not_covered_is_an_error() {
    let message = |scene: &Scene| match DirectLight::new(scene, Quality::default()) {
        Ok(_) => panic!("an error"),
        Err(e) => e.to_string(),
    };
    let mut scene = floor();
    scene.materials[0].specular = 1.0;
    assert!(message(&scene).contains("material floor: has a specular lobe"));
    let mut scene = floor();
    scene.lights.push(Light { radius: 0.1, ..Light::point("bulb", Vec3::Y, Vec3::ONE) });
    assert!(message(&scene).contains("light bulb"));
    let scene = floor();
    let camera = Camera { lens_radius: 0.1, ..Camera::look_at("lens", Vec3::Y, Vec3::ZERO, 1.0) };
    let light = DirectLight::new(&scene, Quality::default()).unwrap();
    assert!(matches!(light.pixel(&camera, [4, 4], 0, 0), Err(DirectError::Lens(name)) if name == "lens"));
}

/// Nine times the points on the lamp change no pixel of the box by more than 2 %, in the penumbras.
#[test]
fn cornell_has_converged() {
    let scene = builtin("cornell").unwrap();
    let camera = scene.default_camera();
    let fine = DirectLight::new(&scene, Quality { emitter: 12, ..Quality::default() }).unwrap();
    let light = DirectLight::new(&scene, Quality::default()).unwrap();
    let size = [12, 12];
    let (coarse, fine) = (light.image(&camera, size).unwrap(), fine.image(&camera, size).unwrap());
    let scale = fine.iter().map(|p| p[1]).filter(|&g| g < 1.0).sum::<f64>() / fine.len() as f64;
    for (i, (a, b)) in coarse.iter().zip(&fine).enumerate() {
        assert!((a[1] - b[1]).abs() < 0.02 * b[1].max(scale), "pixel {i}: {} and {}", a[1], b[1]);
    }
    assert!(scale > 0.02, "the box is lit: {scale}");
}
