//! A room with a window, and what it is made of.

use super::pixels::Pixel;
use glam::{Affine3A, Vec3};
use pt_core::rng::random4;
use pt_light_sampling::test_support::polygon;
use pt_scene::{Environment, EnvironmentImage, Material, Scene};

/// Side of the picture whose lower half shows the wall.
const SIDE: u32 = 16;

pub fn image(width: u32, height: u32, texel: impl Fn(u32, u32) -> f32) -> Environment {
    let texels = (0..width * height).map(|i| Vec3::splat(texel(i % width, i / width))).collect();
    Environment::new(EnvironmentImage { width, height, texels })
}

pub fn rectangle(scene: &mut Scene, corners: [Vec3; 4], material: Material) {
    polygon(scene, &corners, Affine3A::IDENTITY, material);
}

pub fn floor(scene: &mut Scene, half: f32) {
    let corners =
        [(-half, half), (half, half), (half, -half), (-half, -half)].map(|(x, z)| Vec3::new(x, 0.0, z));
    rectangle(scene, corners, Material::lambertian("floor", Vec3::splat(0.5)));
}

/// A room of 4 x 3 x 4 m with a window of 1.2 x 1.2 m in one wall, a small lamp at the ceiling, and a sky.
pub fn room() -> Scene {
    let mut scene = Scene::default();
    let wall = || Material::lambertian("wall", Vec3::splat(0.7));
    let at = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
    floor(&mut scene, 2.0);
    rectangle(
        &mut scene,
        [at(-2.0, 3.0, -2.0), at(2.0, 3.0, -2.0), at(2.0, 3.0, 2.0), at(-2.0, 3.0, 2.0)],
        wall(),
    );
    for side in [-2.0, 2.0] {
        rectangle(
            &mut scene,
            [at(-2.0, 0.0, side), at(2.0, 0.0, side), at(2.0, 3.0, side), at(-2.0, 3.0, side)],
            wall(),
        );
    }
    rectangle(
        &mut scene,
        [at(-2.0, 0.0, -2.0), at(-2.0, 0.0, 2.0), at(-2.0, 3.0, 2.0), at(-2.0, 3.0, -2.0)],
        wall(),
    );
    // Around the window in the wall at x = 2.
    for ([y0, y1], [z0, z1]) in [
        ([0.0, 1.0], [-2.0, 2.0]),
        ([2.2, 3.0], [-2.0, 2.0]),
        ([1.0, 2.2], [-2.0, -0.6]),
        ([1.0, 2.2], [0.6, 2.0]),
    ] {
        rectangle(&mut scene, [at(2.0, y0, z0), at(2.0, y0, z1), at(2.0, y1, z1), at(2.0, y1, z0)], wall());
    }
    let lamp = [(-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1)].map(|(x, z)| at(x, 2.95, z));
    rectangle(&mut scene, lamp, Material::lamp("lamp", Vec3::splat(20.0)));
    scene.environment = image(64, 32, |_, y| if y < 16 { 3.0 + 0.2 * y as f32 } else { 0.5 });
    scene
}

/// Points of the floor and of the wall opposite to the window.
pub fn indoors([x, y]: [u32; 2]) -> Option<Pixel> {
    let [u, v, ..] = random4([x, y], 0, 0, 7).map(|xi| 3.6 * xi - 1.8);
    let on_floor = y < SIDE / 2;
    let (position, normal) = if on_floor {
        (Vec3::new(u, 0.0, v), Vec3::Y)
    } else {
        (Vec3::new(-1.99, 1.5 + 0.7 * u, v), Vec3::X)
    };
    Some(Pixel { position, normal, view: normal, ..Pixel::LAMBERTIAN })
}
