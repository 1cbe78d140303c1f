//! The show-piece: a vaulted hall of six bays along -Z with aisles, lit by the sun, a sky, and many coloured lamps.
//!
//! Nave: |x| < 3.2, vault from y = 6.6; aisles to |x| = 6.5 under a flat ceiling; z from -12 to 12.
//! Composed for direct light: every large surface sees the sky through an opening, a cove, a panel or a lamp.

use std::f32::consts::{PI, TAU};

use glam::{Affine3A, Quat, Vec2, Vec3};

use super::shapes::{Arch, Shape};
use super::{add_material, add_mesh, gallery_art as art, place};
use crate::sky::sky;
use crate::{
    AlphaMode, Camera, CameraKey, CameraPath, Instance, Light, Material, Motion, Scene, Texture, TextureRef,
};

const BAYS: usize = 6;
const BAY: f32 = 4.0;
/// Half the length of the hall.
const END: f32 = 12.0;
/// Half the width of the nave, and of the whole hall.
const NAVE: f32 = 3.2;
const WALL: f32 = 6.5;
/// Height of capitals, of the cornice, and thickness of the arcade.
const CAPITAL: f32 = 4.1;
const CORNICE: f32 = 6.6;
const ARCADE: f32 = 0.7;

/// Material indices.
struct Palette {
    floor: u32,
    stone: u32,
    plaster: u32,
    wood: u32,
    carpet: u32,
    gold: u32,
    copper: u32,
    steel: u32,
    mirror: u32,
    glass: u32,
    tinted: u32,
    leaf: u32,
    screen: u32,
    paintings: [u32; 3],
    ground: u32,
    cove: u32,
    bulb: u32,
    panels: [u32; 6],
}

pub(super) fn scene() -> Scene {
    let mut scene = Scene::default();
    let palette = palette(&mut scene);
    hall(&mut scene, &palette);
    columns(&mut scene, &palette);
    lights(&mut scene, &palette);
    exhibits(&mut scene, &palette);
    hangings(&mut scene, &palette);
    plants(&mut scene, &palette);
    cameras(&mut scene);
    scene
}

fn palette(scene: &mut Scene) -> Palette {
    fn add(scene: &mut Scene, texture: Texture) -> Option<TextureRef> {
        scene.textures.push(texture);
        Some(TextureRef::new(scene.textures.len() as u32 - 1))
    }
    let white = |name: &str, roughness| Material { roughness, ..Material::diffuse(name, Vec3::ONE) };
    let mut textured = |texture: Texture, material: Material| {
        let base_color_texture = add(scene, texture);
        add_material(scene, Material { base_color_texture, ..material })
    };
    let masked =
        |m: Material| Material { alpha_mode: AlphaMode::Mask { cutoff: 0.5 }, double_sided: true, ..m };
    let [floor_color, floor_roughness] = art::floor();
    let [plaster_color, plaster_relief] = art::plaster();
    let [carpet_color, carpet_weave] = art::carpet();
    let floor = textured(floor_color, white("floor", 1.0));
    let stone = textured(art::stone(), white("stone", 0.55));
    let plaster = textured(plaster_color, white("plaster", 0.85));
    let wood = textured(art::wood(), white("wood", 0.45));
    let carpet = textured(carpet_color, white("carpet", 0.95));
    let leaf = textured(art::leaf(), masked(white("leaf", 0.5)));
    let brass = Material::metal("screen", Vec3::new(0.75, 0.55, 0.28), 0.4);
    let screen = textured(art::screen(), masked(brass));
    let paintings =
        [art::landscape(), art::abstraction(), art::waves()].map(|t| textured(t, white("painting", 0.5)));
    scene.materials[floor as usize].metallic_roughness_texture = add(scene, floor_roughness);
    scene.materials[plaster as usize].normal_texture = add(scene, plaster_relief);
    scene.materials[carpet as usize].normal_texture = add(scene, carpet_weave);
    let grooves = add(scene, art::brushed());
    let panels = [
        (1.0, 0.09, 0.04),
        (1.0, 0.42, 0.04),
        (0.08, 0.85, 0.18),
        (0.03, 0.55, 1.0),
        (0.22, 0.12, 1.0),
        (1.0, 0.05, 0.5),
    ];
    Palette {
        floor,
        stone,
        plaster,
        wood,
        carpet,
        leaf,
        screen,
        paintings,
        gold: add_material(scene, Material::metal("gold", Vec3::new(1.0, 0.71, 0.29), 0.28)),
        copper: add_material(scene, Material::metal("copper", Vec3::new(0.93, 0.52, 0.38), 0.35)),
        steel: add_material(
            scene,
            Material {
                normal_texture: grooves,
                ..Material::metal("brushed steel", Vec3::new(0.56, 0.57, 0.58), 0.38)
            },
        ),
        mirror: add_material(scene, Material::metal("mirror", Vec3::splat(0.94), 0.0)),
        glass: add_material(
            scene,
            Material {
                transmission: 1.0,
                roughness: 0.0,
                thickness: 1.0,
                attenuation_color: Vec3::new(0.75, 0.95, 0.9),
                attenuation_distance: 0.8,
                ..Material::diffuse("glass", Vec3::ONE)
            },
        ),
        tinted: add_material(
            scene,
            Material {
                transmission: 1.0,
                roughness: 0.0,
                double_sided: true,
                ..Material::diffuse("tinted pane", Vec3::new(0.35, 0.75, 0.85))
            },
        ),
        ground: add_material(scene, Material::diffuse("ground", Vec3::new(0.36, 0.38, 0.26))),
        cove: add_material(scene, Material::lamp("cove", 14.0 * Vec3::new(1.0, 0.72, 0.45))),
        bulb: add_material(scene, Material::lamp("bulb", 28.0 * Vec3::new(1.0, 0.74, 0.46))),
        panels: panels.map(|c| add_material(scene, Material::lamp("panel", 3.2 * Vec3::from(c)))),
    }
}

/// Middle of a bay along z, from the near end to the far one.
fn bay(i: usize) -> f32 {
    END - (i as f32 + 0.5) * BAY
}

fn hall(scene: &mut Scene, p: &Palette) {
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

fn columns(scene: &mut Scene, p: &Palette) {
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

fn lights(scene: &mut Scene, p: &Palette) {
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

fn plinth(shape: &mut Shape, at: Vec3, half: f32, height: f32, material: u32) {
    let h = Vec3::new(half, 0.0, half);
    let rim = Vec3::new(0.06, 0.0, 0.06);
    shape.cuboid(at - h - rim, at + h + rim + Vec3::Y * 0.1, 0.8, material);
    shape.cuboid(at - h + Vec3::Y * 0.1, at + h + Vec3::Y * (height - 0.08), 0.8, material);
    shape.cuboid(at - h - rim + Vec3::Y * (height - 0.08), at + h + rim + Vec3::Y * height, 0.8, material);
}

fn exhibits(scene: &mut Scene, p: &Palette) {
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

/// Pendant lamps, swaying a little, each at its own pace.
fn hangings(scene: &mut Scene, p: &Palette) {
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

fn plants(scene: &mut Scene, p: &Palette) {
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

fn cameras(scene: &mut Scene) {
    scene.cameras.push(Camera::look_at(
        "main",
        Vec3::new(-0.75, 1.75, 11.2),
        Vec3::new(0.25, 2.9, -4.0),
        0.98,
    ));
    let stations = [
        ((-0.75, 1.75, 11.2), (0.25, 2.9, -4.0)),
        ((-0.4, 1.8, 7.0), (1.9, 1.6, 3.0)),
        ((0.3, 1.9, 2.6), (0.0, 2.0, -1.5)),
        ((2.2, 1.7, 0.2), (6.4, 2.3, -2.5)),
        ((4.9, 1.7, -3.6), (6.4, 2.2, -6.2)),
        ((2.6, 1.9, -8.2), (-1.9, 1.6, -6.0)),
        ((-0.5, 2.2, -9.4), (0.0, 3.4, 0.0)),
        ((-5.0, 1.8, -6.0), (-3.0, 2.4, 4.0)),
        ((-5.0, 1.8, 1.5), (0.0, 2.6, 0.0)),
    ];
    let key = |(i, &(position, target)): (usize, &((f32, f32, f32), (f32, f32, f32)))| CameraKey {
        time: 2.5 * i as f64,
        position: position.into(),
        target: target.into(),
    };
    if let Some(path) = CameraPath::new(stations.iter().enumerate().map(key).collect()) {
        scene.cameras.push(Camera::on_path("tour", path, 1.05));
    }
    scene.cameras.push(Camera::look_at("aisle", Vec3::new(4.3, 1.7, 10.5), Vec3::new(5.6, 2.1, -4.0), 1.0));
    let close = Camera::look_at("close", Vec3::new(-0.9, 1.65, 2.3), Vec3::new(0.0, 2.0, -1.5), 0.7);
    scene.cameras.push(Camera { lens_radius: 0.02, ..close });
}
