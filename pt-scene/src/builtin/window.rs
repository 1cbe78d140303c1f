//! A room with one window, lit by the sky that the window shows and by a small lamp: directions of the sky are worth a sample only through the
//! window, which is a portal.

use glam::{Vec2, Vec3};

use super::shapes::Shape;
use super::{add_material, place};
use crate::{Camera, Material, Portal, Scene};

/// Width, height and depth of the room, metres; the corner at the origin.
const ROOM: Vec3 = Vec3::new(4.0, 3.0, 5.0);
/// Thickness of the walls.
const WALL: f32 = 0.2;
/// The window in the wall at x = 4: its heights and depths, from and to.
const WINDOW: [[f32; 2]; 2] = [[1.0, 2.2], [2.2, 3.4]];

pub(super) fn scene() -> Scene {
    let sky = crate::sky::sky(Vec3::new(0.8, 0.55, -0.25).normalize(), 6.0);
    let mut scene = Scene { environment: sky, ..Scene::default() };
    let mut paint = |name: &str, r: f32, g: f32, b: f32| {
        add_material(&mut scene, Material::lambertian(name, Vec3::new(r, g, b)))
    };
    let [wall, floor] = [paint("wall", 0.74, 0.72, 0.68), paint("floor", 0.42, 0.33, 0.26)];
    let [wood, cloth] = [paint("wood", 0.35, 0.22, 0.14), paint("cloth", 0.18, 0.3, 0.5)];
    let glaze = Material { roughness: 0.25, ..Material::lambertian("glaze", Vec3::new(0.6, 0.62, 0.6)) };
    let glaze = add_material(&mut scene, glaze);
    let lamp = add_material(&mut scene, Material::lamp("lamp", Vec3::splat(20.0)));

    let mut shape = Shape::default();
    let mut slab = |min: [f32; 3], max: [f32; 3], material| {
        shape.cuboid(Vec3::from(min), Vec3::from(max), 1.0, material);
    };
    let [x, y, z] = ROOM.to_array();
    slab([-WALL, -WALL, -WALL], [x + WALL, 0.0, z + WALL], floor);
    slab([-WALL, y, -WALL], [x + WALL, y + WALL, z + WALL], wall);
    slab([-WALL, 0.0, -WALL], [0.0, y, z + WALL], wall);
    slab([0.0, 0.0, -WALL], [x, y, 0.0], wall);
    slab([0.0, 0.0, z], [x, y, z + WALL], wall);
    // Around the window: below, above, beside.
    let [[bottom, top], [near, far]] = WINDOW;
    slab([x, 0.0, -WALL], [x + WALL, bottom, z + WALL], wall);
    slab([x, top, -WALL], [x + WALL, y, z + WALL], wall);
    slab([x, bottom, -WALL], [x + WALL, top, near], wall);
    slab([x, bottom, far], [x + WALL, top, z + WALL], wall);
    // A table, a chest and a lamp at the ceiling.
    slab([1.2, 0.72, 1.4], [2.4, 0.78, 2.2], wood);
    for [leg_x, leg_z] in [[1.25, 1.45], [2.29, 1.45], [1.25, 2.09], [2.29, 2.09]] {
        slab([leg_x, 0.0, leg_z], [leg_x + 0.06, 0.72, leg_z + 0.06], wood);
    }
    slab([0.05, 0.0, 2.6], [0.6, 0.9, 4.0], cloth);
    slab([1.9, y - 0.06, 2.4], [2.1, y - 0.02, 2.6], lamp);
    shape.sphere(Vec3::new(1.8, 0.98, 1.8), 0.2, 24, Vec2::ONE, glaze);
    place(&mut scene, "room", shape);

    // On the inner side of the wall.
    let corner = Vec3::new(x, bottom, near);
    scene.portals.push(Portal { corner, edges: [(top - bottom) * Vec3::Y, (far - near) * Vec3::Z] });
    let (eye, target) = (Vec3::new(3.6, 1.6, 4.7), Vec3::new(1.2, 0.9, 1.4));
    scene.cameras.push(Camera::look_at("corner", eye, target, 1.1));
    scene
}
