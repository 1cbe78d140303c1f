//! Effects in whole frames: the reference sees the same, and anti-aliasing leaves no trails behind them.

use crate::common::{assert_same, frames_mean, params, polygon, reference_mean};
use glam::{DVec3, Vec3};
use pt_core::trace::TraceBackend;
use pt_post::images::RESOLVED;
use pt_scene::{Beam, Camera, Drift, Effects, Look, Material, Particle, Scene};
use pt_shaders::channels::FLAT_MOTION;
use pt_tests::Frames;

const SIZE: [u32; 2] = [64, 48];
const RATE: f64 = 60.0;
const FRAMES: u32 = 16;

/// A chequered wall that shines, and what moves before it by 1.2 pixels a frame.
fn scene(look: Look) -> Scene {
    let mut scene = Scene::default();
    for i in 0..144 {
        let (x, y) = ((i % 12) as f32 - 6.0, (i / 12) as f32 - 6.0);
        let radiance = Vec3::splat(if (i % 12 + i / 12) % 2 == 0 { 0.3 } else { 0.1 });
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let corners = corners.map(|(u, v)| 0.4 * Vec3::new(x + u, y + v, 0.0));
        polygon(&mut scene, &corners, Material::lamp("wall", radiance));
    }
    let drift = Drift { velocity: Vec3::new(3.5, 0.0, 0.0), ..Drift::default() };
    scene.effects = Effects {
        particles: vec![Particle { position: Vec3::new(-1.0, 0.5, 1.0), radius: 0.35, look, drift }],
        beams: vec![Beam {
            ends: [Vec3::new(-1.0, -0.8, 1.0), Vec3::new(-0.7, -0.2, 1.0)],
            radius: 0.2,
            look,
            drift,
        }],
        ..Effects::default()
    };
    scene
}

/// Error of the picture after some frames in motion against one that has stood still at the same place: relative RMS, and the mean over pixels that an effect
/// has left.
fn trail(look: Look) -> (f64, f64) {
    let params = pt_app::params::resolve(
        Some("realtime"),
        &["indirect.bounces=0", "denoise.variant=off"].map(String::from),
        false,
    )
    .unwrap();
    let camera = Camera::look_at("front", Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, 0.7);
    let run = |moves: bool| {
        let backend = TraceBackend::Compute;
        let mut frames = Frames::with_params(scene(look), &camera, backend, SIZE, 0, false, params.clone());
        let last = f64::from(FRAMES - 1) / RATE;
        for index in 0..FRAMES {
            frames.render(if moves { f64::from(index) / RATE } else { last });
        }
        let pixels: Vec<DVec3> = frames
            .floats(RESOLVED)
            .chunks(4)
            .map(|c| DVec3::new(c[0].into(), c[1].into(), c[2].into()))
            .collect();
        let motion = frames.floats(FLAT_MOTION);
        frames.finish();
        (pixels, motion)
    };
    let (moving, motion) = run(true);
    let (still, _) = run(false);
    let squares: f64 = moving.iter().zip(&still).map(|(a, b)| (*a - *b).length_squared()).sum();
    let total: f64 = still.iter().map(|c| c.length_squared()).sum();
    let followed = motion.chunks(2).filter(|m| m[0] < -1e-3).count();
    assert!(followed > 30, "{followed} pixels have the motion of an effect");
    let left = moving.iter().zip(&still).zip(motion.chunks(2)).filter(|(_, m)| m[0] == 0.0);
    let errors: Vec<f64> = left.map(|((a, b), _)| (*a - *b).length()).collect();
    ((squares / total).sqrt(), errors.iter().sum::<f64>() / errors.len() as f64)
}

#[test]
fn no_trails() {
    for (what, look) in [
        ("smoke", Look { radiance: Vec3::ZERO, opacity: 1.0 }),
        ("light", Look { radiance: Vec3::new(4.0, 2.0, 1.0), opacity: 0.0 }),
    ] {
        let (rms, behind) = trail(look);
        println!("{what}: relative RMS error {rms:.4}, mean error of pixels at rest {behind:.5}");
        assert!(rms < 0.1, "{what}: {rms}");
        assert!(behind < 5e-3, "{what}: {behind}");
    }
}

/// Smoke, sparks, fog, beams and a picture, before the wall, in the mirror and through the glass.
#[test]
fn the_reference_sees_the_same() {
    let size = [48, 27];
    let scene = pt_tests::builtin("effects");
    let camera = scene.default_camera();
    let sets = ["indirect.bounces=4", "gbuffer.reflect_refract=6", "gbuffer.effect_layers=16"];
    let found = frames_mean(&scene, &camera, size, 64, params(&sets));
    let truth = reference_mean(&scene, &camera, size, 8, 128);
    println!("{found:?} {truth:?}");
    assert_same("effects", found, truth, 0.02);
}
