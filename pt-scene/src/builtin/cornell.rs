//! The Cornell box (Goral et al. 1984) with the measures published by the Cornell Program of Computer Graphics, in
//! millimetres there, in metres here. Its +X points to the left as seen from the camera and +Z away from it; here x and z are
//! mirrored, so that the camera looks along -Z. The measured spectra are given as linear RGB reflectances.

use glam::{Vec2, Vec3};

use super::shapes::Shape;
use super::{add_material, place};
use crate::{Camera, Material, Scene};

/// Depth of the box in its own millimetres.
const DEPTH: f32 = 559.2;

/// Millimetres of the published data to metres of the scene.
fn point([x, y, z]: [f32; 3]) -> Vec3 {
    Vec3::new(-x, y, -z) * 1e-3
}

pub(super) fn scene() -> Scene {
    let mut scene = Scene::default();
    let white = add_material(&mut scene, Material::lambertian("white", Vec3::new(0.73, 0.725, 0.71)));
    let green = add_material(&mut scene, Material::lambertian("green", Vec3::new(0.14, 0.45, 0.091)));
    let red = add_material(&mut scene, Material::lambertian("red", Vec3::new(0.63, 0.065, 0.05)));
    let lamp = add_material(&mut scene, Material::lamp("lamp", Vec3::new(17.0, 12.0, 4.0)));

    // Corners as published: counter-clockwise seen from inside the room, or from outside the blocks.
    let room: [([[f32; 3]; 4], u32); 5] = [
        ([[552.8, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, DEPTH], [549.6, 0.0, DEPTH]], white),
        ([[556.0, 548.8, 0.0], [556.0, 548.8, DEPTH], [0.0, 548.8, DEPTH], [0.0, 548.8, 0.0]], white),
        ([[549.6, 0.0, DEPTH], [0.0, 0.0, DEPTH], [0.0, 548.8, DEPTH], [556.0, 548.8, DEPTH]], white),
        ([[0.0, 0.0, DEPTH], [0.0, 0.0, 0.0], [0.0, 548.8, 0.0], [0.0, 548.8, DEPTH]], green),
        ([[552.8, 0.0, 0.0], [549.6, 0.0, DEPTH], [556.0, 548.8, DEPTH], [556.0, 548.8, 0.0]], red),
    ];
    let mut shape = Shape::default();
    for (corners, material) in room {
        shape.flat(&corners.map(point), material);
    }
    place(&mut scene, "room", shape);

    let mut shape = Shape::default();
    // A tenth of a millimetre under the ceiling: the published data put both in one plane.
    shape.flat(
        &[[343.0, 548.7, 227.0], [343.0, 548.7, 332.0], [213.0, 548.7, 332.0], [213.0, 548.7, 227.0]]
            .map(point),
        lamp,
    );
    place(&mut scene, "lamp", shape);

    block(
        &mut scene,
        "short block",
        165.0,
        [[130.0, 65.0], [82.0, 225.0], [240.0, 272.0], [290.0, 114.0]],
        white,
    );
    block(
        &mut scene,
        "tall block",
        330.0,
        [[423.0, 247.0], [265.0, 296.0], [314.0, 456.0], [472.0, 406.0]],
        white,
    );

    // 35 mm focal length, 25 mm film: yfov = 2 atan(12.5 / 35).
    let eye = point([278.0, 273.0, -800.0]);
    let yfov = 2.0 * (12.5f32 / 35.0).atan();
    scene.cameras.push(Camera::look_at("classic", eye, eye + Vec3::NEG_Z, yfov));
    scene
}

/// Four walls and a lid over the corners (x, z), published in the order of the lid seen from above.
fn block(scene: &mut Scene, name: &str, height: f32, corners: [[f32; 2]; 4], material: u32) {
    let at = |[x, z]: [f32; 2], y| point([x, y, z]);
    let mut shape = Shape::default();
    shape.flat(&corners.map(|c| at(c, height)), material);
    for i in 0..4 {
        let (a, b) = (corners[i], corners[(i + 1) % 4]);
        shape.flat(&[at(b, height), at(a, height), at(a, 0.0), at(b, 0.0)], material);
    }
    place(scene, name, shape);
}

impl Shape {
    /// A flat polygon without a texture.
    fn flat(&mut self, corners: &[Vec3], material: u32) {
        self.polygon(corners, |_| Vec2::ZERO, material);
    }
}
