//! The ways in which the path tracer picks lights: the same mean, another noise.

use crate::common::renders::{Stage, add_floor, assert_mean, glowing_sphere};
use glam::{Affine3A, DVec3, Vec3};
use pt_core::Error;
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_light_sampling::LightTables;
use pt_reference::records::PathLights;
use pt_reference::{Estimate, Progressive, ReferenceParams, SamplerKind};
use pt_scene::gpu::{GpuScene, camera_record};
use pt_scene::{Camera, Light, Material, Scene, builtin};
use pt_shaders::records::FrameRecord;

const SIZE: [u32; 2] = [32, 32];

/// Largest difference of two estimates over blocks of 16 x 16 pixels, and that of the whole, in standard errors; and the whole's relative one.
fn differences(a: &Estimate, b: &Estimate) -> [f64; 3] {
    let sums = |estimate: &Estimate, inside: &dyn Fn(u32) -> bool| {
        let pixels = estimate.pixels.iter().enumerate().filter(|(i, _)| inside(*i as u32));
        pixels.fold((DVec3::ZERO, DVec3::ZERO), |(mean, variance), (_, p)| {
            (mean + p.mean.as_dvec3(), variance + p.variance.as_dvec3())
        })
    };
    let deviation = |inside: &dyn Fn(u32) -> bool| {
        let [(mean_a, variance_a), (mean_b, variance_b)] = [a, b].map(|e| sums(e, inside));
        let error = (variance_a + variance_b).map(|v| v.sqrt().max(1e-9));
        (((mean_a - mean_b) / error).abs().max_element(), (error / mean_b).max_element())
    };
    let block = |i: u32| (i / SIZE[0] / 16) * (SIZE[0] / 16) + i % SIZE[0] / 16;
    let blocks = (0..SIZE[0] / 16 * (SIZE[1] / 16)).map(|b| deviation(&|i| block(i) == b).0);
    let (whole, error) = deviation(&|_| true);
    [blocks.fold(0.0, f64::max), whole, error]
}

/// Median over the pixels: edges of lamps and fireflies do not count.
fn noise(estimate: &Estimate) -> f64 {
    let mut variances: Vec<f32> = estimate.pixels.iter().map(|p| p.variance.element_sum()).collect();
    variances.sort_by(f32::total_cmp);
    f64::from(variances[variances.len() / 2])
}

/// Renders with every way to pick lights; checks the means and returns the noise.
fn compare(scene: Scene, camera: &Camera, spp: u32, what: &str) -> Vec<(PathLights, f64)> {
    let device = TestDevice::open();
    let mut stage = Stage::new(&device, scene);
    let mut render = |lights, seed, spp| {
        // A hash: its standard errors are those of independent samples.
        let params =
            ReferenceParams { lights, max_bounces: Some(1), sampler: SamplerKind::Pcg, ..Default::default() };
        stage.render(camera, SIZE, &params, seed, spp)
    };
    let truth = render(PathLights::PerKind, 99, 4 * spp);
    let compare = |(seed, &lights): (usize, &PathLights)| {
        let estimate = render(lights, seed as u32, spp);
        let [block, whole, error] = differences(&estimate, &truth);
        let noise = noise(&estimate);
        println!(
            "{what}, {lights:?}: off by at most {block:.2} and {whole:.2} of {error:.4}, noise {noise:.3e}"
        );
        assert_eq!(estimate.dropped, 0);
        // Of some 20 comparisons one in a thousand runs has one beyond 4 standard errors.
        assert!(block < 4.0 && whole < 4.0, "{what}, {lights:?}: {block}, {whole} standard errors");
        (lights, noise)
    };
    PathLights::ALL.iter().enumerate().map(compare).collect()
}

#[test]
fn lamps_behind_walls() {
    let scene = builtin("lamps").unwrap();
    let camera = scene.default_camera();
    let variances = compare(scene, &camera, 16, "lamps");
    let of = |lights| variances.iter().find(|(l, _)| *l == lights).unwrap().1;
    assert!(of(PathLights::LightBvh) < 0.5 * of(PathLights::Power));
    assert!(of(PathLights::ClusterCdf) < 0.5 * of(PathLights::Power));
}

/// Both strategies find the lights all around: weights with other probabilities than the picks' show as a wrong sum.
#[test]
fn inside_a_glowing_sphere() {
    let device = TestDevice::open();
    let camera = Camera::look_at("inside", Vec3::new(0.2, 0.1, 0.0), Vec3::X, 1.2);
    let mut stage = Stage::new(&device, glowing_sphere());
    for lights in PathLights::ALL {
        let params = ReferenceParams { lights, max_bounces: Some(1), ..Default::default() };
        let estimate = stage.render(&camera, SIZE, &params, 1, 32);
        assert_mean(&estimate, 0.875, &format!("{lights:?}"));
    }
}

/// Light from below and from behind: rough glass, a coat, points and spots on both sides.
#[test]
fn light_from_both_sides() {
    let mut scene = Scene::default();
    let glass =
        Material { transmission: 1.0, roughness: 0.4, ..Material::lambertian("pane", Vec3::splat(0.9)) };
    add_floor(&mut scene, 1.0, glass);
    let lamp = Material {
        emissive: Vec3::splat(4.0),
        double_sided: true,
        ..Material::lambertian("lamp", Vec3::ZERO)
    };
    add_floor(&mut scene, 0.2, lamp);
    scene.instances[1].world_from_object = Affine3A::from_translation(Vec3::new(0.5, -0.8, 0.0));
    let floor = Material::lambertian("floor", Vec3::splat(0.6));
    add_floor(&mut scene, 4.0, floor);
    scene.instances[2].world_from_object = Affine3A::from_translation(Vec3::new(0.0, -1.5, 0.0));
    scene.lights.push(Light::point("below", Vec3::new(-0.5, -0.7, 0.2), Vec3::new(3.0, 1.0, 1.0)));
    scene.lights.push(Light::point("above", Vec3::new(0.3, 1.0, -0.4), Vec3::new(1.0, 2.0, 1.0)));
    let camera = Camera::look_at("c", Vec3::new(0.0, 2.0, 1.5), Vec3::new(0.0, -0.2, 0.0), 0.9);
    compare(scene, &camera, 32, "pane");
}

/// Tables that were not prepared for the sampler are refused by the frame that would read them.
#[test]
fn a_path_tracer_without_its_tables_is_refused() {
    let device = TestDevice::open();
    let scene = builtin("cornell").unwrap();
    let mut gpu = GpuScene::new(&device, &scene, TraceBackend::Compute).unwrap();
    let mut lights = LightTables::new(&device, &scene).unwrap();
    lights.attach(&mut gpu);
    let camera = camera_record(&scene.default_camera(), [4, 4]);
    let frame = FrameRecord::new(camera, camera, [4, 4], 0, 1);
    for (choice, table) in
        [(PathLights::LightBvh, "the light tree"), (PathLights::ClusterCdf, "the light lists")]
    {
        let params = ReferenceParams { lights: choice, ..Default::default() };
        let render = Progressive::new(&device, &gpu, &lights, frame, params, None, 0);
        let error = render.unwrap().step(&scene, &mut gpu, &mut lights, 1).unwrap_err();
        let Error::MissingTable { .. } = &error else { panic!("{error}") };
        assert!(error.to_string().contains(table), "{error}");
    }
}
