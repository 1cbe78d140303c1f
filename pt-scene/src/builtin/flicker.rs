//! A stress test for temporal reuse: objects that move in front of and behind others, lights that move and blink, moving shadows,
//! a walking camera. Everything is a function of time alone.

use std::f32::consts::TAU;

use glam::{Affine3A, Quat, Vec2, Vec3};

use super::noise::picture;
use super::shapes::Shape;
use super::{add_material, add_mesh, place};
use crate::{
    Blink, Camera, CameraKey, CameraPath, Instance, Light, LightMotion, Material, Motion, Scene, TextureRef,
};

/// The room: |x| < 5, |z| < 4, 3.6 high.
const HALF: Vec2 = Vec2::new(5.0, 4.0);
const HEIGHT: f32 = 3.6;

pub(super) fn scene() -> Scene {
    let mut scene = Scene::default();
    room(&mut scene);
    bodies(&mut scene);
    lights(&mut scene);
    cameras(&mut scene);
    scene
}

fn room(scene: &mut Scene) {
    scene.textures.push(picture("tiles", 128, |uv| {
        let cell = (uv * 2.0).floor();
        let light = (cell.x + cell.y) as i32 % 2 == 0;
        (if light { Vec3::new(0.55, 0.5, 0.45) } else { Vec3::new(0.2, 0.22, 0.26) }, 1.0)
    }));
    let tiles = Material {
        base_color_texture: Some(TextureRef::new(0)),
        roughness: 0.3,
        ..Material::diffuse("tiles", Vec3::ONE)
    };
    let tiles = add_material(scene, tiles);
    let plaster = add_material(scene, Material::diffuse("plaster", Vec3::new(0.7, 0.68, 0.64)));
    let red = add_material(scene, Material::diffuse("red wall", Vec3::new(0.6, 0.12, 0.08)));
    let stone = add_material(scene, Material::diffuse("stone", Vec3::new(0.45, 0.42, 0.38)));
    let (x, z) = (HALF.x, HALF.y);
    let (across, deep, up) = (Vec3::X * 2.0 * x, Vec3::Z * 2.0 * z, Vec3::Y * HEIGHT);
    let mut shape = Shape::default();
    shape.quad(Vec3::new(-x, 0.0, z), across, -deep, Vec2::new(5.0, 4.0), tiles);
    shape.quad(Vec3::new(-x, HEIGHT, -z), across, deep, Vec2::ONE, plaster);
    shape.quad(Vec3::new(-x, 0.0, -z), across, up, Vec2::ONE, plaster);
    shape.quad(Vec3::new(x, 0.0, z), -across, up, Vec2::ONE, plaster);
    shape.quad(Vec3::new(-x, 0.0, z), -deep, up, Vec2::ONE, red);
    shape.quad(Vec3::new(x, 0.0, -z), deep, up, Vec2::ONE, plaster);
    // Columns, past which things come into view.
    for (cx, cz) in [(-2.2, -1.2), (0.0, -1.6), (2.2, -1.2)] {
        let line = [(0.0, 0.0), (0.18, 0.0), (0.18, HEIGHT - 0.01), (0.0, HEIGHT - 0.01)].map(Vec2::from);
        shape.revolve(Vec3::new(cx, 0.005, cz), 32, &line, |_| stone);
    }
    place(scene, "room", shape);
}

fn bodies(scene: &mut Scene) {
    let gold = add_material(scene, Material::metal("gold", Vec3::new(1.0, 0.71, 0.29), 0.25));
    let blue = add_material(
        scene,
        Material { roughness: 0.4, ..Material::diffuse("blue", Vec3::new(0.06, 0.2, 0.55)) },
    );
    let mirror = add_material(scene, Material::metal("mirror", Vec3::splat(0.92), 0.0));
    let glow = add_material(scene, Material::lamp("glow", Vec3::new(14.0, 9.0, 5.0)));
    let drum = add_material(scene, Material::diffuse("drum", Vec3::splat(0.12)));
    let mut moving = |name: &str, shape: Shape, motion: Motion| {
        let mesh = add_mesh(scene, name, shape);
        scene.instances.push(Instance::moving(name, mesh, motion));
    };

    let mut knot = Shape::default();
    knot.tube((256, 20), 0.12, Vec2::ONE, gold, |u| {
        let (a, b) = (2.0 * TAU * u, 3.0 * TAU * u);
        let r = 0.45 + 0.2 * b.cos();
        Vec3::new(r * a.cos(), r * a.sin(), 0.2 * b.sin())
    });
    let center = Vec3::new(1.2, 1.2, 0.4);
    let rest = Affine3A::from_translation(center);
    moving("knot", knot, Motion::Spin { rest, axis: Vec3::Y, center, deg_per_s: 75.0 });

    let mut block = Shape::default();
    block.cuboid(Vec3::new(-0.35, 0.0, -0.35), Vec3::new(0.35, 0.9, 0.35), 1.0, blue);
    let rest = Affine3A::from_translation(Vec3::new(0.0, 0.005, -2.6));
    moving("block", block, Motion::Slide { rest, reach: Vec3::X * 3.4, period_s: 6.0 });

    let mut ball = Shape::default();
    ball.icosphere(Vec3::ZERO, 0.35, 4, true, mirror);
    let rest = Affine3A::from_translation(Vec3::new(-1.6, 0.85, 1.0));
    moving("mirror ball", ball, Motion::Slide { rest, reach: Vec3::Y * 0.45, period_s: 2.5 });

    // An emitting pendulum.
    let pivot = Vec3::new(-0.6, 3.5, 0.2);
    let mut lamp = Shape::default();
    lamp.icosphere(Vec3::ZERO, 0.12, 2, true, glow);
    let rest = Affine3A::from_translation(pivot - 1.3 * Vec3::Y);
    moving("pendulum", lamp, Motion::Sway { rest, axis: Vec3::Z, pivot, amplitude_deg: 50.0, period_s: 3.0 });

    // A drum with a slit turns round an emitting core: a beam that sweeps the room, on and off for each point.
    let center = Vec3::new(3.6, 1.4, -2.6);
    let mut slit = Shape::default();
    for (radius, side) in [(0.30, 1.0), (0.28, -1.0)] {
        slit.surface(44, 1, Vec2::ONE, drum, |u, v| {
            let angle = 0.10 * TAU + 0.80 * TAU * if side > 0.0 { u } else { 1.0 - u };
            let (sin, cos) = angle.sin_cos();
            Vec3::new(radius * cos, 0.7 * (v - 0.5), -radius * sin)
        });
    }
    let rest = Affine3A::from_translation(center);
    moving("drum", slit, Motion::Spin { rest, axis: Vec3::Y, center, deg_per_s: 200.0 });
    let mut core = Shape::default();
    core.icosphere(center, 0.1, 2, true, glow);
    place(scene, "core", core);
}

fn lights(scene: &mut Scene) {
    let point = |name: &str, path: Motion, peak: Vec3, blink: Blink| {
        Light::point(name, Vec3::ZERO, peak).moving(LightMotion { path, peak, blink })
    };
    let at = |p: Vec3| Affine3A::from_translation(p);
    let center = Vec3::new(1.2, 2.4, 0.4);
    let rest = at(center + 1.1 * Vec3::X);
    scene.lights.push(point(
        "orbiter",
        Motion::Spin { rest, axis: Vec3::Y, center, deg_per_s: 120.0 },
        Vec3::new(2.0, 5.0, 9.0),
        Blink::Steady,
    ));
    scene.lights.push(point(
        "alarm",
        Motion::rest(at(Vec3::new(-4.6, 3.1, -3.4))),
        Vec3::new(16.0, 1.0, 0.5),
        Blink::Square { period_s: 0.8, share: 0.5, phase: 0.0 },
    ));
    scene.lights.push(point(
        "tube",
        Motion::rest(at(Vec3::new(4.4, 3.3, 3.4))),
        Vec3::new(7.0, 8.0, 8.0),
        Blink::Square { period_s: 0.23, share: 0.7, phase: 0.4 },
    ));
    scene.lights.push(point(
        "flame",
        Motion::rest(at(Vec3::new(-4.4, 1.2, 2.8))),
        Vec3::new(9.0, 4.5, 1.5),
        Blink::Flame { rate_hz: 9.0, low: 0.35, seed: 11 },
    ));
    // Looks down along its -Z at rest and swings from side to side.
    let pivot = Vec3::new(0.0, 3.4, 3.2);
    let rest = Affine3A::from_rotation_translation(Quat::from_rotation_x(-1.0), pivot);
    let peak = 60.0 * Vec3::new(1.0, 0.95, 0.8);
    let spot = Light::spot("search light", pivot, Vec3::NEG_Y, 0.16, 0.22, peak);
    let path = Motion::Sway { rest, axis: Vec3::Y, pivot, amplitude_deg: 55.0, period_s: 4.0 };
    scene.lights.push(spot.moving(LightMotion { path, peak, blink: Blink::Pulse { period_s: 5.0 } }));
}

fn cameras(scene: &mut Scene) {
    scene.cameras.push(Camera::look_at("still", Vec3::new(0.3, 1.6, 3.8), Vec3::new(0.1, 1.3, -2.0), 1.0));
    let stations: [[[f32; 3]; 2]; 6] = [
        [[0.3, 1.6, 3.5], [0.1, 1.3, -2.0]],
        [[-2.6, 1.7, 2.8], [0.6, 1.2, -1.0]],
        [[-3.6, 1.5, 0.2], [0.0, 1.2, -2.2]],
        [[-3.2, 1.4, -2.0], [1.5, 1.2, 0.0]],
        [[-3.6, 1.6, 0.4], [1.5, 1.3, -0.4]],
        [[-1.2, 1.7, 3.2], [2.6, 1.2, -2.0]],
    ];
    let key = |(i, &[position, target]): (usize, &[[f32; 3]; 2])| CameraKey {
        time: 1.5 * i as f64,
        position: position.into(),
        target: target.into(),
    };
    if let Some(path) = CameraPath::new(stations.iter().enumerate().map(key).collect()) {
        scene.cameras.push(Camera::on_path("walk", path, 1.0));
    }
}
