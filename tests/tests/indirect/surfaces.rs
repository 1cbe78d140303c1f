//! What the G-buffer shows in mirrors, through glass and through blended surfaces, against the reference: the same light, whichever pass
//! finds it.

use crate::common::{self, Mean, assert_same, frames_mean, params, reference_mean};
use glam::{Affine3A, DVec3, Vec3};
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_reference::{Progressive, ReferenceParams};
use pt_scene::gpu::camera_record;
use pt_scene::{AlphaMode, Camera, Environment, EnvironmentImage, Light, Material, Scene};
use pt_shaders::channels::FLAT_COLOR;
use pt_shaders::records::FrameRecord;
use pt_tests::Frames;

/// A sky that is brighter above, and bluer.
fn graded_sky() -> Environment {
    let texels = (0..8 * 16).map(|i| {
        let up = 1.0 - (i / 16) as f32 / 8.0;
        Vec3::new(0.2 + up, 0.3 + up, 0.4 + 1.5 * up)
    });
    Environment::new(EnvironmentImage { width: 16, height: 8, texels: texels.collect() })
}

/// A rectangle around `center` in the plane z = const that faces +Z.
fn facing(scene: &mut Scene, center: Vec3, half: [f32; 2], material: Material) {
    let corner = |x: f32, y: f32| center + Vec3::new(x * half[0], y * half[1], 0.0);
    common::polygon(
        scene,
        &[corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        material,
    );
}

/// A box of glass with a hollow that coloured water fills; the water reaches into the walls, and a cube of ice into the water.
fn tumbler() -> (Scene, Camera) {
    let mut scene = Scene { environment: graded_sky(), ..Scene::default() };
    let place = |size: Vec3, at: Vec3| {
        Affine3A::from_scale_rotation_translation(size, glam::Quat::from_rotation_y(0.5), at)
    };
    let solid = |name: &str, ior: f32, priority: u32| Material { priority, ..Material::solid(name, ior) };
    common::cube(&mut scene, place(Vec3::ONE, Vec3::ZERO), false, solid("glass", 1.5, 3));
    common::cube(&mut scene, place(Vec3::splat(0.8), Vec3::ZERO), true, solid("glass", 1.5, 3));
    let mut water = solid("water", 1.33, 1);
    (water.attenuation_color, water.attenuation_distance) = (Vec3::new(0.3, 0.7, 0.9), 1.0);
    common::cube(&mut scene, place(Vec3::new(0.85, 0.6, 0.85), Vec3::new(0.0, -0.25, 0.0)), false, water);
    common::cube(&mut scene, place(Vec3::splat(0.3), Vec3::new(0.1, 0.2, 0.1)), false, solid("ice", 1.31, 2));
    scene.validate().unwrap();
    let camera = Camera::look_at("aside", Vec3::new(0.4, 1.2, 4.5), Vec3::ZERO, 0.5);
    (scene, camera)
}

/// Liquid in a glass with priorities, from outside and with the camera in the water. Nothing but interfaces.
#[test]
fn nested_solids_are_seen_as_in_the_reference() {
    let (scene, outside) = tumbler();
    let inside = Camera::look_at("in the water", Vec3::new(-0.2, -0.4, 0.3), Vec3::new(0.3, 0.1, -0.4), 1.2);
    for camera in [&outside, &inside] {
        let truth = reference_mean(&scene, camera, [20, 16], 64, 256);
        let found = frames_mean(
            &scene,
            camera,
            [20, 16],
            64,
            params(&["gbuffer.reflect_refract=10", "indirect.bounces=0"]),
        );
        // Behind its tenth interface a path of the frame goes straight on: with 4, 6, 8 and 10 of them the light in the water is 1.03, 1.00, 1.01 and
        // 1.01 of the reference's.
        assert_same(&camera.name, found, truth, 0.01);
    }
}

/// Blended sheets one behind the other, in front of a lamp and in front of nothing, lit, shining and seen in a mirror: the mean is that of the
/// reference, and of the "over" operator where that is known.
#[test]
fn blended_sheets_are_never_opaque() {
    let mut scene = Scene::default();
    let blend = |name: &str, alpha: f32, color: Vec3| Material {
        alpha_mode: AlphaMode::Blend,
        base_color: color.extend(alpha),
        double_sided: true,
        ..Material::lambertian(name, color)
    };
    let shining = |alpha: f32, light: Vec3| Material { emissive: light, ..blend("shine", alpha, Vec3::ZERO) };
    let lamp = Vec3::new(3.0, 2.0, 1.0);
    let layers =
        [(0.5, Vec3::new(0.2, 0.9, 0.1)), (0.25, Vec3::new(1.0, 0.1, 0.3)), (0.8, Vec3::new(0.4, 0.4, 2.0))];
    for (i, (alpha, light)) in layers.into_iter().enumerate() {
        facing(&mut scene, Vec3::Z * (-0.2 * i as f32), [4.0, 4.0], shining(alpha, light));
    }
    facing(&mut scene, Vec3::Z * -3.0, [9.0, 9.0], Material::lamp("lamp", lamp));
    scene.validate().unwrap();
    let camera = Camera::look_at("front", Vec3::Z * 4.0, Vec3::ZERO, 0.5);
    let mut over = lamp.as_dvec3();
    for (alpha, light) in layers.into_iter().rev() {
        over = f64::from(alpha) * light.as_dvec3() + (1.0 - f64::from(alpha)) * over;
    }
    let sets = ["indirect.bounces=0"];
    let found = frames_mean(&scene, &camera, [16, 16], 96, params(&sets));
    assert_same("shining sheets", found, Mean { mean: over, error: DVec3::ZERO }, 1e-3);

    // Lit ones, with their shadows on each other, above a mirror.
    let mut scene = Scene { environment: Environment::constant(Vec3::splat(0.3)), ..Scene::default() };
    scene.lights.push(Light::point("point", Vec3::new(1.0, 2.0, 3.0), Vec3::splat(20.0)));
    for (i, alpha) in [0.3, 0.6, 0.9].into_iter().enumerate() {
        let color = Vec3::new(0.9, 0.3 * i as f32, 0.2);
        facing(
            &mut scene,
            Vec3::new(0.3 * i as f32, 0.2, -0.4 * i as f32),
            [1.0, 1.0],
            blend("sheet", alpha, color),
        );
    }
    let corner = |x: f32, z: f32| Vec3::new(3.0 * x, -1.0, 3.0 * z);
    common::polygon(
        &mut scene,
        &[corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)],
        Material::metal("mirror", Vec3::splat(0.9), 0.0),
    );
    scene.validate().unwrap();
    let camera = Camera::look_at("down", Vec3::new(0.3, 0.8, 4.0), Vec3::new(0.2, -0.3, 0.0), 0.7);
    // A mirror is a bounce of the reference; light by way of it on the sheets is one more, which is small here and left out by both.
    let truth = reference_mean(&scene, &camera, [16, 16], 1, 512);
    let direct = reference_mean(&scene, &camera, [16, 16], 0, 512);
    let found = frames_mean(&scene, &camera, [16, 16], 128, params(&sets));
    println!("lit sheets: {found:?}, reference {truth:?}, direct light {direct:?}");
    for c in 0..3 {
        assert!(found.mean[c] > direct.mean[c] && found.mean[c] < 1.02 * truth.mean[c], "channel {c}");
    }
}

/// Means of the columns of a picture, seen by the frames and by the reference.
fn columns(pixels: &[DVec3], size: [u32; 2], count: usize) -> Vec<DVec3> {
    let [width, height] = size.map(|s| s as usize);
    let each = width / count;
    (0..count)
        .map(|column| {
            let of = |y: usize| pixels[y * width + column * each..y * width + (column + 1) * each].iter();
            (0..height).flat_map(of).sum::<DVec3>() / (each * height) as f64
        })
        .collect()
}

/// Plates of rising roughness beside each other under a lamp, a sky and a point light. The smoothest are replaced in the G-buffer by what they show;
/// rough glass is too, with highlights; rough metals are shaded with bounce rays: the light goes on without a step.
#[test]
fn roughness_has_no_threshold() {
    const ROUGHNESS: [f32; 8] = [0.0, 0.015, 0.025, 0.06, 0.12, 0.2, 0.35, 0.5];
    let size = [32, 8];
    let plates = |material: fn(f32) -> Material| {
        let mut scene = Scene { environment: graded_sky(), ..Scene::default() };
        for (i, roughness) in ROUGHNESS.into_iter().enumerate() {
            let x = 0.5 * (i as f32 - 3.5);
            facing(&mut scene, Vec3::new(x, 0.0, 0.0), [0.25, 1.0], material(roughness));
        }
        // Behind the camera; it shines on the plates.
        let corner = |x: f32, y: f32| Vec3::new(2.5 * x, 2.0 + y, 6.0);
        common::polygon(
            &mut scene,
            &[corner(1.0, -1.0), corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0)],
            Material::lamp("lamp", Vec3::splat(3.0)),
        );
        scene.lights.push(Light::point("point", Vec3::new(0.4, 1.5, 1.0), Vec3::new(6.0, 3.0, 2.0)));
        scene.validate().unwrap();
        scene
    };
    let camera = Camera {
        projection: pt_scene::Projection::Orthographic { ymag: 0.5 },
        ..Camera::look_at("front", Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, 1.0)
    };
    let metal = |roughness: f32| Material::metal("metal", Vec3::new(0.9, 0.7, 0.5), roughness);
    let pane = |roughness: f32| Material {
        transmission: 1.0,
        roughness,
        base_color: Vec3::new(0.6, 0.8, 0.9).extend(1.0),
        ..Material::diffuse("glass", Vec3::ONE)
    };
    for (name, material) in [("metal", metal as fn(f32) -> Material), ("glass", pane as fn(f32) -> Material)]
    {
        let scene = plates(material);
        // The lamp is behind the camera's plane and faces it: no light goes from plate to plate.
        let mut frames = Frames::with_params(
            scene.clone(),
            &camera,
            TraceBackend::Compute,
            size,
            5,
            false,
            params(&["indirect.bounces=1", "lights.rays=per-kind"]),
        );
        let count = 192;
        let mut means: Vec<Vec<DVec3>> = Vec::new();
        for _ in 0..count {
            frames.render(0.0);
            let pixels: Vec<_> =
                frames.image(FLAT_COLOR).pixels.iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
            means.push(columns(&pixels, size, ROUGHNESS.len()));
        }
        frames.finish();
        let truth = columns(&reference_pixels(&scene, &camera, size, 512), size, ROUGHNESS.len());
        for (i, roughness) in ROUGHNESS.into_iter().enumerate() {
            let mean = means.iter().map(|m| m[i].y).sum::<f64>() / f64::from(count);
            let variance = means.iter().map(|m| (m[i].y - mean).powi(2)).sum::<f64>() / f64::from(count - 1);
            let error = (variance / f64::from(count)).sqrt();
            println!("{name}, roughness {roughness}: {mean:.4} +- {error:.4}, reference {:.4}", truth[i].y);
            // Light samples find highlights of rough metal with much noise.
            assert!(
                error < 0.02 * mean || roughness > 0.3,
                "{name}, roughness {roughness}: too noisy: {error}"
            );
            // No lobe of the frame is narrower than 0.03.
            let off = (mean - truth[i].y).abs();
            assert!(
                off < 4.0 * error + 0.01 * truth[i].y,
                "{name}, roughness {roughness}: {mean}, {}",
                truth[i].y
            );
        }
    }
}

fn reference_pixels(scene: &Scene, camera: &Camera, size: [u32; 2], spp: u32) -> Vec<DVec3> {
    let device = TestDevice::open();
    let mut session = common::session(&device, scene);
    let record = camera_record(camera, size);
    let frame = FrameRecord::new(record, record, size, 0, 99);
    let params = ReferenceParams { max_bounces: Some(1), spp, ..ReferenceParams::default() };
    let pt_app::session::Session { device, scene, gpu, lights, .. } = &mut session;
    params.prepare_lights(device, scene, gpu, lights).unwrap();
    let mut render = Progressive::new(device, gpu, lights, frame, params, None, 0).unwrap();
    while render.next_sample() < spp {
        render.step(scene, gpu, lights, spp).unwrap();
    }
    render.state().unwrap().estimate(spp).pixels.iter().map(|p| p.mean.as_dvec3()).collect()
}
