//! Patterns near and far, for the choice of mip levels by ray cones and for what a filter leaves of them. Everything has a known
//! mean: where a pattern is too fine to be seen, its mean is the right answer.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::noise::{fbm, picture};
use super::shapes::Shape;
use super::{add_material, place};
use crate::hash::hash;
use crate::{AlphaMode, Camera, Environment, Light, Material, Scene, Texture, TextureRef};

/// Sides of the signs with zone plates and print, metres: each half the one before.
const SIGNS: [f32; 5] = [1.6, 0.8, 0.4, 0.2, 0.1];

pub(super) fn scene() -> Scene {
    let mut scene = Scene { environment: Environment::constant(Vec3::splat(0.7)), ..Scene::default() };
    let mut textured = |texture: Texture, material: Material| {
        scene.textures.push(texture);
        let base_color_texture = Some(TextureRef::new(scene.textures.len() as u32 - 1));
        add_material(&mut scene, Material { base_color_texture, ..material })
    };
    let white = |name: &str| Material::lambertian(name, Vec3::ONE);
    let checker = textured(checker(), white("checker"));
    let plate = textured(zone_plate(), white("zone plate"));
    let print = textured(print(), white("print"));
    let brick = textured(brick(), white("brick"));
    let wire = Material {
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        double_sided: true,
        roughness: 0.4,
        ..Material::metal("wire", Vec3::splat(0.5), 0.5)
    };
    let wire = textured(wires(), wire);

    // A field of 0.5 m to the horizon: 1000 m deep, 800 wide.
    let mut ground = Shape::default();
    let (width, depth) = (800.0, 1000.0);
    ground.quad(
        Vec3::new(-0.5 * width, 0.0, 10.0),
        Vec3::X * width,
        Vec3::Z * -depth,
        Vec2::new(width, depth),
        checker,
    );
    place(&mut scene, "ground", ground);

    // Zone plates above, print below, from large to small; the first signs are magnified, the last minified.
    let mut signs = Shape::default();
    let mut x = -2.3;
    for side in SIGNS {
        signs.quad(Vec3::new(x, 1.3, -4.0), Vec3::X * side, Vec3::Y * side, Vec2::ONE, plate);
        signs.quad(
            Vec3::new(x, 1.2 - 0.6 * side, -4.0),
            Vec3::X * side,
            Vec3::Y * 0.6 * side,
            Vec2::new(1.0, 0.6),
            print,
        );
        x += side + 0.15;
    }
    place(&mut scene, "signs", signs);

    // A lane between brick walls, seen along them.
    let mut walls = Shape::default();
    walls.quad(Vec3::new(3.0, 0.0, 4.0), Vec3::Z * -60.0, Vec3::Y * 2.5, Vec2::new(48.0, 2.0), brick);
    walls.quad(Vec3::new(4.6, 0.0, -56.0), Vec3::Z * 60.0, Vec3::Y * 2.5, Vec2::new(48.0, 2.0), brick);
    // A close-up of a few texels.
    walls.quad(
        Vec3::new(-3.4, 0.0, -1.5),
        Vec3::new(0.5, 0.0, -0.7),
        Vec3::Y * 0.8,
        Vec2::splat(0.02),
        print,
    );
    place(&mut scene, "walls", walls);

    let mut fence = Shape::default();
    for (z, length) in [(-8.0, 14.0), (-24.0, 40.0)] {
        let corner = Vec3::new(-3.0 - length, 0.0, z);
        fence.quad(corner, Vec3::X * length, Vec3::Y * 1.8, Vec2::new(5.0 * length, 9.0), wire);
    }
    // One that runs away from the viewer.
    fence.quad(Vec3::new(-3.0, 0.0, -8.0), Vec3::Z * -60.0, Vec3::Y * 1.8, Vec2::new(300.0, 9.0), wire);
    place(&mut scene, "fence", fence);

    scene.lights.push(Light::directional("sun", Vec3::new(0.3, -0.7, -0.6), Vec3::splat(2.0)));
    scene.cameras.push(Camera::look_at("front", Vec3::new(-0.3, 1.6, 0.2), Vec3::new(-0.2, 1.45, -8.0), 0.9));
    scene.cameras.push(Camera::look_at("lane", Vec3::new(3.8, 1.5, 3.0), Vec3::new(3.8, 1.2, -20.0), 0.8));
    scene.cameras.push(Camera::look_at("near", Vec3::new(-1.5, 1.9, -3.2), Vec3::new(-1.5, 1.9, -4.0), 0.8));
    scene
}

/// 2 x 2 fields, 0.1 and 0.9: mean 0.5.
fn checker() -> Texture {
    picture("checker", 64, |uv| {
        let cell = (uv * 2.0).floor();
        (Vec3::splat(if (cell.x + cell.y) as i32 % 2 == 0 { 0.9 } else { 0.1 }), 1.0)
    })
}

/// cos(k r^2): the frequency rises in proportion to the radius, to half a cycle per texel at the rim. Mean 0.5.
fn zone_plate() -> Texture {
    const SIZE: u32 = 512;
    picture("zone plate", SIZE, |uv| {
        let r = (uv - 0.5) * SIZE as f32;
        let phase = PI * r.length_squared() / SIZE as f32;
        (Vec3::splat(if r.length() < 0.5 * SIZE as f32 { 0.5 + 0.45 * phase.cos() } else { 0.5 }), 1.0)
    })
}

/// Lines of made-up letters, 5 x 7 dots in cells of 6 x 9, on paper.
fn print() -> Texture {
    const SIZE: u32 = 512;
    picture("print", SIZE, |uv| {
        let p = (uv * SIZE as f32 / 2.0).floor();
        let (cell, dot) = ((p / Vec2::new(6.0, 9.0)).floor(), p % Vec2::new(6.0, 9.0));
        let (x, y) = (cell.x as i32, cell.y as i32);
        // Words are 2 to 8 letters long, and the left half of a letter is mirrored often, as real ones are.
        let space = hash(x, y, 1) < 0.18 || dot.x > 4.0 || dot.y > 6.0;
        let letter = (hash(x, y, 2) * 26.0) as i32;
        let column = if hash(letter, 0, 3) < 0.6 { dot.x.min(4.0 - dot.x) } else { dot.x };
        let stem = column == 0.0 && hash(letter, 1, 3) < 0.8;
        let ink = !space && (stem || hash(letter * 8 + dot.y as i32, column as i32, 4) < 0.38);
        (if ink { Vec3::splat(0.03) } else { Vec3::new(0.85, 0.82, 0.74) }, 1.0)
    })
}

/// Four courses of bricks with joints.
fn brick() -> Texture {
    picture("brick", 256, |uv| {
        let course = (uv.y * 4.0).floor();
        let along = uv.x * 2.0 + 0.5 * (course % 2.0);
        let (f, g) = (along.fract(), (uv.y * 4.0).fract());
        if f < 0.04 || g < 0.10 {
            return (Vec3::splat(0.55), 1.0);
        }
        let shade = 0.75 + 0.4 * hash(along.floor() as i32 % 2, course as i32, 7);
        (Vec3::new(0.45, 0.16, 0.09) * shade * (0.8 + 0.4 * fbm(uv, 16, 3, 20)), 1.0)
    })
}

/// Diagonal wires that cover 28 % of the area (1 - (1 - 0.15)^2).
fn wires() -> Texture {
    picture("wires", 64, |uv| {
        let line = |t: f32| t.rem_euclid(1.0) < 0.15;
        (Vec3::ONE, f32::from(u8::from(line(uv.x + uv.y) || line(uv.x - uv.y))))
    })
}
