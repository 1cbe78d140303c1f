//! The building.

use std::f32::consts::PI;

use glam::{Affine3A, Vec2, Vec3};

use super::super::shapes::{Arch, Shape};
use super::super::{add_mesh, place};
use super::{ARCADE, BAY, BAYS, CAPITAL, CORNICE, END, NAVE, Palette, WALL, bay};
use crate::{Instance, Scene};

/// Floor, walls, arcades, ceilings and the ground outside.
pub(super) fn build(scene: &mut Scene, p: &Palette) {
    let length = 2.0 * END;
    let mut shell = Shape::default();
    let floor = Vec2::new(WALL, END);
    shell.quad(Vec3::new(-WALL, 0.0, END), Vec3::X * 2.0 * WALL, Vec3::Z * -length, floor, p.floor);
    shell.quad(Vec3::new(-0.95, 0.012, 8.4), Vec3::X * 1.9, Vec3::Z * -17.0, Vec2::new(1.0, 9.0), p.carpet);

    // Outer walls: windows to the sun on the left, shallow niches' worth of wall on the right.
    let windows: Vec<Arch> = (0..BAYS)
        .map(|i| Arch { center: (i as f32 + 0.5) * BAY, half_width: 1.05, sill: 0.9, spring: 4.2 })
        .collect();
    shell.wall(
        Vec3::new(-WALL, 0.0, END),
        Vec3::NEG_Z,
        Vec2::new(length, CORNICE),
        0.35,
        &windows,
        p.plaster,
    );
    shell.wall(Vec3::new(WALL, 0.0, -END), Vec3::Z, Vec2::new(length, CORNICE), 0.35, &[], p.plaster);

    // Ends: a great doorway with a screen at the far one, a plain wall at the near one.
    let door = Arch { center: WALL, half_width: 1.7, sill: 0.0, spring: 3.3 };
    let wide = Vec2::new(2.0 * WALL, CORNICE + NAVE + 0.3);
    shell.wall(Vec3::new(-WALL, 0.0, -END), Vec3::X, wide, 0.5, &[door], p.plaster);
    shell.wall(Vec3::new(WALL, 0.0, END), Vec3::NEG_X, wide, 0.5, &[], p.plaster);
    shell.quad(Vec3::new(-1.7, 0.0, -END - 0.3), Vec3::X * 3.4, Vec3::Y * 5.0, Vec2::new(4.0, 5.9), p.screen);

    // Arcades, aisle ceilings, cornices.
    let arches: Vec<Arch> = (0..BAYS)
        .map(|i| Arch { center: (i as f32 + 0.5) * BAY, half_width: 1.62, sill: CAPITAL, spring: CAPITAL })
        .collect();
    for side in [-1.0, 1.0] {
        let (origin, along) = if side < 0.0 {
            (Vec3::new(-NAVE, 0.0, END), Vec3::NEG_Z)
        } else {
            (Vec3::new(NAVE, 0.0, -END), Vec3::Z)
        };
        arcade(&mut shell, origin, along, length, &arches, p.stone);
        let (low, high) = if side < 0.0 { (-WALL, -NAVE - ARCADE) } else { (NAVE + ARCADE, WALL) };
        shell.quad(
            Vec3::new(low, CORNICE, -END),
            Vec3::X * (high - low),
            Vec3::Z * length,
            Vec2::new(1.5, 12.0),
            p.plaster,
        );
        let inner = side * (NAVE - 0.28);
        let (a, b) = (inner.min(side * NAVE), inner.max(side * NAVE));
        shell.cuboid(Vec3::new(a, CORNICE - 0.45, -END), Vec3::new(b, CORNICE - 0.25, END), 0.5, p.stone);
        let inner = side * (NAVE - 0.16);
        let (a, b) = (inner.min(side * NAVE), inner.max(side * NAVE));
        shell.cuboid(Vec3::new(a, CORNICE - 0.62, -END), Vec3::new(b, CORNICE - 0.45, END), 0.5, p.stone);
    }
    vault(&mut shell, p);
    let yard = 60.0;
    shell.quad(
        Vec3::new(-yard, -0.02, yard),
        Vec3::X * 2.0 * yard,
        Vec3::Z * -2.0 * yard,
        Vec2::ONE,
        p.ground,
    );
    place(scene, "hall", shell);
}

/// A wall that stands on columns: only the part over the capitals.
fn arcade(shell: &mut Shape, origin: Vec3, along: Vec3, length: f32, arches: &[Arch], material: u32) {
    let lifted: Vec<Arch> = arches.iter().map(|a| Arch { sill: 0.0, spring: 0.0, ..*a }).collect();
    let base = origin + Vec3::Y * CAPITAL;
    shell.wall(base, along, Vec2::new(length, CORNICE - CAPITAL), ARCADE, &lifted, material);
}

/// A barrel vault with ribs; every other bay is open to the sky at the crown.
fn vault(shell: &mut Shape, p: &Palette) {
    let arc = |radius: f32, angle: f32, z: f32| {
        Vec3::new(-radius * angle.cos(), CORNICE - 0.25 + radius * angle.sin(), z)
    };
    let sheet = |shell: &mut Shape,
                 radius: f32,
                 (a0, a1): (f32, f32),
                 (z0, z1): (f32, f32),
                 cells: (usize, usize),
                 material: u32| {
        let repeat = Vec2::new(radius * (a1 - a0), z1 - z0) * 0.5;
        shell.surface(cells.0, cells.1, repeat, material, |u, v| {
            arc(radius, a0 + (a1 - a0) * u, z0 + (z1 - z0) * v)
        });
    };
    const HALF_OPENING: f32 = 0.34;
    for i in 0..BAYS {
        let (z0, z1) = (bay(i) - 0.5 * BAY, bay(i) + 0.5 * BAY);
        if i % 2 == 1 {
            let (o0, o1) = (bay(i) - 1.3, bay(i) + 1.3);
            sheet(shell, NAVE, (0.0, 0.5 * PI - HALF_OPENING), (z0, z1), (32, 16), p.plaster);
            sheet(shell, NAVE, (0.5 * PI + HALF_OPENING, PI), (z0, z1), (32, 16), p.plaster);
            sheet(
                shell,
                NAVE,
                (0.5 * PI - HALF_OPENING, 0.5 * PI + HALF_OPENING),
                (z0, o0),
                (12, 4),
                p.plaster,
            );
            sheet(
                shell,
                NAVE,
                (0.5 * PI - HALF_OPENING, 0.5 * PI + HALF_OPENING),
                (o1, z1),
                (12, 4),
                p.plaster,
            );
        } else {
            sheet(shell, NAVE, (0.0, PI), (z0, z1), (72, 16), p.plaster);
        }
    }
    for i in 0..=BAYS {
        let z = (END - i as f32 * BAY).clamp(-END + 0.15, END - 0.15);
        sheet(shell, NAVE - 0.14, (0.0, PI), (z - 0.19, z + 0.19), (72, 2), p.stone);
        for (edge, turn) in [(z - 0.19, false), (z + 0.19, true)] {
            shell.surface(72, 1, Vec2::new(5.0, 0.1), p.stone, |u, v| {
                let v = if turn { 1.0 - v } else { v };
                arc(NAVE - 0.14 * v, PI * u, edge)
            });
        }
    }
}

/// One column, placed along both arcades.
pub(super) fn columns(scene: &mut Scene, p: &Palette) {
    let mut column = Shape::default();
    column.cuboid(Vec3::new(-0.46, 0.0, -0.46), Vec3::new(0.46, 0.16, 0.46), 0.7, p.stone);
    // Attic base, shaft with entasis and 20 flutes, capital, abacus.
    column.lathe(
        Vec3::Y * 0.16,
        (48, 24),
        Vec2::new(2.0, 0.3),
        p.stone,
        |v| Vec2::new(0.36 + 0.07 * (v * PI * 2.0).sin().abs() * (1.0 - 0.5 * v), 0.26 * v),
        |_, _| 1.0,
    );
    let shaft = |v: f32| Vec2::new(0.345 - 0.055 * v * v, 0.42 + (CAPITAL - 1.0) * v);
    column.lathe(Vec3::ZERO, (160, 20), Vec2::new(2.0, 3.0), p.stone, shaft, |angle, v| {
        let fade = (v.min(1.0 - v) * 24.0).clamp(0.0, 1.0);
        1.0 - 0.06 * fade * (10.0 * angle).sin().abs().sqrt()
    });
    let top = CAPITAL - 0.58;
    column.lathe(
        Vec3::Y * top,
        (64, 24),
        Vec2::new(2.0, 0.4),
        p.stone,
        |v| Vec2::new(0.30 + 0.17 * v.powf(1.7) + 0.03 * (-(v - 0.12).powi(2) * 900.0).exp(), 0.42 * v),
        |angle, v| 1.0 + 0.05 * (v * PI).sin() * (8.0 * angle).cos(),
    );
    column.cuboid(Vec3::new(-0.5, CAPITAL - 0.16, -0.5), Vec3::new(0.5, CAPITAL, 0.5), 0.7, p.stone);
    let mesh = add_mesh(scene, "column", column);
    for i in 0..=BAYS {
        for side in [-1.0, 1.0] {
            let z = (END - i as f32 * BAY).clamp(-END + 0.35, END - 0.35);
            let at = Vec3::new(side * (NAVE + 0.5 * ARCADE), 0.0, z);
            scene.instances.push(Instance::new("column", mesh, Affine3A::from_translation(at)));
        }
    }
}
