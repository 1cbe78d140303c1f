//! The medium of the god rays in whole frames: closed forms, and the reference, which draws the distance at which light is scattered.

use crate::common::{Mean, assert_same, frames_mean, params, polygon, reference_mean_with};
use glam::{DVec3, Vec3};
use pt_core::trace::TraceBackend;
use pt_gbuffer::images::GODRAYS;
use pt_reference::{MediumParams, ReferenceParams};
use pt_scene::{Camera, Environment, EnvironmentImage, Light, Material, Projection, Scene};
use pt_shaders::channels::{FLAT_COLOR, TRANSPARENT};
use pt_tests::{Frames, direct_light_only};
use std::f64::consts::PI;

const SIZE: [u32; 2] = [24, 18];
const LUX: Vec3 = Vec3::new(3.0, 2.0, 1.0);
const MEDIUM: MediumParams = MediumParams { density: 0.08, albedo: 0.7, anisotropy: 0.5, max_distance: 20.0 };

fn medium_sets(medium: MediumParams) -> Vec<String> {
    let MediumParams { density, albedo, anisotropy, max_distance } = medium;
    [("density", density), ("albedo", albedo), ("anisotropy", anisotropy), ("max_distance", max_distance)]
        .map(|(name, value)| format!("gbuffer.godrays.{name}={value}"))
        .to_vec()
}

fn with_medium(medium: MediumParams) -> pt_app::params::FrameParams {
    let sets = medium_sets(medium);
    params(&sets.iter().map(String::as_str).collect::<Vec<_>>())
}

fn reference(scene: &Scene, camera: &Camera, medium: MediumParams, spp: u32) -> Mean {
    let params = ReferenceParams { max_bounces: Some(1), spp, medium, ..ReferenceParams::default() };
    reference_mean_with(scene, camera, SIZE, params)
}

fn henyey_greenstein(cos_theta: f64, g: f64) -> f64 {
    (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cos_theta).powf(1.5))
}

/// A square around the origin in the plane z = 0, `half` metres to each side, that shines towards +Z.
fn shining_wall(scene: &mut Scene, half: f32, radiance: Vec3) {
    let corners = [(-half, -half), (half, -half), (half, half), (-half, half)];
    polygon(scene, &corners.map(|(x, y)| Vec3::new(x, y, 0.0)), Material::lamp("wall", radiance));
}

/// a p E (1 - exp(-s d)) and what is behind times exp(-s d), of frames and of the reference. All rays have the same length and direction. The light
/// of the sun is not in the way of anything; then it comes from below a floor that it does not pass.
#[test]
fn even_light_has_a_closed_form() {
    let radiance = Vec3::new(0.1, 0.2, 0.3);
    let towards = Vec3::new(0.3, 0.5, 0.7).normalize();
    for (distance, density, anisotropy) in [(5.0f32, 0.08f32, 0.5f32), (5.0, 1e-4, 0.9), (30.0, 0.12, -0.4)] {
        for below in [false, true] {
            let mut scene = Scene::default();
            shining_wall(&mut scene, 3.0, radiance);
            let towards = if below { towards * Vec3::new(1.0, -1.0, 1.0) } else { towards };
            scene.lights.push(Light::directional("sun", -towards, LUX));
            let floor = [(-99.0, -99.0), (-99.0, 99.0), (99.0, 99.0), (99.0, -99.0)];
            polygon(
                &mut scene,
                &floor.map(|(x, z)| Vec3::new(x, -2.0, z)),
                Material::lambertian("floor", Vec3::ZERO),
            );
            let eye = Vec3::new(0.0, 0.0, distance);
            let mut camera = Camera::look_at("straight", eye, Vec3::ZERO, 1.0);
            camera.projection = Projection::Orthographic { ymag: 0.5 };
            let medium = MediumParams { density, anisotropy, ..MEDIUM };

            let way = f64::from(distance.min(medium.max_distance));
            let left = (-f64::from(density) * way).exp();
            let phase = henyey_greenstein(f64::from(-towards.z), anisotropy.into());
            let scattered = LUX.as_dvec3() * (f64::from(medium.albedo) * phase * (1.0 - left));
            let arrives = f64::from(u8::from(!below));
            let exact = Mean { mean: scattered * arrives + radiance.as_dvec3() * left, error: DVec3::ZERO };
            let what = |who: &str| format!("{who}, {distance} m of density {density}, sun below: {below}");
            // fp16 distance to nothing: exp(-s d) of fp32 alone.
            let found = frames_mean(&scene, &camera, SIZE, 4, with_medium(medium));
            assert_same(&what("frames"), found, exact, 2e-5);
            let found = reference(&scene, &camera, medium, 256);
            assert_same(&what("reference"), found, exact, 1e-5);
        }
    }
}

/// A wall with a window, sunlight through it, its disc in the sky, and light of surfaces and of the sky behind the medium.
fn hall() -> (Scene, Camera) {
    let texels = (0..8 * 16).map(|i| Vec3::splat(0.3 - 0.02 * (i / 16) as f32)).collect();
    let image = EnvironmentImage { width: 16, height: 8, texels };
    let mut scene = Scene { environment: Environment::new(image), ..Scene::default() };
    let mut rectangle = |x: [f32; 2], y: [f32; 2]| {
        let corners = [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])];
        let corners = corners.map(|(x, y)| Vec3::new(x, y, 0.0));
        polygon(&mut scene, &corners, Material::lambertian("wall", Vec3::splat(0.4)));
    };
    rectangle([-9.0, -0.5], [0.0, 3.0]);
    rectangle([0.5, 9.0], [0.0, 3.0]);
    rectangle([-0.5, 0.5], [0.0, 1.0]);
    rectangle([-0.5, 0.5], [2.0, 3.0]);
    let floor = [(-9.0, -9.0), (-9.0, 9.0), (9.0, 9.0), (9.0, -9.0)].map(|(x, z)| Vec3::new(x, 0.0, z));
    polygon(&mut scene, &floor, Material::lambertian("floor", Vec3::splat(0.5)));
    let towards = Vec3::new(-0.1, 0.8, -1.2).normalize();
    scene.lights.push(Light { angular_radius: 0.03, ..Light::directional("sun", -towards, LUX) });
    scene.lights.push(Light::directional("moon", Vec3::new(-1.0, -0.4, 0.2), 0.3 * LUX));
    scene.validate().unwrap();
    let camera =
        Camera::look_at("against the light", Vec3::new(1.0, 1.5, 5.0), Vec3::new(0.0, 1.6, 0.0), 0.9);
    (scene, camera)
}

#[test]
fn frames_have_the_light_of_the_reference() {
    let (scene, camera) = hall();
    for medium in [MEDIUM, MediumParams { density: 0.5, anisotropy: -0.3, ..MEDIUM }] {
        let truth = reference(&scene, &camera, medium, 2048);
        let params = with_medium(medium);
        let found = frames_mean(&scene, &camera, SIZE, 256, params);
        // The filter moves light between pixels whose ways differ by a little.
        assert_same(&format!("density {}", medium.density), found, truth, 0.005);
    }
    // The medium is no trifle.
    let without = frames_mean(&scene, &camera, SIZE, 16, params(&[]));
    let with = frames_mean(&scene, &camera, SIZE, 16, with_medium(MEDIUM));
    assert!((with.mean / without.mean - 1.0).abs().max_element() > 0.1, "{with:?} {without:?}");
}

/// Without density there is no pass, no image, and no other bit, whatever the other knobs say.
#[test]
fn a_medium_of_no_density_is_absent() {
    let (scene, camera) = hall();
    let frame = |density: f32| {
        let mut params = direct_light_only();
        params.gbuffer.godrays.steps = 7;
        params.gbuffer.godrays.density = density;
        let mut frames =
            Frames::with_params(scene.clone(), &camera, TraceBackend::Compute, SIZE, 1, false, params);
        frames.render(0.0);
        let bits: Vec<u32> = frames.floats(FLAT_COLOR).iter().map(|v| v.to_bits()).collect();
        let has_image = frames.channels().contains(&GODRAYS);
        let finite = frames.floats(TRANSPARENT).iter().all(|v| v.is_finite());
        frames.finish();
        assert!(finite);
        (bits, has_image)
    };
    let plain = {
        let mut frames = Frames::with_params(
            scene.clone(),
            &camera,
            TraceBackend::Compute,
            SIZE,
            1,
            false,
            direct_light_only(),
        );
        frames.render(0.0);
        let bits: Vec<u32> = frames.floats(FLAT_COLOR).iter().map(|v| v.to_bits()).collect();
        frames.finish();
        bits
    };
    assert_eq!(frame(0.0), (plain.clone(), false));
    let (bits, has_image) = frame(10.0);
    assert!(has_image && bits != plain);
}
