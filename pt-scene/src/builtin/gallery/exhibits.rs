//! The exhibits of the gallery.

use std::f32::consts::{PI, TAU};

use glam::{Affine3A, Quat, Vec2, Vec3};

use super::super::shapes::Shape;
use super::super::{add_mesh, place};
use super::{Palette, WALL, bay};
use crate::{Instance, Motion, Scene};

fn plinth(shape: &mut Shape, at: Vec3, half: f32, height: f32, material: u32) {
    let h = Vec3::new(half, 0.0, half);
    let rim = Vec3::new(0.06, 0.0, 0.06);
    shape.cuboid(at - h - rim, at + h + rim + Vec3::Y * 0.1, 0.8, material);
    shape.cuboid(at - h + Vec3::Y * 0.1, at + h + Vec3::Y * (height - 0.08), 0.8, material);
    shape.cuboid(at - h - rim + Vec3::Y * (height - 0.08), at + h + rim + Vec3::Y * height, 0.8, material);
}

/// Sculptures, plinths, benches, pictures, glass and the mirror.
pub(super) fn build(scene: &mut Scene, p: &Palette) {
    let mut still = Shape::default();
    plinth(&mut still, Vec3::new(0.0, 0.0, -1.5), 0.55, 0.95, p.stone);
    plinth(&mut still, Vec3::new(-1.9, 0.0, 4.0), 0.36, 1.0, p.stone);
    plinth(&mut still, Vec3::new(1.9, 0.0, 4.0), 0.36, 1.0, p.stone);
    plinth(&mut still, Vec3::new(-1.9, 0.0, -6.0), 0.36, 1.0, p.stone);
    plinth(&mut still, Vec3::new(1.9, 0.0, -6.0), 0.36, 1.0, p.stone);
    // Benches.
    for (x, z) in [(-5.1, 2.0), (-5.1, -2.0), (5.0, 2.0), (5.0, -2.0)] {
        let at = Vec3::new(x, 0.0, z);
        still.cuboid(at + Vec3::new(-0.25, 0.40, -0.9), at + Vec3::new(0.25, 0.47, 0.9), 1.0, p.wood);
        for dz in [-0.7, 0.7] {
            still.cuboid(
                at + Vec3::new(-0.2, 0.0, dz - 0.06),
                at + Vec3::new(0.2, 0.40, dz + 0.06),
                1.0,
                p.wood,
            );
        }
    }
    // A pane in a stand, and a mirror that leans against the last pier.
    still.quad(Vec3::new(-2.6, 0.12, 0.9), Vec3::new(0.75, 0.0, -0.9), Vec3::Y * 1.9, Vec2::ONE, p.tinted);
    for at in [Vec3::new(-2.6, 0.0, 0.9), Vec3::new(-1.85, 0.0, 0.0)] {
        still.cuboid(at - Vec3::new(0.04, 0.0, 0.04), at + Vec3::new(0.04, 2.06, 0.04), 1.0, p.steel);
    }
    for i in 0..3 {
        let z = bay(2 * i);
        let corner = Vec3::new(WALL - 0.08, 1.5, z - 0.85);
        still.quad(corner, Vec3::Z * 1.7, Vec3::Y * 1.7, Vec2::ONE, p.paintings[i]);
        frame(&mut still, corner, 1.7, 1.7, p.gold);
    }
    for i in 0..3 {
        let z = bay(2 * i + 1);
        let corner = Vec3::new(WALL - 0.08, 0.75, z - 0.7);
        let material = if i == 1 { p.mirror } else { p.paintings[(i + 1) % 3] };
        still.quad(corner, Vec3::Z * 1.4, Vec3::Y * 2.9, Vec2::ONE, material);
        frame(&mut still, corner, 1.4, 2.9, p.wood);
    }
    still.cuboid(Vec3::new(1.65, 1.0, -6.25), Vec3::new(2.15, 1.5, -5.75), 1.0, p.steel);
    still.sphere(Vec3::new(1.9, 1.36, 4.0), 0.36, 48, Vec2::new(4.0, 2.0), p.copper);
    still.sphere(Vec3::new(-1.9, 1.36, 4.0), 0.36, 48, Vec2::ONE, p.glass);
    place(scene, "exhibits", still);

    // A (2, 3) torus knot turns over the middle plinth.
    let mut knot = Shape::default();
    knot.tube((640, 32), 0.13, Vec2::new(24.0, 1.0), p.gold, |u| {
        let (a, b) = (2.0 * TAU * u, 3.0 * TAU * u);
        let r = 0.52 + 0.24 * b.cos();
        Vec3::new(r * a.cos(), r * a.sin(), 0.24 * b.sin())
    });
    let center = Vec3::new(0.0, 2.05, -1.5);
    let mesh = add_mesh(scene, "knot", knot);
    let rest = Affine3A::from_translation(center);
    scene.instances.push(Instance::moving(
        "knot",
        mesh,
        Motion::Spin { rest, axis: Vec3::Y, center, deg_per_s: 24.0 },
    ));

    // A fluted copper spindle turns the other way.
    let mut spindle = Shape::default();
    let profile = |v: f32| {
        Vec2::new((0.28 * (PI * v).sin().powf(0.7) * (0.75 + 0.25 * (5.0 * PI * v).cos())).max(1e-3), 1.1 * v)
    };
    spindle.lathe(Vec3::ZERO, (144, 96), Vec2::new(4.0, 2.0), p.copper, profile, |angle, v| {
        1.0 + 0.12 * (6.0 * angle + 9.0 * v).cos()
    });
    let center = Vec3::new(-1.9, 1.0, -6.0);
    let mesh = add_mesh(scene, "spindle", spindle);
    let rest = Affine3A::from_translation(center);
    scene.instances.push(Instance::moving(
        "spindle",
        mesh,
        Motion::Spin { rest, axis: Vec3::Y, center, deg_per_s: -40.0 },
    ));
}

/// A picture frame on the right wall round a picture `width` along +Z and `height` up.
fn frame(shape: &mut Shape, corner: Vec3, width: f32, height: f32, material: u32) {
    let rim = 0.1;
    let (near, far) = (corner.x - 0.07, corner.x + 0.08);
    let mut bar = |z0: f32, z1: f32, y0: f32, y1: f32| {
        shape.cuboid(
            Vec3::new(near, corner.y + y0, corner.z + z0),
            Vec3::new(far, corner.y + y1, corner.z + z1),
            1.0,
            material,
        );
    };
    bar(-rim, 0.0, -rim, height + rim);
    bar(width, width + rim, -rim, height + rim);
    bar(0.0, width, -rim, 0.0);
    bar(0.0, width, height, height + rim);
}

/// Palms in pots: leaves cut out by alpha.
pub(super) fn plants(scene: &mut Scene, p: &Palette) {
    let mut plant = Shape::default();
    plant.lathe(
        Vec3::ZERO,
        (40, 12),
        Vec2::new(3.0, 1.0),
        p.copper,
        |v| Vec2::new(0.2 + 0.1 * v.sqrt(), 0.5 * v),
        |_, _| 1.0,
    );
    for i in 0..72 {
        let level = (i as f32 + 0.5) / 72.0;
        let mut leaf = Shape::default();
        // A leaf bends as it goes: 6 pieces along its length.
        let (length, width, bend) = (0.95 - 0.35 * level, 0.30 - 0.1 * level, 1.5 - 1.0 * level);
        leaf.surface(2, 6, Vec2::ONE, p.leaf, |u, v| {
            let angle = 1.45 - bend * v - (1.0 - level) * 0.5;
            Vec3::new(
                (u - 0.5) * width,
                v * length * angle.sin() + 0.1 * (u - 0.5).abs(),
                v * length * angle.cos(),
            )
        });
        let turn = Quat::from_rotation_y(2.399_963 * i as f32);
        let at = Affine3A::from_rotation_translation(turn, Vec3::Y * (0.5 + 0.75 * level))
            * Affine3A::from_translation(Vec3::Z * 0.04);
        plant.merge(leaf.transformed(at));
    }
    let mesh = add_mesh(scene, "plant", plant);
    for (i, (x, z)) in [(-5.6, 8.0), (-5.6, 0.0), (-5.6, -8.0), (2.35, -10.9), (-2.35, -10.9), (2.3, 7.6)]
        .into_iter()
        .enumerate()
    {
        let at = Affine3A::from_rotation_translation(Quat::from_rotation_y(i as f32), Vec3::new(x, 0.0, z));
        scene.instances.push(Instance::new("plant", mesh, at));
    }
}
