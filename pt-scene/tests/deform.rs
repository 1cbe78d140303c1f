//! Deforming meshes on the device: the kernel against its host twin, and previous vertices against last frame's current ones.

use std::collections::BTreeSet;
use std::sync::Arc;

use pt_core::Recorder;
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_import::{LoadOptions, load};
use pt_scene::animation::{Deformation, Influence, MorphDelta, Skin};
use pt_scene::glam::{Affine3A, Quat, Vec3, Vec4};
use pt_scene::gpu::GpuScene;
use pt_scene::{AnimationChoice, Instance, Material, Mesh, Scene};
use pt_test_data::shared;

/// A strip along +Y of 2 x 64 vertices with two joints, one at each end, and a morph target that bulges it.
fn strip() -> Scene {
    let mut mesh = Mesh { name: "strip".into(), ..Mesh::default() };
    for i in 0..64 {
        let share = i as f32 / 63.0;
        for x in [-0.5, 0.5] {
            mesh.positions.push(Vec3::new(x, 4.0 * share, 0.0));
            mesh.normals.push(Vec3::Z);
            mesh.tangents.push(Vec4::new(1.0, 0.0, 0.0, 1.0));
            mesh.uv0.push([x, share].into());
            mesh.uv1.push([x, share].into());
            mesh.colors.push(Vec4::ONE);
            let joints = [(0, 1.0 - share), (1, share)];
            let joints = joints.into_iter().filter(|(_, weight)| *weight > 0.0);
            mesh.influences.push(joints.map(|(joint, weight)| Influence { joint, weight }));
            let bulge = Vec3::Z * (share * std::f32::consts::PI).sin();
            mesh.morphs.push((i % 3 != 0).then_some(MorphDelta {
                target: 0,
                position: bulge,
                normal: 0.2 * Vec3::Y,
                tangent: Vec3::ZERO,
            }));
        }
    }
    for i in 0..63u32 {
        mesh.indices.push([2 * i, 2 * i + 1, 2 * i + 3]);
        mesh.indices.push([2 * i, 2 * i + 3, 2 * i + 2]);
    }
    mesh.triangle_materials = vec![0; mesh.indices.len()];
    mesh.first_masked = mesh.indices.len();
    let skin = Skin { joints: vec![0, 1], inverse_bind: vec![Affine3A::IDENTITY; 2] };
    mesh.deformation = Some(Box::new(Deformation::new(&mesh, 0, Some(Arc::new(skin)), &[0.0])));
    Scene {
        name: "strip".into(),
        instances: vec![
            Instance::new("a", 0, Affine3A::IDENTITY),
            Instance::new(
                "b",
                0,
                Affine3A::from_scale_rotation_translation(
                    Vec3::new(1.0, -1.0, 2.0),
                    Quat::IDENTITY,
                    Vec3::X * 3.0,
                ),
            ),
        ],
        meshes: vec![mesh],
        materials: vec![Material::default()],
        ..Scene::default()
    }
}

fn twist(scene: &mut Scene, time: f32) {
    let deformation = scene.meshes[0].deformation.as_mut().unwrap();
    let turn = Quat::from_rotation_y(2.0 * time) * Quat::from_rotation_x(0.8 * time);
    deformation.joints[1] = Affine3A::from_scale_rotation_translation(
        Vec3::new(1.0 + time, 1.0, 0.5),
        turn,
        Vec3::new(time, 0.0, 0.0),
    );
    deformation.weights[0] = time;
}

/// Renders nothing, moves `scene` through `frames` by `step` and checks what the device has after each.
fn check(
    device: &TestDevice,
    backend: TraceBackend,
    scene: &mut Scene,
    frames: usize,
    step: impl Fn(&mut Scene, usize),
) {
    step(scene, 0);
    scene.pose_meshes();
    scene.validate().unwrap();
    let mut gpu = GpuScene::new(device, scene, backend).unwrap();
    let mut recorder = Recorder::new(device).unwrap();
    let mut last: Vec<Option<Vec<Vec3>>> = vec![None; scene.meshes.len()];
    let mut last_places = None;
    let mut moved = 0;
    for index in 0..frames {
        step(scene, index);
        let mut frame = recorder.begin().unwrap();
        gpu.update(&mut frame, scene).unwrap();
        frame.submit().unwrap();
        recorder.finish().unwrap();
        for (m, last) in last.iter_mut().enumerate() {
            let Some(read) = gpu.read_positions(scene, m) else { continue };
            let [now, previous] = read.unwrap();
            let expected = scene.meshes[m].deformed().unwrap().positions;
            let scale = expected.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
            for (v, (a, b)) in now.iter().zip(&expected).enumerate() {
                // Sums of up to a dozen products in single precision, in another order.
                assert!(a.distance(*b) <= 4e-6 * scale, "{}: vertex {v}: {a} for {b}", scene.name);
            }
            let bits =
                |p: &[Vec3]| -> Vec<[u32; 3]> { p.iter().map(|p| p.to_array().map(f32::to_bits)).collect() };
            assert_eq!(bits(&previous), bits(last.as_ref().unwrap_or(&now)), "{}: frame {index}", scene.name);
            moved += usize::from(now != previous);
            *last = Some(now);
        }
        let records = gpu.read_instances().unwrap();
        let places: Vec<_> = records.iter().map(|r| r.world_from_object).collect();
        let previous: Vec<_> = records.iter().map(|r| r.world_from_object_prev).collect();
        assert_eq!(previous, last_places.unwrap_or_else(|| places.clone()), "frame {index}");
        last_places = Some(places);
    }
    assert!(moved > 0, "{} never moved", scene.name);
    // What the checks read came through memory of its own; frames alone take none.
    for index in frames..frames + 6 {
        step(scene, index);
        let mut frame = recorder.begin().unwrap();
        gpu.update(&mut frame, scene).unwrap();
        frame.submit().unwrap();
    }
    for timing in &recorder.finish().unwrap()[1..] {
        assert_eq!((timing.created.pipelines, timing.created.allocations), (0, 0));
        let names: BTreeSet<_> = timing.passes.iter().map(|p| p.pass.as_str()).collect();
        assert_eq!(names.len(), timing.passes.len(), "{names:?}");
        assert!(
            timing.passes.iter().all(|p| p.pass != "deform")
                || timing.passes.iter().any(|p| p.pass.starts_with("refit"))
        );
    }
}

/// Time rests in every fourth frame, and jumps once.
fn time(index: usize) -> f64 {
    0.2 + (index - index / 4) as f64 / 60.0 + if index > 7 { 11.3 } else { 0.0 }
}

#[test]
fn a_twisted_strip_on_every_backend() {
    let device = TestDevice::open();
    for backend in TraceBackend::available(&device) {
        check(&device, backend, &mut strip(), 10, |scene, index| twist(scene, time(index) as f32));
    }
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn shared_scenes() {
    let folder = shared("scenes");
    let device = TestDevice::open();
    for file in [
        "Fox/Fox.glb",
        "CesiumMan/CesiumMan.gltf",
        "AnimatedMorphCube/AnimatedMorphCube.gltf",
        "SimpleSkin/SimpleSkin.gltf",
    ] {
        let options = LoadOptions { animation: AnimationChoice::Compatible, ..LoadOptions::default() };
        let mut scene = load(folder.join(file), &options).unwrap();
        check(&device, TraceBackend::Compute, &mut scene, 12, |scene, index| {
            scene.set_time(time(index), time(index.saturating_sub(1)));
        });
    }
}

#[test]
fn a_pose_that_mirrors_turns_the_faces() {
    let device = TestDevice::open();
    let mut scene = strip();
    let mirror = Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    scene.meshes[0].deformation.as_mut().unwrap().joints = vec![mirror; 2];
    scene.pose_meshes();
    let mut gpu = GpuScene::new(&device, &scene, TraceBackend::Compute).unwrap();
    let mut recorder = Recorder::new(&device).unwrap();
    let mut frame = recorder.begin().unwrap();
    gpu.update(&mut frame, &scene).unwrap();
    frame.submit().unwrap();
    recorder.finish().unwrap();
    let mirrored: Vec<_> = gpu.read_instances().unwrap().iter().map(|r| r.mirrored).collect();
    // The second instance mirrors by itself.
    assert_eq!(mirrored, [1, 0]);
}
