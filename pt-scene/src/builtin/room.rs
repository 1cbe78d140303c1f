//! A closed room for measuring ray rates: diffuse throughout, so that paths are as incoherent as they get and none leaves the
//! scene, and tessellated to some 240,000 triangles. One mesh, as other programs have it after loading.

use glam::{Vec2, Vec3};

use super::shapes::Shape;
use super::{add_material, place};
use crate::{Camera, Material, Scene};

/// Metres: half of the width, the height, half of the depth.
const HALF: [f32; 2] = [6.0, 4.5];
const HEIGHT: f32 = 4.0;
/// Cells round and along a column, and in a quarter of a sphere's equator.
const COLUMN_CELLS: (usize, usize) = (96, 72);
const SPHERE_CELLS: usize = 72;

pub(super) fn scene() -> Scene {
    let mut scene = Scene::default();
    let mut paint = |name: &str, r: f32, g: f32, b: f32| {
        add_material(&mut scene, Material::lambertian(name, Vec3::new(r, g, b)))
    };
    let wall = paint("wall", 0.75, 0.74, 0.72);
    let floor = paint("floor", 0.45, 0.40, 0.36);
    let stone = paint("stone", 0.70, 0.68, 0.62);
    let balls =
        [paint("red", 0.62, 0.16, 0.12), paint("green", 0.20, 0.50, 0.22), paint("blue", 0.16, 0.28, 0.60)];
    let lamp = add_material(&mut scene, Material::lamp("lamp", Vec3::splat(12.0)));

    let [x, z] = HALF;
    let corner = Vec3::new(-x, 0.0, -z);
    let (across, up, deep) = (Vec3::X * 2.0 * x, Vec3::Y * HEIGHT, Vec3::Z * 2.0 * z);
    let mut shape = Shape::default();
    let mut side = |corner, u, v, material| {
        shape.quad(corner, u, v, Vec2::ONE, material);
    };
    side(corner, deep, across, floor);
    side(corner + up, across, deep, wall);
    side(corner, across, up, wall);
    side(corner + deep, up, across, wall);
    side(corner, up, deep, wall);
    side(corner + across, deep, up, wall);
    for k in 0..3 {
        let left = Vec3::new(-4.0 + 3.0 * k as f32, HEIGHT - 0.01, -1.0);
        side(left, Vec3::X * 2.0, Vec3::Z * 2.0, lamp);
    }

    for k in 0..8 {
        let foot = Vec3::new(-4.5 + 3.0 * (k % 4) as f32, 0.0, if k < 4 { -2.8 } else { 2.8 });
        let swell = |v: f32| Vec2::new(0.28 - 0.05 * v + 0.06 * (40.0 * (v - 0.97)).exp(), HEIGHT * v);
        let flute = |angle: f32, _: f32| 1.0 - 0.06 * (12.0 * angle).cos().abs();
        shape.lathe(foot, COLUMN_CELLS, Vec2::ONE, stone, swell, flute);
    }
    for k in 0..6 {
        let (column, row) = (k % 3, k / 3);
        let at = Vec3::new(-3.2 + 3.1 * column as f32, 0.0, if row == 0 { -0.9 } else { 1.0 });
        let half = Vec3::new(0.35, 0.4 + 0.1 * column as f32, 0.35);
        let top = at + Vec3::Y * 2.0 * half.y;
        shape.cuboid(
            at + Vec3::Y * 1e-3 - half * Vec3::new(1.0, 0.0, 1.0),
            top + half * Vec3::new(1.0, 0.0, 1.0),
            1.0,
            stone,
        );
        shape.sphere(top + Vec3::Y * 0.5, 0.49, SPHERE_CELLS, Vec2::ONE, balls[k % 3]);
    }
    place(&mut scene, "room", shape);
    scene.cameras.push(Camera::look_at("corner", Vec3::new(5.4, 1.9, 4.1), Vec3::new(-1.5, 1.3, -0.8), 1.05));
    scene
}
