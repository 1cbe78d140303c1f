//! The discs of directional lights in the picture: in the sky, in mirrors, through glass. Each of them is there once.

use crate::common::{Mean, assert_same, cube, frames_mean, params, polygon, reference_mean};
use glam::{Affine3A, DVec3, Vec3};
use pt_core::trace::TraceBackend;
use pt_scene::{Camera, Light, Material, Scene};
use pt_shaders::channels::{DISPLAY, FLAT_COLOR};
use pt_tests::Frames;
use std::f64::consts::PI;

const SIZE: [u32; 2] = [24, 24];
const LUX: Vec3 = Vec3::new(3.0, 2.5, 2.0);

/// A sun in this direction and with this angular radius, radians.
fn sun(towards: Vec3, angular_radius: f32) -> Light {
    Light { angular_radius, ..Light::directional("sun", -towards, LUX) }
}

/// A square in the plane z = 0.
fn square(scene: &mut Scene, material: Material) {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| Vec3::new(x, y, 0.0));
    polygon(scene, &corners, material);
}

/// The camera sees the whole disc: straight, or by way of what it looks at.
#[test]
fn frames_show_the_suns_disc_as_the_reference() {
    let ahead = Vec3::new(0.15, 0.2, -1.0).normalize();
    let mirrored = Vec3::new(ahead.x, ahead.y, -ahead.z);
    let camera = Camera::look_at("sun", -2.0 * ahead, Vec3::ZERO, 0.3);
    let pane = |roughness: f32| Material { roughness, thickness: 0.0, ..Material::solid("pane", 1.5) };
    let behind = |material: Option<Material>| {
        let mut scene = Scene { lights: vec![sun(ahead, 0.08)], ..Scene::default() };
        material.into_iter().for_each(|material| square(&mut scene, material));
        scene
    };
    let block = |roughness: f32| {
        let mut scene = behind(None);
        let place = Affine3A::from_scale(Vec3::new(2.0, 2.0, 0.2));
        cube(&mut scene, place, false, Material { roughness, ..Material::solid("block", 1.5) });
        scene
    };
    let mut mirror = Scene { lights: vec![sun(mirrored, 0.08)], ..Scene::default() };
    square(&mut mirror, Material::metal("mirror", Vec3::new(0.9, 0.7, 0.5), 0.0));
    // Two suns side by side, one of which has no disc.
    let mut two = behind(None);
    two.lights.push(sun((ahead + Vec3::new(0.12, 0.0, 0.0)).normalize(), 0.05));
    two.lights.push(sun(ahead, 0.0));
    let scenes = [
        ("sky", behind(None)),
        ("two suns", two),
        ("mirror", mirror),
        ("clear pane", behind(Some(pane(0.0)))),
        ("rough pane", behind(Some(pane(0.3)))),
        ("clear block", block(0.0)),
    ];
    for (what, scene) in scenes {
        scene.validate().unwrap();
        let truth = reference_mean(&scene, &camera, SIZE, 10, 256);
        // 16 bits of base colour, and fp16 throughput.
        assert_same(what, frames_mean(&scene, &camera, SIZE, 64, params(&[])), truth, 1e-3);
    }
}

/// E = L pi sin^2(radius), whatever the radius.
#[test]
fn the_disc_has_the_radiance_of_its_illuminance() {
    let ahead = Vec3::new(0.15, 0.2, -1.0).normalize();
    for radius in [0.00465, 0.3] {
        let scene = Scene { lights: vec![sun(ahead, radius)], ..Scene::default() };
        let camera = Camera::look_at("sun", Vec3::ZERO, ahead, radius);
        let radiance = LUX.as_dvec3() / (PI * f64::from(radius).sin().powi(2));
        let exact = Mean { mean: radiance, error: DVec3::ZERO };
        let found = frames_mean(&scene, &camera, [8, 8], 4, params(&[]));
        assert_same(&format!("radius {radius}"), found, exact, 1e-5);
    }
}

/// A sun of 1e9 cd/m2 and more in the picture, whose radiance images of 16-bit floats can't hold.
#[test]
fn a_sun_beyond_all_measure_leaves_the_picture_finite() {
    let ahead = Vec3::new(0.15, 0.2, -1.0).normalize();
    // The last one has no finite radiance.
    for lux in [2e6, 1e14, 1e34] {
        let light = Light { intensity: Vec3::splat(lux), ..sun(ahead, 0.02) };
        let mut scene = Scene { lights: vec![light], ..Scene::default() };
        let floor = [(-9.0, -9.0), (-9.0, 9.0), (9.0, 9.0), (9.0, -9.0)].map(|(x, z)| Vec3::new(x, -1.0, z));
        polygon(&mut scene, &floor, Material::diffuse("floor", Vec3::splat(0.5)));
        let camera = Camera::look_at("sun", Vec3::ZERO, ahead, 0.6);
        let sets = ["post.bloom.mode=gaussian", "post.bloom.mode=chain"];
        for bloom in sets {
            let sets = [bloom.to_owned()];
            let params = pt_app::params::resolve(Some("realtime"), &sets, false).unwrap();
            let mut frames = Frames::with_params(
                scene.clone(),
                &camera,
                TraceBackend::Compute,
                [40, 40],
                1,
                false,
                params,
            );
            for _ in 0..3 {
                frames.render(0.0);
            }
            let brightest = frames.image(FLAT_COLOR).pixels.iter().fold(0.0f32, |m, p| m.max(p[1]));
            let shown = frames.image(DISPLAY).pixels;
            let post: Vec<_> = frames.channels().into_iter().filter(|id| !id.is_contract()).collect();
            for id in post.iter().filter(|id| !id.channel().format.is_uint()) {
                let values = frames.floats(*id);
                assert!(values.iter().all(|v| v.is_finite()), "{lux} lux, {bloom}: {}", id.full_name());
            }
            frames.finish();
            assert!(brightest > lux / 2e-3, "{lux} lux: the disc is in the picture: {brightest:e}");
            let brightest = shown.iter().fold(0.0f32, |m, p| m.max(p[1]));
            println!("{lux} lux, {bloom}: {brightest} {}", shown[0][1]);
            assert!(
                brightest > 0.2 && shown[0][1] < 0.05,
                "{lux} lux, {bloom}: {brightest} beside {}",
                shown[0][1]
            );
        }
    }
}
