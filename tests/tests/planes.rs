//! Frames whose glass is decomposed into planes have the light of those that replace it by one surface, and of the reference.

use crate::common::{self, Mean, frames_mean, params, reference_mean};
use glam::{Affine3A, DVec3, Quat, Vec3};
use pt_app::params::FrameParams;
use pt_core::trace::TraceBackend;
use pt_image::image_file::LinearImage;
use pt_scene::{Camera, Environment, Light, Material, Scene};
use pt_shaders::channels::FLAT_COLOR;
use pt_tests::{Frames, builtin};

const SIZE: [u32; 2] = [32, 24];

fn in_planes(sets: &[&str]) -> FrameParams {
    params(&[sets, &["gbuffer.decomposition=planes"]].concat())
}

/// The mean over the pixels of each of the frames.
fn means(scene: &Scene, camera: &Camera, count: u32, params: FrameParams) -> Vec<DVec3> {
    let backend = TraceBackend::Compute;
    let mut frames = Frames::with_params(scene.clone(), camera, backend, SIZE, 17, false, params);
    let means = (0..count).map(|_| {
        frames.render(0.0);
        let pixels = frames.image(FLAT_COLOR).pixels;
        pixels.iter().map(|p| DVec3::from_array(p.map(f64::from))).sum::<DVec3>() / pixels.len() as f64
    });
    let means = means.collect();
    frames.finish();
    means
}

/// Mean and its standard error.
fn summary(values: &[DVec3]) -> Mean {
    let n = values.len() as f64;
    let mean = values.iter().sum::<DVec3>() / n;
    let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<DVec3>() / (n - 1.0);
    Mean { mean, error: (variance / n).map(f64::sqrt) }
}

/// Both decompositions trace the same camera rays with the same seed, so that their differences frame by frame are far less noisy than the frames.
fn assert_equal_light(name: &str, scene: &Scene, camera: &Camera, count: u32, most_error: f64) {
    let replacement = means(scene, camera, count, params(&[]));
    let planes = means(scene, camera, count, in_planes(&[]));
    let truth = summary(&replacement).mean;
    let differences: Vec<DVec3> = planes.iter().zip(&replacement).map(|(a, b)| a - b).collect();
    let off = summary(&differences);
    let z = off.mean / off.error;
    println!("{name}: off by {:.5} +- {:.5} of its light, Z = {z:.2}", off.mean / truth, off.error / truth);
    assert!(z.abs().max_element() < 4.0, "{name}: {off:?}");
    assert!(
        (off.error / truth).max_element() < most_error,
        "{name}: too much noise to say anything: {off:?}"
    );
}

#[test]
fn planes_have_the_light_of_the_replacement() {
    for (name, count, most_error) in [("glass", 192, 0.01), ("gallery", 96, 0.002)] {
        let scene = builtin(name);
        assert_equal_light(name, &scene, &scene.default_camera(), count, most_error);
    }
}

/// Glass with all lobes and an emission, smooth and rough, under a sky and a lamp that only highlights show, above a mirror.
fn milk() -> (Scene, Camera) {
    let mut scene =
        Scene { environment: Environment::constant(Vec3::new(0.5, 0.6, 0.8)), ..Scene::default() };
    scene.lights.push(Light::point("lamp", Vec3::new(1.5, 3.0, 3.0), Vec3::splat(8.0)));
    let corner = |x: f32, z: f32| Vec3::new(4.0 * x, -1.0, 4.0 * z);
    common::polygon(
        &mut scene,
        &[corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)],
        Material::metal("mirror", Vec3::new(0.9, 0.8, 0.7), 0.0),
    );
    let milk = Material {
        transmission: 0.5,
        base_color: Vec3::new(0.9, 0.6, 0.4).extend(1.0),
        emissive: Vec3::new(0.05, 0.1, 0.15),
        ..Material::solid("milk", 1.4)
    };
    let at = |x: f32| {
        let turn = Quat::from_rotation_y(0.4);
        Affine3A::from_scale_rotation_translation(Vec3::splat(0.7), turn, Vec3::new(x, -0.2, 0.0))
    };
    common::cube(&mut scene, at(-0.95), false, milk.clone());
    common::cube(&mut scene, at(0.95), false, Material { roughness: 0.5, ..milk });
    scene.validate().unwrap();
    (scene, Camera::look_at("front", Vec3::new(0.2, 1.1, 4.0), Vec3::new(0.0, -0.3, 0.0), 0.7))
}

#[test]
fn planes_of_milky_glass_have_its_light() {
    let (scene, camera) = milk();
    assert_equal_light("milk", &scene, &camera, 192, 0.01);
}

/// 0.98 to 1.02 of the reference, beside the noise of both.
#[test]
fn planes_have_the_light_of_the_reference() {
    let scene = builtin("glass");
    let camera = scene.default_camera();
    let found = frames_mean(&scene, &camera, SIZE, 192, in_planes(&["indirect.bounces=10"]));
    let truth = reference_mean(&scene, &camera, SIZE, 64, 384);
    let ratio = found.mean / truth.mean;
    for c in 0..3 {
        let error = found.error[c].hypot(truth.error[c]) / truth.mean[c];
        println!("{:.4} +- {error:.4} of the reference", ratio[c]);
        assert!(error < 0.01, "too much noise to say anything: {found:?}, {truth:?}");
        assert!((ratio[c] - 1.0).abs() < 0.02 + 2.0 * error, "{found:?}, {truth:?}");
    }
}

/// In motion, with all that keeps a history: each plane has its own, and a cut ends them all.
#[test]
fn planes_keep_histories_of_their_own() {
    let scene = builtin("glass");
    let camera = scene.cameras.iter().find(|camera| camera.path.is_some()).expect("a moving camera").clone();
    let mut images = Vec::new();
    for decomposition in ["replacement", "planes"] {
        let sets = [format!("gbuffer.decomposition={decomposition}"), "lights.sampler=restir-di".into()];
        let params = pt_app::params::resolve(Some("realtime"), &sets, false).unwrap();
        let backend = TraceBackend::Compute;
        let mut frames = Frames::with_params(scene.clone(), &camera, backend, [48, 32], 5, false, params);
        for index in 0..6 {
            frames.render(f64::from(index) / 30.0);
            assert!(frames.have_history().iter().all(|&history| history == (index > 0)));
        }
        let planes = if decomposition == "planes" { 2 } else { 1 };
        assert_eq!(frames.have_history().len(), planes);
        images.push(frames.image(FLAT_COLOR));
        frames.restart(6);
        frames.render(0.2);
        assert_eq!(frames.have_history(), vec![false; planes]);
        frames.finish();
    }
    let light = |image: &LinearImage| image.pixels.as_flattened().iter().map(|&v| f64::from(v)).sum::<f64>();
    let [replacement, planes] = [0, 1].map(|i| light(&images[i]));
    assert!(images[1].pixels.as_flattened().iter().all(|v| v.is_finite() && *v >= 0.0));
    // Denoised and of one frame: nearly the same light.
    assert!((planes / replacement - 1.0).abs() < 0.05, "{planes}, {replacement}");
}
