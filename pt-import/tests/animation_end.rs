//! What follows the last key of an animation, and the motion across it.

use crate::common::gltf::{Glb, plain};
use pt_import::LoadOptions;
use pt_scene::glam::{Affine3A, Vec3};
use pt_scene::{AnimationEnd, Scene};
use serde_json::json;

const STEP: f64 = 1.0 / 60.0;

/// A triangle that slides along +X from 0 m to 3 m in one second, and another one with a morph target whose weight rises to 1.
fn scene(animation_end: AnimationEnd) -> Scene {
    let mut glb = Glb::new();
    let positions = glb.floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0], "VEC3");
    glb.show(json!({"attributes": {"POSITION": positions}}));
    let lift = glb.floats(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 8.0], "VEC3");
    glb.show(json!({"attributes": {"POSITION": positions}, "targets": [{"POSITION": lift}]}));
    let times = glb.floats(&[0.0, 1.0], "SCALAR");
    let way = glb.floats(&[0.0, 0.0, 0.0, 3.0, 0.0, 0.0], "VEC3");
    let weights = glb.floats(&[0.0, 1.0], "SCALAR");
    glb.json["animations"] = json!([{
        "samplers": [{"input": times, "output": way}, {"input": times, "output": weights}],
        "channels": [
            {"sampler": 0, "target": {"node": 0, "path": "translation"}},
            {"sampler": 1, "target": {"node": 1, "path": "weights"}}
        ]
    }]);
    glb.load_with(&LoadOptions { animation_end, ..plain() }).unwrap_or_else(|e| panic!("{e}"))
}

/// Where the sliding triangle is, where it was, and how far the other one is lifted.
fn at(scene: &mut Scene, now: f64, previous: f64) -> [f32; 3] {
    scene.set_time(now, previous);
    scene.pose_meshes();
    let instance = &scene.instances[0];
    let lifted = &scene.meshes[scene.instances[1].mesh as usize].positions[2];
    let x = |t: Affine3A| Vec3::from(t.translation).x;
    [x(instance.world_from_object), x(instance.world_from_object_prev), lifted.z]
}

#[test]
fn hold_keeps_the_last_pose_without_motion() {
    let mut scene = scene(AnimationEnd::Hold);
    assert_eq!(at(&mut scene, 0.5, 0.25), [1.5, 0.75, 4.0]);
    assert_eq!(at(&mut scene, 1.0, 0.75), [3.0, 2.25, 8.0]);
    // The frame that crosses the last key moves by what is left of the way, those after it not at all.
    assert_eq!(at(&mut scene, 1.25, 0.75), [3.0, 2.25, 8.0]);
    for now in [1.5, 2.0, 1e6] {
        assert_eq!(at(&mut scene, now, now - 0.25), [3.0, 3.0, 8.0], "at {now}");
    }
    // Before time 0 it rests at the first key.
    assert_eq!(at(&mut scene, -0.5, -0.75), [0.0, 0.0, 0.0]);
}

#[test]
fn loop_starts_again_and_is_the_default() {
    assert_eq!(LoadOptions::default().animation_end, AnimationEnd::Loop);
    let mut scene = scene(AnimationEnd::Loop);
    assert_eq!(at(&mut scene, 1.25, 1.0), [0.75, 0.0, 2.0]);
    assert_eq!(at(&mut scene, -0.25, -0.5), [2.25, 1.5, 6.0]);
}

/// The previous transform of a frame is the transform of the frame before it, to the bit, in both modes and across the seam: motion
/// leads to where the surface was seen.
#[test]
fn the_previous_pose_is_that_of_the_frame_before() {
    for end in [AnimationEnd::Loop, AnimationEnd::Hold] {
        let mut scene = scene(end);
        let mut before = None;
        for frame in 50..130 {
            let (now, previous) = (f64::from(frame) * STEP, f64::from(frame - 1) * STEP);
            scene.set_time(now, previous);
            let instance = &scene.instances[0];
            if let Some(before) = before.replace(instance.world_from_object) {
                assert_eq!(instance.world_from_object_prev, before, "frame {frame} of {end:?}");
            }
        }
    }
}
