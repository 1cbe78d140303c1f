//! `list_visibility=rays`: lists that know what is hidden have less noise and the same mean, also where the rays have missed a light.

use crate::common::view::{Surface, View, look};
use glam::{Affine3A, Vec3};
use pt_core::test_support::TestDevice;
use pt_light_sampling::records::ListVisibility;
use pt_light_sampling::test_support::polygon;
use pt_lights::DirectParams;
use pt_lights::records::LightRays;
use pt_scene::{Light, Material, Scene, builtin};
use pt_shaders::records::LightSampler;

fn params(sampler: LightSampler, list_visibility: ListVisibility) -> DirectParams {
    DirectParams { sampler, list_visibility, rays: LightRays::Merged, ..DirectParams::default() }
}

/// Of independent frames: the mean light of the picture with its standard error, and the variance of a pixel, averaged over the pixels.
fn measure(view: &mut View<'_>, frames: u32) -> [f64; 3] {
    let (mut totals, mut sums) = (Vec::new(), Vec::new());
    for _ in 0..frames {
        let light = view.frame();
        totals.push(light.iter().sum::<f64>() / light.len() as f64);
        sums.resize(light.len(), [0.0; 2]);
        sums.iter_mut().zip(&light).for_each(|(s, v)| *s = [s[0] + v, s[1] + v * v]);
    }
    let n = f64::from(frames);
    let mean = totals.iter().sum::<f64>() / n;
    let error = (totals.iter().map(|t| (t - mean).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt();
    let variance = sums.iter().map(|s| (s[1] - s[0] * s[0] / n) / (n - 1.0)).sum::<f64>();
    [mean, error, variance / sums.len() as f64]
}

fn entries(view: &View<'_>) -> usize {
    let lists = view.uploaded.lights.sampler().unwrap().lists().unwrap();
    lists.fixed.entries.len() + lists.changing.entries.len()
}

/// A flat of many rooms with lamps: most lamps are in other rooms.
#[test]
fn hidden_lamps_cost_no_samples() {
    const SIZE: [u32; 2] = [32, 18];
    let device = TestDevice::open();
    let scene = builtin("lamps").unwrap();
    let surfaces = look(&scene, &scene.cameras[0], SIZE);
    let [off, rays] = [ListVisibility::Off, ListVisibility::Rays].map(|visibility| {
        let params = params(LightSampler::ClusterCdf, visibility);
        let mut view = View::new(&device, scene.clone(), params, SIZE);
        view.show(&surfaces);
        (measure(&mut view, 96), entries(&view))
    });
    let ([mean, error, variance], all) = off;
    let ([seen_mean, seen_error, seen_variance], seen) = rays;
    println!("mean {mean:.4} +- {error:.4}, with rays {seen_mean:.4} +- {seen_error:.4}");
    println!("variance {variance:.4}, with rays {seen_variance:.4}; entries {all}, {seen}");
    let both = error.hypot(seen_error);
    assert!((mean - seen_mean).abs() < 4.0 * both && both < 0.05 * mean, "{mean} {seen_mean} +- {both}");
    assert!(variance > 4.0 * seen_variance, "{variance} {seen_variance}");
    assert!(all > 2 * seen, "{all} {seen}");
}

const SIDE: u32 = 16;

/// A floor below a board with a slit, through which a lamp shines that most rays from the floor do not meet; and weak lights below the board.
fn slit() -> (Scene, Vec<Option<Surface>>) {
    let mut scene = Scene::default();
    let mut rectangle = |[x0, x1]: [f32; 2], y: f32, material: Material| {
        let corners = [(x0, 2.0), (x1, 2.0), (x1, -2.0), (x0, -2.0)].map(|(x, z)| Vec3::new(x, y, z));
        polygon(&mut scene, &corners, Affine3A::IDENTITY, material);
    };
    rectangle([-2.0, 2.0], 0.0, Material::lambertian("floor", Vec3::splat(0.5)));
    let board = || Material { double_sided: true, ..Material::lambertian("board", Vec3::ONE) };
    rectangle([-2.0, -0.004], 1.0, board());
    rectangle([0.004, 2.0], 1.0, board());
    // Faces down: its corners turn the other way.
    rectangle([0.3, -0.3], 2.0, Material::lamp("lamp", Vec3::splat(2000.0)));
    for i in 0..6 {
        let position = Vec3::new(i as f32 * 0.5 - 1.2, 0.6, (i % 3) as f32 - 1.0);
        scene.lights.push(Light::point("weak", position, Vec3::splat(0.2)));
    }
    let surface = |i: u32| {
        let [x, z] = [i % SIDE, i / SIDE].map(|k| (k as f32 + 0.5) / SIDE as f32);
        let position = Vec3::new(0.5 * x - 0.25, 0.0, 3.6 * z - 1.8);
        Some(Surface { position, normal: Vec3::Y, to_viewer: Vec3::Y, material: 0 })
    };
    let surfaces = (0..SIDE * SIDE).map(surface).collect();
    (scene, surfaces)
}

/// What the estimate takes for hidden although it is not is found by the catch-all: the mean is that of a choice by power.
#[test]
fn what_the_rays_miss_is_not_lost() {
    let device = TestDevice::open();
    let (scene, surfaces) = slit();
    let view = |params| {
        let mut view = View::new(&device, scene.clone(), params, [SIDE; 2]);
        view.show(&surfaces);
        view
    };
    let mut exact = view(DirectParams { samples: 16, ..params(LightSampler::Power, ListVisibility::Off) });
    let [expected, expected_error, _] = measure(&mut exact, 96);
    exact.params.positional = false;
    let [lamp, ..] = measure(&mut exact, 32);
    assert!(lamp > 0.2 * expected, "the lamp gives {lamp} of {expected}");
    for sampler in [LightSampler::ClusterCdf, LightSampler::ClusterStats] {
        let params = DirectParams { samples: 4, ..params(sampler, ListVisibility::Rays) };
        let mut view = view(params);
        let lists = view.uploaded.lights.sampler().unwrap().lists().unwrap();
        let clusters = view.uploaded.gpu.clusters();
        // The lamp is two triangles, the first of the local lights.
        let missed = surfaces.iter().flatten().filter(|surface| {
            let cluster = clusters.find(surface.position) as usize;
            [0, 1].iter().any(|&light| lists.fixed.position(cluster, light).is_none())
        });
        let missed = missed.count();
        assert!(missed > surfaces.len() / 8, "the rays miss the lamp from {missed} points");
        let [mean, error, _] = measure(&mut view, 96);
        let both = error.hypot(expected_error);
        println!("{}: {mean:.5} of {expected:.5} +- {both:.5}; missed from {missed} points", sampler.name());
        assert!((mean - expected).abs() < 4.0 * both, "{}: {mean}, not {expected} +- {both}", sampler.name());
        assert!(both < 0.06 * expected, "{}: too noisy to tell: {both} of {expected}", sampler.name());
    }
}
