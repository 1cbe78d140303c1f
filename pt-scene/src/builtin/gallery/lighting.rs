//! The lights of the gallery.

use std::f32::consts::TAU;

use glam::{Affine3A, Vec2, Vec3};

use super::super::shapes::Shape;
use super::super::{add_mesh, place};
use super::{ARCADE, BAY, BAYS, CORNICE, END, NAVE, Palette, WALL, bay};
use crate::sky::sky;
use crate::{Instance, Light, Motion, Scene};

/// Sun, sky, spots, and all lamps that stand still.
pub(super) fn build(scene: &mut Scene, p: &Palette) {
    let sun = Vec3::new(-0.80, 0.62, -0.28).normalize();
    let sun_light = Light::directional("sun", -sun, 8.0 * Vec3::new(1.0, 0.84, 0.62));
    scene.lights.push(Light { angular_radius: 0.27_f32.to_radians(), ..sun_light });
    scene.environment = sky(sun, 1.1);

    let mut shape = Shape::default();
    for side in [-1.0, 1.0] {
        // Strips on the cornices shine up into the vault.
        for i in 0..BAYS {
            let x = side * (NAVE - 0.12) - 0.06;
            shape.quad(
                Vec3::new(x, CORNICE - 0.24, bay(i) + 1.6),
                Vec3::X * 0.12,
                Vec3::Z * -3.2,
                Vec2::ONE,
                p.cove,
            );
            // Strips under the cornices shine down on the floor.
            let x = side * (NAVE - 0.21) - 0.06;
            shape.quad(
                Vec3::new(x, CORNICE - 0.46, bay(i) - 1.6),
                Vec3::X * 0.12,
                Vec3::Z * 3.2,
                Vec2::ONE,
                p.bulb,
            );
        }
    }
    for i in 0..BAYS {
        // Right aisle: a pair of upright panels beside each picture; left aisle: slim ones between the windows.
        let color = |n: usize| p.panels[n % p.panels.len()];
        for (n, dz) in [(0, -1.45), (3, 1.45)] {
            let corner = Vec3::new(WALL - 0.06, 0.9, bay(i) + dz - 0.16);
            framed_panel(&mut shape, corner, Vec3::Z * 0.32, 3.4, color(i + n), p.steel);
        }
        let corner = Vec3::new(-WALL + 0.06, 1.2, bay(i) - 0.5 * BAY + 0.07);
        if i + 1 < BAYS {
            framed_panel(&mut shape, corner, Vec3::NEG_Z * 0.14, 3.0, color(i + 2), p.steel);
        }
        // Ledges on the outer walls shine up to the ceilings of the aisles, coloured on the right.
        for (side, lamp) in [(-1.0f32, p.cove), (1.0, color(i + 1))] {
            let (a, b) = (side * (WALL - 0.22), side * WALL);
            let z = Vec3::Z * (0.5 * BAY);
            let middle = Vec3::new(0.0, 5.5, bay(i));
            shape.cuboid(
                middle + Vec3::X * a.min(b) - z,
                middle + Vec3::new(a.max(b), 0.1, 0.0) + z,
                0.5,
                p.stone,
            );
            let x = side * (WALL - 0.12) - 0.09;
            shape.quad(Vec3::new(x, 5.61, bay(i) + 1.6), Vec3::X * 0.18, Vec3::Z * -3.2, Vec2::ONE, lamp);
        }
        // Ceilings of the aisles.
        for side in [-1.0, 1.0] {
            let x = side * 0.5 * (NAVE + ARCADE + WALL);
            shape.quad(
                Vec3::new(x - 0.45, CORNICE - 0.02, bay(i) - 0.45),
                Vec3::X * 0.9,
                Vec3::Z * 0.9,
                Vec2::ONE,
                p.cove,
            );
        }
    }
    // A rose of coloured petals over the doorway.
    for i in 0..12 {
        let turn = |r: f32, da: f32| {
            let (sin, cos) = (TAU * (i as f32 + da) / 12.0).sin_cos();
            Vec3::new(r * sin, 7.15 + r * cos, -END + 0.06)
        };
        let petal = [turn(0.35, 0.5), turn(0.85, 0.88), turn(1.2, 0.5), turn(0.85, 0.12)];
        shape.polygon(
            &[petal[0], petal[1], petal[2], petal[3]],
            |_| Vec2::ZERO,
            p.panels[i % p.panels.len()],
        );
    }
    shape.sphere(Vec3::new(0.0, 7.15, -END + 0.1), 0.2, 8, Vec2::ONE, p.bulb);
    // Foot lights along the carpet.
    for i in 0..14 {
        for side in [-1.0, 1.0] {
            let at = Vec3::new(side * 1.25, 0.0, 7.4 - i as f32 * 1.15);
            shape.cuboid(at + Vec3::new(-0.05, 0.0, -0.05), at + Vec3::new(0.05, 0.09, 0.05), 1.0, p.steel);
            shape.cuboid(
                at + Vec3::new(-0.035, 0.09, -0.035),
                at + Vec3::new(0.035, 0.13, 0.035),
                1.0,
                p.panels[(i + 3) % p.panels.len()],
            );
        }
    }
    place(scene, "lamps", shape);
    let down = Vec3::new(0.0, -1.0, 0.0);
    let spot = |x, z, power: Vec3| Light {
        radius: 0.04,
        ..Light::spot("spot", Vec3::new(x, 6.1, z), down, 0.16, 0.34, power)
    };
    scene.lights.push(spot(0.0, -1.5, 260.0 * Vec3::new(1.0, 0.9, 0.75)));
    scene.lights.push(spot(-1.9, 4.0, 150.0 * Vec3::new(0.8, 0.9, 1.0)));
    scene.lights.push(spot(1.9, 4.0, 150.0 * Vec3::new(1.0, 0.85, 0.7)));
}

/// A lamp `u` wide and `height` high in a thin frame, seen from `u` x +Y.
fn framed_panel(shape: &mut Shape, corner: Vec3, u: Vec3, height: f32, lamp: u32, frame: u32) {
    let out = u.cross(Vec3::Y).normalize();
    shape.quad(corner + out * 0.01, u, Vec3::Y * height, Vec2::ONE, lamp);
    let rim = 0.04;
    let along = u.normalize();
    for (a, b) in [(-rim, 0.0), (u.length(), u.length() + rim)] {
        let (p, q) = (
            corner + along * a - out * 0.05 - Vec3::Y * rim,
            corner + along * b + out * 0.06 + Vec3::Y * (height + rim),
        );
        shape.cuboid(p.min(q), p.max(q), 1.0, frame);
    }
    for y in [-rim, height] {
        let (p, q) = (corner - out * 0.05 + Vec3::Y * y, corner + u + out * 0.06 + Vec3::Y * (y + rim));
        shape.cuboid(p.min(q), p.max(q), 1.0, frame);
    }
}

/// Pendant lamps, swaying a little, each at its own pace.
pub(super) fn hangings(scene: &mut Scene, p: &Palette) {
    let mut pendant = Shape::default();
    pendant.lathe(Vec3::ZERO, (6, 1), Vec2::ONE, p.steel, |v| Vec2::new(0.012, -2.9 * (1.0 - v)), |_, _| 1.0);
    pendant.lathe(
        Vec3::Y * -3.0,
        (40, 10),
        Vec2::ONE,
        p.gold,
        |v| Vec2::new(0.30 - 0.27 * v * v, 0.24 * v),
        |_, _| 1.0,
    );
    pendant.sphere(Vec3::Y * -3.08, 0.17, 8, Vec2::ONE, p.bulb);
    let mesh = add_mesh(scene, "pendant", pendant);
    for i in 0..BAYS {
        if i % 2 == 0 {
            let pivot = Vec3::new(0.0, CORNICE + NAVE - 0.3, bay(i));
            let rest = Affine3A::from_translation(pivot);
            let motion = Motion::Sway {
                rest,
                axis: Vec3::Z,
                pivot,
                amplitude_deg: 3.0,
                period_s: 3.4 + 0.3 * i as f64,
            };
            scene.instances.push(Instance::moving("pendant", mesh, motion));
        }
    }
}
