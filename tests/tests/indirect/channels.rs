//! What frames leave in their channels: numbers everywhere, and the same in both orders of pixels.

use crate::common::params;
use pt_core::split::to_flat;
use pt_core::trace::TraceBackend;
use pt_import::{LoadOptions, open};
use pt_scene::{BUILTIN, Scene};
use pt_shaders::channels::{COLOR, FLAT_COLOR, FLAT_MOTION, MOTION, VIEW_DIRECTION};
use pt_shaders::records::FLAG_PRIMARY;
use pt_test_data::shared;
use pt_tests::{Frames, builtin};

/// Fails where a channel of the second frame has a value that is not finite.
fn assert_finite(name: &str, scene: Scene) {
    let camera = scene.default_camera();
    let params = params(&["indirect.bounces=1", "gbuffer.reflect_refract=3"]);
    let mut frames = Frames::with_params(scene, &camera, TraceBackend::Compute, [26, 15], 11, false, params);
    frames.render(0.2);
    frames.render(0.25);
    for channel in frames.channels() {
        if channel.channel().format.is_uint() {
            continue;
        }
        let values = frames.floats(channel);
        let bad = values.iter().filter(|v| !v.is_finite()).count();
        assert_eq!(
            bad,
            0,
            "{name}: {bad} of {} values of {} are not finite",
            values.len(),
            channel.full_name()
        );
    }
    frames.finish();
}

#[test]
fn channels_of_built_in_scenes_are_finite() {
    for (name, _) in BUILTIN {
        assert_finite(name, builtin(name));
    }
}

/// Scenes with broken or unusual data: mirrored tangents, negative scales, no indices, points and lines, vertex colours, volumes.
#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn channels_of_unusual_files_are_finite() {
    for file in [
        "NormalTangentMirrorTest/NormalTangentMirrorTest.gltf",
        "NegativeScaleTest/NegativeScaleTest.gltf",
        "MeshPrimitiveModes/MeshPrimitiveModes.gltf",
        "AttenuationTest/AttenuationTest.gltf",
    ] {
        let path = shared("scenes").join(file);
        assert!(path.is_file(), "{file} is missing");
        assert_finite(file, open(path.to_str().unwrap(), &LoadOptions::default()).unwrap());
    }
}

/// Every regular pixel of the flat frame has the bits of its texel in the split one, whatever its neighbours are; pixels of glass that is split
/// over the fields are means.
#[test]
fn regular_pixels_are_the_same_in_both_orders() {
    let scene = builtin("kinds");
    let camera = scene.default_camera();
    let size = [47, 33];
    let params = params(&["checkerboard.blend_split=true"]);
    let mut frames = Frames::with_params(scene, &camera, TraceBackend::Compute, size, 2, false, params);
    frames.render(0.0);
    let texels = |values: Vec<f32>, count: usize| -> Vec<Vec<u32>> {
        values.chunks_exact(count).map(|texel| texel.iter().map(|v| v.to_bits()).collect()).collect()
    };
    let words = frames.integers(VIEW_DIRECTION);
    let flags = to_flat(&words.chunks_exact(2).map(|w| w[1]).collect::<Vec<_>>(), size);
    let split = to_flat(&(0..words.len() / 2).collect::<Vec<usize>>(), size);
    let (color, motion) = (texels(frames.floats(COLOR), 4), texels(frames.floats(MOTION), 4));
    let (flat_color, flat_motion) =
        (texels(frames.floats(FLAT_COLOR), 4), texels(frames.floats(FLAT_MOTION), 2));
    let (mut regular, mut means) = (0, 0);
    for (i, flag) in flags.iter().enumerate() {
        let same = flat_color[i][..3] == color[split[i]][..3];
        if *flag == FLAG_PRIMARY {
            assert!(same, "pixel {i}");
            assert_eq!(flat_motion[i][..], motion[split[i]][..2], "pixel {i}");
            regular += 1;
        } else {
            means += usize::from(!same);
        }
    }
    frames.finish();
    assert!(regular > flags.len() / 2 && means > 20, "{regular} regular pixels, {means} means");
}
