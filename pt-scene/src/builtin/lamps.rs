//! Many lights, few of them seen: a 3 x 3 flat of rooms with doors, each room full of small lamps.

use glam::{Vec2, Vec3};

use super::shapes::{Arch, Shape};
use super::{add_material, place};
use crate::hash::hash;
use crate::{Camera, CameraKey, CameraPath, Material, Scene};

const ROOMS: i32 = 3;
const SIDE: f32 = 5.0;
const HEIGHT: f32 = 3.0;
const LAMPS_PER_ROOM: i32 = 26;

pub(super) fn scene() -> Scene {
    let mut scene = Scene::default();
    let plaster = add_material(&mut scene, Material::diffuse("plaster", Vec3::new(0.72, 0.70, 0.66)));
    let floor = add_material(
        &mut scene,
        Material { roughness: 0.35, ..Material::diffuse("floor", Vec3::new(0.32, 0.22, 0.15)) },
    );
    let furniture = add_material(&mut scene, Material::diffuse("furniture", Vec3::new(0.25, 0.3, 0.38)));
    let colors = [
        (8.0, 5.6, 3.2),
        (2.0, 5.0, 9.0),
        (8.5, 1.6, 2.4),
        (2.2, 7.6, 3.0),
        (7.6, 2.6, 8.0),
        (7.0, 6.6, 5.8),
    ];
    let lamps = colors.map(|c| add_material(&mut scene, Material::lamp("lamp", 2.5 * Vec3::from(c))));

    let extent = ROOMS as f32 * SIDE;
    let mut shell = Shape::default();
    let whole = Vec2::splat(extent);
    shell.quad(Vec3::new(0.0, 0.0, extent), Vec3::X * extent, Vec3::Z * -extent, whole, floor);
    shell.quad(Vec3::new(0.0, HEIGHT, 0.0), Vec3::X * extent, Vec3::Z * extent, whole, plaster);
    for line in 0..=ROOMS {
        let at = line as f32 * SIDE;
        let doors: Vec<Arch> = (0..ROOMS)
            .filter(|_| line > 0 && line < ROOMS)
            .map(|room| Arch { center: (room as f32 + 0.5) * SIDE, half_width: 0.5, sill: 0.0, spring: 1.7 })
            .collect();
        // Outer walls stand with their thickness outside.
        let depth = if line == 0 { 0.0 } else { 0.12 };
        let size = Vec2::new(extent, HEIGHT);
        shell.wall(Vec3::new(0.0, 0.0, at + depth), Vec3::X, size, 0.12, &doors, plaster);
        shell.wall(Vec3::new(at + depth, 0.0, extent), Vec3::NEG_Z, size, 0.12, &doors, plaster);
    }
    place(&mut scene, "shell", shell);

    let mut pieces = Shape::default();
    let mut lights = Shape::default();
    for room in 0..ROOMS * ROOMS {
        let corner = Vec3::new((room % ROOMS) as f32 * SIDE, 0.0, (room / ROOMS) as f32 * SIDE);
        let random = |i: i32, seed: u32| hash(room, i, seed);
        // In the corners: the doors are in the middle of the walls.
        for i in 0..4 {
            let (east, south) = (3.4 * (i % 2) as f32, 3.4 * (i / 2) as f32);
            let foot =
                corner + Vec3::new(0.3 + east + 0.4 * random(i, 1), 0.0, 0.3 + south + 0.4 * random(i, 2));
            let size =
                Vec3::new(0.3 + 0.5 * random(i, 3), 0.4 + 0.9 * random(i, 4), 0.3 + 0.5 * random(i, 5));
            pieces.cuboid(foot, foot + size, 1.0, furniture);
        }
        for i in 0..LAMPS_PER_ROOM {
            let p = corner
                + Vec3::new(0.4 + 4.2 * random(i, 10), 0.3 + 2.3 * random(i, 11), 0.4 + 4.2 * random(i, 12));
            // Each room has a leading colour and two guests.
            let color = (room as usize + usize::from(random(i, 13) > 0.6) + usize::from(random(i, 14) > 0.8))
                % lamps.len();
            tetrahedron(&mut lights, p, 0.03 + 0.04 * random(i, 15), lamps[color]);
        }
    }
    place(&mut scene, "furniture", pieces);
    place(&mut scene, "lamps", lights);

    // Position and target (x, z): the middle of every door is a station, and corners are cut within the rooms.
    let through = [
        (2.5, 2.5, 7.5, 2.5),
        (5.0, 2.5, 9.0, 2.5),
        (7.5, 2.6, 12.0, 2.5),
        (10.0, 2.5, 13.0, 3.2),
        (12.1, 3.0, 13.0, 6.5),
        (12.5, 5.0, 12.3, 8.6),
        (12.2, 7.3, 9.4, 8.6),
        (10.0, 7.5, 6.0, 7.5),
        (7.5, 7.5, 3.0, 7.5),
        (5.0, 7.5, 1.6, 8.3),
        (2.9, 7.9, 2.0, 11.5),
        (2.5, 10.0, 2.8, 13.5),
        (2.7, 12.0, 4.2, 14.0),
    ];
    let key = |(i, &(x, z, tx, tz)): (usize, &(f32, f32, f32, f32))| CameraKey {
        time: 1.25 * i as f64,
        position: Vec3::new(x, 1.6, z),
        target: Vec3::new(tx, 1.3, tz),
    };
    scene.cameras.push(Camera::look_at("middle", Vec3::new(5.6, 1.7, 9.4), Vec3::new(8.6, 1.1, 5.6), 1.1));
    if let Some(path) = CameraPath::new(through.iter().enumerate().map(key).collect()) {
        scene.cameras.push(Camera::on_path("walk", path, 1.1));
    }
    scene
}

fn tetrahedron(shape: &mut Shape, center: Vec3, size: f32, material: u32) {
    let v = [(1.0, 1.0, 1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0)]
        .map(|p| center + size * Vec3::from(p));
    for face in [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]] {
        shape.polygon(&face.map(|i| v[i]), |_| Vec2::ZERO, material);
    }
}
