//! Effects in whole frames: the reference sees the same, and anti-aliasing leaves no trails behind them.

use crate::common::{assert_same, frames_mean, params, polygon, reference_mean};
use glam::{DVec3, Vec3};
use pt_core::trace::TraceBackend;
use pt_post::images::RESOLVED;
use pt_scene::{Beam, Camera, Drift, Effects, Light, Look, Material, Particle, Scene, Sprite};
use pt_shaders::channels::FLAT_MOTION;
use pt_tests::Frames;

const SIZE: [u32; 2] = [64, 48];
const RATE: f64 = 60.0;
const FRAMES: u32 = 16;

/// A chequered wall that shines, and what moves before it by 1.2 pixels a frame. `mirrored`: both are behind the camera, which sees them at the same
/// place in a mirror before it.
fn scene(look: Look, mirrored: bool) -> Scene {
    let mut scene = Scene::default();
    let place = |x: f32, y: f32, z: f32| Vec3::new(x, y, if mirrored { 2.0 * MIRROR - z } else { z });
    if mirrored {
        let corners = [(-4.0, -4.0), (4.0, -4.0), (4.0, 4.0), (-4.0, 4.0)];
        let corners = corners.map(|(x, y)| Vec3::new(x, y, MIRROR));
        polygon(&mut scene, &corners, Material::metal("mirror", Vec3::ONE, 0.0));
    }
    for i in 0..144 {
        let (x, y) = ((i % 12) as f32 - 6.0, (i / 12) as f32 - 6.0);
        let radiance = Vec3::splat(if (i % 12 + i / 12) % 2 == 0 { 0.3 } else { 0.1 });
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let mut corners = corners.map(|(u, v)| place(0.4 * (x + u), 0.4 * (y + v), 0.0));
        if mirrored {
            corners.reverse();
        }
        polygon(&mut scene, &corners, Material::lamp("wall", radiance));
    }
    let drift = Drift { velocity: Vec3::new(3.5, 0.0, 0.0), ..Drift::default() };
    scene.effects = Effects {
        particles: vec![Particle { position: place(-1.0, 0.5, 1.0), radius: 0.35, look, drift }],
        beams: vec![Beam {
            ends: [place(-1.0, -0.8, 1.0), place(-0.7, -0.2, 1.0)],
            radius: 0.2,
            look,
            drift,
        }],
        ..Effects::default()
    };
    scene
}

/// Where the mirror is on the z axis.
const MIRROR: f32 = 3.5;

/// Frames that an effect takes to move by ten pixels.
const BEFORE: u32 = 8;

/// Errors of the picture after some frames in motion against one that has stood still at the same place.
struct Trail {
    /// RMS over the pixels that an effect is in, relative to the RMS of what it changes there.
    covered: f64,
    /// Mean over the pixels that an effect has left within the last frames, relative to the mean of what is seen there.
    left: f64,
    /// Pixels that have left.
    count: usize,
    /// Pixels with the motion of an effect.
    followed: usize,
}

fn trail(look: Look, mirrored: bool) -> Trail {
    let scene = |look| scene(look, mirrored);
    let params = pt_app::params::resolve(
        Some("realtime"),
        &["indirect.bounces=0", "denoise.variant=off"].map(String::from),
        false,
    )
    .unwrap();
    let camera = Camera::look_at("front", Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, 0.7);
    // The picture and the motion of the last frame, `frame` being what is shown in frame number `index`.
    let run = |scene: Scene, frame: &dyn Fn(u32) -> u32| {
        let backend = TraceBackend::Compute;
        let mut frames = Frames::with_params(scene, &camera, backend, SIZE, 0, false, params.clone());
        for index in 0..FRAMES {
            frames.render(f64::from(frame(index)) / RATE);
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
    let (moving, motion) = run(scene(look), &|index| index);
    let (still, _) = run(scene(look), &|_| FRAMES - 1);
    let (before, _) = run(scene(look), &|_| FRAMES - 1 - BEFORE);
    let (bare, _) = run(Scene { effects: Effects::default(), ..scene(look) }, &|_| 0);
    let (mut squares, mut total, mut off, mut shown, mut count) = (0.0, 0.0, 0.0, 0.0, 0);
    for (((moving, still), before), bare) in moving.iter().zip(&still).zip(&before).zip(&bare) {
        let error = (*moving - *still).length();
        let is_bare = |pixel: &DVec3| (*pixel - *bare).length() < 0.01 * bare.length();
        if !is_bare(still) {
            squares += error * error;
            total += (*still - *bare).length_squared();
        } else if !is_bare(before) {
            off += error;
            shown += bare.length();
            count += 1;
        }
    }
    let followed = motion.chunks(2).filter(|m| m[0] < -1e-3).count();
    Trail { covered: (squares / total).sqrt(), left: off / shown, count, followed }
}

/// The tolerances are between the errors of the frame and those without the pass `effects motion`: smoke 0.37 and 0.29, light 0.40 and 1.5, and in
/// the mirror, where the motion of the mirrored wall is followed then, light 0.17 of the effect. The
/// rim of smoke stays with the wall, which it hides by less than half.
#[test]
fn no_trails() {
    for (what, look, most_covered, most_left) in [
        ("smoke", Look { radiance: Vec3::ZERO, opacity: 1.0 }, 0.33, 0.15),
        ("light", Look { radiance: Vec3::new(4.0, 2.0, 1.0), opacity: 0.0 }, 0.1, 0.15),
    ] {
        for mirrored in [false, true] {
            let what = if mirrored { format!("{what} in a mirror") } else { what.to_owned() };
            let Trail { covered, left, count, followed } = trail(look, mirrored);
            println!(
                "{what}: {covered:.4} of the effect, {left:.4} of {count} pixels left, {followed} followed"
            );
            assert!(count > 100 && followed > 50, "{what}: {count}, {followed}");
            assert!(covered < most_covered, "{what}: {covered}");
            assert!(left < most_left, "{what}: {left}");
        }
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
    // Interpolated normals and the number of bounces differ by less than this.
    assert_same("effects", found, truth, 0.01);
}

/// What the camera sees of a plate before it is the light of a wall behind it, which the sun lights and between which and the camera effects are: all
/// light comes along bounce rays.
fn plate(material: Material, effects: Effects) -> (Scene, Camera) {
    let mut scene = Scene { effects, ..Scene::default() };
    let quad = |z: f32, half: f32, turn: f32| {
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| half * Vec3::new(turn * x, y, 0.0) + Vec3::new(0.0, 0.0, z))
    };
    polygon(&mut scene, &quad(0.0, 1.5, 1.0), material);
    polygon(&mut scene, &quad(4.0, 6.0, -1.0), Material::lambertian("wall", Vec3::new(0.8, 0.7, 0.6)));
    scene.lights.push(Light::directional("sun", Vec3::new(1.0, 0.0, 0.5), Vec3::splat(4.0)));
    let camera = Camera::look_at("front", Vec3::new(0.0, 0.0, 0.9), Vec3::ZERO, 0.8);
    (scene, camera)
}

const NEAR_BLACK: Vec3 = Vec3::splat(0.05);

/// Effects that only bounce rays meet, in a rough metal and in the specular lobe of a plastic; its diffuse base does not see them.
#[test]
fn rough_surfaces_show_them_along_bounce_rays() {
    let size = [32, 24];
    let beam = Beam {
        ends: [Vec3::new(-1.2, 0.2, 2.4), Vec3::new(1.2, -0.2, 2.6)],
        radius: 0.3,
        look: Look { radiance: Vec3::new(6.0, 3.0, 1.5), opacity: 0.0 },
        drift: Drift::default(),
    };
    let smoke = Sprite {
        position: Vec3::new(0.0, 0.0, 2.0),
        half_sides: [1.1 * Vec3::X, 1.1 * Vec3::Y],
        texture: None,
        look: Look { radiance: Vec3::ZERO, opacity: 0.9 },
        drift: Drift::default(),
    };
    let beam = Effects { beams: vec![beam], ..Effects::default() };
    let smoke = Effects { sprites: vec![smoke], ..Effects::default() };
    let plastic = Material { roughness: 0.35, ..Material::diffuse("plastic", NEAR_BLACK) };
    for material in [Material::metal("metal", Vec3::splat(0.9), 0.35), plastic] {
        let (bare, camera) = plate(material.clone(), Effects::default());
        let bare = reference_mean(&bare, &camera, size, 1, 128).mean;
        for (what, effects, changed) in [("beam", &beam, 1.15..4.0), ("smoke", &smoke, 0.3..0.85)] {
            let (scene, camera) = plate(material.clone(), effects.clone());
            let truth = reference_mean(&scene, &camera, size, 1, 256);
            let change = truth.mean / bare;
            assert!(changed.contains(&change.x), "{what} in {}: {change}", material.name);
            let found = frames_mean(&scene, &camera, size, 96, params(&["indirect.bounces=1"]));
            assert_same(&format!("{what} in {}", material.name), found, truth, 0.005);
            // Metals have no diffuse base and take no part in the reuse.
            if material.name == "plastic" {
                let sets = ["reuse=restir-gi", "restir_history=0", "restir_roughness=0.2", "restir_radius=4"];
                let sets = sets.map(|set| format!("indirect.{set}"));
                let sets = sets.each_ref().map(String::as_str);
                let found = frames_mean(&scene, &camera, size, 96, params(&sets));
                assert_same(&format!("{what} in {}, reused", material.name), found, truth, 0.005);
            }
        }
    }
}
