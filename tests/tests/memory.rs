//! Images and tables that share memory: the pictures are those of frames that keep everything.

use pt_app::params::resolve;
use pt_core::Kept;
use pt_core::channels::SHARED;
use pt_core::trace::TraceBackend;
use pt_scene::Scene;
use pt_shaders::channels::{ChannelId, DISPLAY, FLAT_COLOR};
use pt_tests::{Frames, builtin};

const SIZE: [u32; 2] = [64, 36];

fn render(scene: &Scene, knobs: &[&str], kept: Kept) -> (Frames, Vec<Vec<f32>>) {
    let knobs: Vec<String> = knobs.iter().map(|knob| (*knob).to_owned()).collect();
    let params = resolve(None, &knobs, false).unwrap_or_else(|e| panic!("{e:#}"));
    let (camera, backend) = (scene.default_camera(), TraceBackend::Compute);
    let mut frames = Frames::keeping(kept, scene.clone(), &camera, backend, SIZE, 1, params);
    let mut pictures = Vec::new();
    for number in 0..4 {
        frames.render(f64::from(number) / 30.0);
        let images: [ChannelId; 2] = [FLAT_COLOR, DISPLAY];
        pictures.extend(images.map(|channel| frames.floats(channel)));
    }
    (frames, pictures)
}

/// Checks a scene with knobs; returns the bytes of the images of both kinds of frames.
fn check(scene: &str, knobs: &[&str]) -> [u64; 2] {
    let scene = builtin(scene);
    let (mut all, expected) = render(&scene, knobs, Kept::All);
    let (mut shared, found) = render(&scene, knobs, Kept::Outputs);
    for (number, (a, b)) in expected.iter().zip(&found).enumerate() {
        let differs = a.iter().zip(b).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
        assert_eq!(differs, 0, "{} {knobs:?}: image {} of frame {}", scene.name, number % 2, number / 2);
    }
    let bytes = [all.image_bytes(), shared.image_bytes()];
    println!("{} {knobs:?}: {} of {} bytes", scene.name, bytes[1], bytes[0]);
    assert!(bytes[1] < bytes[0], "{} {knobs:?}: {bytes:?}", scene.name);
    // Tables of direct and indirect lighting are in the memory of the frame.
    for frames in [&all, &shared] {
        let allocations = frames.allocations();
        let has = |name: &str| allocations.iter().any(|allocation| allocation == name);
        assert!(has(SHARED) && !has("shadow ray ends") && !has("bounce ray origins"), "{allocations:?}");
    }
    all.passes();
    shared.passes();
    all.finish();
    shared.finish();
    bytes
}

#[test]
fn frames_that_move_with_a_history() {
    let [all, shared] = check("flicker", &["post.taa.enabled=true", "gbuffer.jitter=halton"]);
    assert!(3 * shared < 2 * 2 * all, "{shared} of {all} bytes");
    check("flicker", &["lights.sampler=restir-di", "indirect.reuse=restir-gi"]);
}

#[test]
fn each_denoiser() {
    check("cornell", &["denoise.variant=off"]);
    check("cornell", &["denoise.variant=off", "indirect.bounces=0"]);
    check("cornell", &["denoise.variant=accumulate"]);
    check("cornell", &["denoise.variant=svgf", "denoise.atrous.feedback=true"]);
    check("cornell", &["denoise.variant=atrous"]);
    check("cornell", &["denoise.variant=recurrent"]);
    check("cornell", &["denoise.variant=asvgf", "denoise.temporal.specular=better"]);
}

#[test]
fn planes_one_after_the_other() {
    let planes = "gbuffer.decomposition=planes";
    check("glass", &[planes, "indirect.reuse=restir-gi"]);
    check("glass", &[planes, "denoise.variant=svgf"]);
}

#[test]
fn upscaling_and_bloom() {
    check("cornell", &["post.upscale=fsr1", "post.render_scale=0.5", "post.bloom.mode=gaussian"]);
    check("cornell", &["post.upscale=taau", "post.render_scale=0.5", "post.bloom.mode=chain"]);
}
