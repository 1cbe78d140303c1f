//! A point light over a plane: direct light has a closed form everywhere.

use glam::{Vec2, Vec3};

use super::shapes::Shape;
use super::{add_material, place};
use crate::{Camera, Light, Material, Scene};

/// Light of 100 cd, 2 m over a Lambertian plane (y = 0, 200 m square, albedo 0.5): radiance at distance r from the foot is
/// 0.5/pi x 100 x 2 / (r^2 + 4)^(3/2).
pub(super) fn scene() -> Scene {
    let mut scene = Scene::default();
    let grey = add_material(&mut scene, Material::lambertian("grey", Vec3::splat(0.5)));
    let mut shape = Shape::default();
    shape.quad(Vec3::new(-100.0, 0.0, 100.0), Vec3::X * 200.0, Vec3::Z * -200.0, Vec2::ONE, grey);
    place(&mut scene, "plane", shape);
    scene.lights.push(Light::point("lamp", Vec3::Y * 2.0, Vec3::splat(100.0)));
    scene.cameras.push(Camera::look_at("oblique", Vec3::new(0.0, 3.0, 6.0), Vec3::ZERO, 0.8));
    scene.cameras.push(Camera::look_at("above", Vec3::new(0.0, 5.0, 0.0), Vec3::ZERO, 0.8));
    scene
}
