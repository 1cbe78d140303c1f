//! Motion vectors of meshes that deform: the motion channel of a frame leads to where the same point of the surface was in the frame
//! before, and the refitted structures show the surfaces that fresh ones do.

use glam::{DVec2, DVec3, Vec3};
use pt_core::channels::field_width;
use pt_core::frame::Uniforms;
use pt_core::pack::unpack_unit_vector;
use pt_core::split::flat_to_split;
use pt_core::test_support::TestDevice;
use pt_core::trace::{NativeScene, TraceBackend};
use pt_core::{ChannelImages, Recorder};
use pt_core::{FrameSizes, StageInputs};
use pt_gbuffer::{GbufferParams, Jitter, PrimaryRays, oracle};
use pt_import::LoadOptions;
use pt_scene::gpu::{GpuScene, camera_record, mesh_geometry, placements};
use pt_scene::{AnimationChoice, Camera, Scene};
use pt_shaders::channels;
use pt_shaders::records::FrameRecord;
use pt_test_data::shared;

const SIZE: [u32; 2] = [81, 60];
const TIMES: [f64; 3] = [0.0, 0.35, 0.39];

/// The camera glides along.
fn view(scene: &Scene, time: f64) -> Camera {
    let camera = scene.default_camera();
    let eye = camera.position() * (1.0 + 0.05 * time as f32);
    Camera::look_at("gliding", eye, scene.bounds().unwrap().center(), 0.6)
}

fn check(file: &str, animation: AnimationChoice) {
    let path = shared("scenes").join(file);
    check_scene(file, |time| {
        let options = LoadOptions { animation: animation.clone(), time, ..LoadOptions::default() };
        pt_import::load(&path, &options).unwrap()
    });
}

/// `load`: the scene as it is at a time.
fn check_scene(file: &str, load: impl Fn(f64) -> Scene) {
    let device = TestDevice::open();
    let start = load(TIMES[0]);
    for backend in TraceBackend::available(&device) {
        let mut scene = start.clone();
        let mut gpu = GpuScene::new(&device, &scene, backend).unwrap();
        let stage = PrimaryRays::new(&device, gpu.variant()).unwrap();
        let images = ChannelImages::alone(&device, FrameSizes::same(SIZE), &[PrimaryRays::IO]).unwrap();
        let uniforms = Uniforms::new(&device, "frame_uniforms").unwrap();
        let params = GbufferParams { jitter: Jitter::None, ..Default::default() };
        let mut recorder = Recorder::new(&device).unwrap();
        for (index, time) in TIMES.into_iter().enumerate() {
            let previous = TIMES[index.saturating_sub(1)];
            scene.set_time(time, previous);
            let [now, then] = [time, previous].map(|t| camera_record(&view(&start, t), SIZE));
            let record = FrameRecord::new(now, then, SIZE, index as u32, 0);
            let mut frame = recorder.begin().unwrap();
            gpu.update(&mut frame, &scene).unwrap();
            uniforms.upload(&mut frame, &record).unwrap();
            stage
                .record(
                    &mut frame,
                    &StageInputs { scene: Some(&gpu), uniforms: Some(&uniforms), images: &images },
                    &params,
                )
                .unwrap();
            frame.submit().unwrap();
            recorder.finish().unwrap();

            // The host's poses are made afresh, from the file.
            let mut posed = load(time);
            posed.set_time(time, previous);
            compare(&format!("{file} {backend} frame {index}"), &posed, &load(previous), &record, &images);
        }
    }
}

fn compare(what: &str, scene: &Scene, before: &Scene, record: &FrameRecord, images: &ChannelImages) {
    let visibility = images.current(channels::VISIBILITY).read_u32().unwrap();
    let normals = images.current(channels::VERTEX_NORMAL).read_u32().unwrap();
    let motions = images.current(channels::MOTION).read_f32().unwrap();
    let positions = images.current(channels::SHADING_POSITION).read_f32().unwrap();
    let native = NativeScene::new(&mesh_geometry(scene), &placements(scene), Default::default()).unwrap();
    let size = scene.bounds().unwrap().size().length() as f64;
    let (mut compared, mut elsewhere, mut moving) = (0, 0, 0);
    for y in 0..SIZE[1] {
        for x in 0..SIZE[0] {
            let [sx, sy] = flat_to_split([x, y], field_width(SIZE[0]));
            let i = (sy * 2 * field_width(SIZE[0]) + sx) as usize;
            let uv = (DVec2::new(x.into(), y.into()) + 0.5) / DVec2::new(SIZE[0].into(), SIZE[1].into());
            let expected = oracle::primary(scene, before, &native, &record.camera, &record.camera_prev, uv);
            let Some(e) = expected else {
                elsewhere += u32::from(visibility[2 * i] != u32::MAX);
                continue;
            };
            if [visibility[2 * i], visibility[2 * i + 1]] != [e.instance, e.triangle] {
                let seen = DVec3::from_array(std::array::from_fn(|k| f64::from(positions[4 * i + k])));
                // Of two surfaces in the same place either may be seen.
                elsewhere += u32::from(seen.distance(e.position) > 1e-5 * size);
                continue;
            }
            compared += 1;
            let motion: [f32; 3] = [0, 1, 2].map(|c| motions[4 * i + c]);
            let motion = Vec3::from_array(motion).as_dvec3();
            let error = (motion - e.motion) / DVec3::new(1.0, 1.0, size);
            assert!(error.length() < 2e-5, "{what} ({x},{y}): motion {motion} for {}", e.motion);
            moving += u32::from(e.motion.truncate().length() > 1e-3);
            let normal = unpack_unit_vector(normals[i]).as_dvec3();
            assert!(
                normal.distance(e.vertex_normal) < 5e-4,
                "{what} ({x},{y}): normal {normal} for {}",
                e.vertex_normal
            );
        }
    }
    let total = SIZE[0] * SIZE[1];
    // The vectors that are compared lead to the true place to 0.002 pixels; at edges rounding decides which triangle a pixel sees.
    let right = 100.0 * f64::from(compared) / f64::from(compared + elsewhere);
    println!("{what}: {right:.2} % of {} pixels have the true motion, {moving} move", compared + elsewhere);
    assert!(right > 99.5 || elsewhere <= 4, "{what}: {right} %");
    assert!(elsewhere * 300 <= total, "{what}: {elsewhere} of {total} pixels see another triangle");
    assert!(compared > total / 20, "{what}: only {compared} pixels compared");
    let first = record.frame_index == 0;
    assert!(first || moving > compared / 8, "{what}: {moving} of {compared} pixels move");
    assert!(!first || moving == 0, "{what}: {moving} pixels move in the first frame");
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn a_skinned_fox() {
    check("Fox/Fox.glb", AnimationChoice::Name("Run".into()));
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn a_skinned_man() {
    check("CesiumMan/CesiumMan.gltf", AnimationChoice::Compatible);
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn a_box_in_two_parts() {
    check("BoxAnimated/BoxAnimated.gltf", AnimationChoice::Compatible);
}

/// Rigid bodies, lights that blink.
#[test]
fn the_moving_room() {
    check_scene("flicker", |time| {
        let mut scene = pt_import::open("flicker", &LoadOptions::default()).unwrap();
        scene.set_time(time, time);
        scene
    });
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn a_morphing_cube() {
    check("AnimatedMorphCube/AnimatedMorphCube.gltf", AnimationChoice::Compatible);
}
