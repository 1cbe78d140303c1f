//! The tables of instances on the device.

use pt_core::Recorder;
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_scene::builtin;
use pt_scene::gpu::GpuScene;

/// Rays begin in the top level, and find nothing there: memory that nobody has written may hold anything.
#[test]
fn a_scene_without_instances_has_a_top_level() {
    let device = TestDevice::open();
    let mut scene = builtin("plane").unwrap();
    scene.instances.clear();
    let mut gpu = GpuScene::new(&device, &scene, TraceBackend::Compute).unwrap();
    let mut recorder = Recorder::new(&device).unwrap();
    for is_written in [true, false] {
        let mut frame = recorder.begin().unwrap();
        gpu.update(&mut frame, &scene).unwrap();
        frame.submit().unwrap();
        let writes = recorder.pass_table().iter().any(|pass| pass.name.contains("top-level BVH nodes"));
        assert_eq!(writes, is_written);
    }
    recorder.finish().unwrap();
}
