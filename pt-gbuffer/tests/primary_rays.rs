//! The primary ray kernel against its oracle: instances that mirror and move, a moving camera, odd sizes.

use glam::{Affine3A, DVec2, DVec3, Quat, Vec3};
use pt_core::channels::field_width;
use pt_core::frame::Uniforms;
use pt_core::pack::unpack_unit_vector;
use pt_core::split::flat_to_split;
use pt_core::test_support::TestDevice;
use pt_core::trace::{NativeScene, TraceBackend};
use pt_core::{ChannelImages, Recorder};
use pt_core::{FrameSizes, StageInputs};
use pt_gbuffer::{GbufferParams, Jitter, PrimaryRays, oracle};
use pt_scene::gpu::{GpuScene, camera_record, mesh_geometry, placements};
use pt_scene::{Camera, Clusters, Instance, Projection, Scene};
use pt_shaders::channels;
use pt_shaders::records::{FrameRecord, NO_CLUSTER};

const SIZE: [u32; 2] = [61, 34];

/// The Cornell box plus a squeezed, mirrored copy of one of its blocks that moves.
fn scene(time: f32) -> Scene {
    let mut scene = pt_scene::builtin("cornell").unwrap();
    let place = |t: f32| {
        let turn = Quat::from_rotation_y(0.3 + t);
        Affine3A::from_scale_rotation_translation(
            Vec3::new(-0.4, 0.7, 0.5),
            turn,
            Vec3::new(0.1 + t, 0.05, -0.1),
        )
    };
    let mesh = scene.instances.len() as u32 - 1;
    let mut copy = Instance::new("mirrored", scene.instances[mesh as usize].mesh, place(time));
    copy.world_from_object_prev = place(time - 0.1);
    scene.instances.push(copy);
    scene
}

fn check(backend: TraceBackend, orthographic: bool) {
    let device = TestDevice::open();
    if let Some(why) = backend.missing(&device) {
        return println!("skipped: {why}");
    }
    let scene = scene(0.1);
    let mut camera = scene.default_camera();
    if orthographic {
        camera.projection = Projection::Orthographic { ymag: 0.4 };
    }
    let eye = camera.position();
    let mut before = Camera::look_at(
        "before",
        eye + Vec3::new(0.02, 0.01, 0.0),
        eye + camera.forward() + 0.01 * Vec3::X,
        0.7,
    );
    before.projection = camera.projection;
    let frame_record =
        FrameRecord::new(camera_record(&camera, SIZE), camera_record(&before, SIZE), SIZE, 0, 0);

    let mut gpu = GpuScene::new(&device, &scene, backend).unwrap();
    let stage = PrimaryRays::new(&device, gpu.variant()).unwrap();
    let images = ChannelImages::alone(&device, FrameSizes::same(SIZE), &[PrimaryRays::IO]).unwrap();
    let uniforms = Uniforms::new(&device, "frame_uniforms").unwrap();
    let params = GbufferParams { jitter: Jitter::None, ..Default::default() };
    let mut recorder = Recorder::new(&device).unwrap();
    let mut frame = recorder.begin().unwrap();
    gpu.update(&mut frame, &scene).unwrap();
    uniforms.upload(&mut frame, &frame_record).unwrap();
    stage
        .record(
            &mut frame,
            &StageInputs { scene: Some(&gpu), uniforms: Some(&uniforms), images: &images },
            &params,
        )
        .unwrap();
    frame.submit().unwrap();
    recorder.finish().unwrap();

    let visibility = images.current(channels::VISIBILITY).read_u32().unwrap();
    let positions = images.current(channels::SHADING_POSITION).read_f32().unwrap();
    let normals = images.current(channels::VERTEX_NORMAL).read_u32().unwrap();
    let clusters = images.current(channels::CLUSTER).read_u32().unwrap();
    let division = Clusters::new(&scene, Clusters::DEFAULT);
    let depths = images.current(channels::VIEW_DEPTH).read_f32().unwrap();
    let motions = images.current(channels::MOTION).read_f32().unwrap();
    let native = NativeScene::new(&mesh_geometry(&scene), &placements(&scene), Default::default()).unwrap();
    let (mut compared, mut elsewhere, mut seen_mirrored) = (0, 0, 0);
    for y in 0..SIZE[1] {
        for x in 0..SIZE[0] {
            let [sx, sy] = flat_to_split([x, y], field_width(SIZE[0]));
            let i = (sy * 2 * field_width(SIZE[0]) + sx) as usize;
            let uv = DVec2::new(
                (f64::from(x) + 0.5) / f64::from(SIZE[0]),
                (f64::from(y) + 0.5) / f64::from(SIZE[1]),
            );
            let expected =
                oracle::primary(&scene, &scene, &native, &frame_record.camera, &frame_record.camera_prev, uv);
            let at = Vec3::from_slice(&positions[4 * i..4 * i + 3]);
            let cluster = if visibility[2 * i] == u32::MAX { NO_CLUSTER } else { division.find(at) };
            assert_eq!(clusters[i], cluster, "({x},{y}) at {at}");
            let Some(e) = expected else {
                elsewhere += u32::from(visibility[2 * i] != u32::MAX);
                continue;
            };
            if [visibility[2 * i], visibility[2 * i + 1]] != [e.instance, e.triangle] {
                elsewhere += 1;
                continue;
            }
            compared += 1;
            seen_mirrored += u32::from(e.instance as usize == scene.instances.len() - 1);
            let vec = |v: &[f32], stride: usize| {
                DVec3::new(v[stride * i].into(), v[stride * i + 1].into(), v[stride * i + 2].into())
            };
            let position = vec(&positions, 4);
            assert!(position.distance(e.position) < 2e-5, "({x},{y}): {position} for {}", e.position);
            assert!(f64::from(depths[i]) - e.view_depth < 2e-5);
            let normal = unpack_unit_vector(normals[i]).as_dvec3();
            assert!(normal.distance(e.vertex_normal) < 2e-4, "({x},{y}): {normal} for {}", e.vertex_normal);
            let motion = vec(&motions, 4);
            assert!(motion.distance(e.motion) < 2e-5, "({x},{y}): motion {motion} for {}", e.motion);
            assert!(motions[4 * i + 3] > 0.0);
        }
    }
    let total = SIZE[0] * SIZE[1];
    assert!(elsewhere * 1000 <= total, "{elsewhere} of {total} pixels see another triangle");
    assert!(
        compared > total / 4 && seen_mirrored > 20,
        "{compared} compared, {seen_mirrored} on the moving copy"
    );
}

#[test]
fn perspective() {
    for backend in TraceBackend::CONCRETE {
        check(backend, false);
    }
}

#[test]
fn orthographic() {
    check(TraceBackend::Compute, true);
}
