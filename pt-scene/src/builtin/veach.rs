//! The scene of Veach and Guibas 1995, "Optimally Combining Sampling Techniques for Monte Carlo Rendering", figure 2: four
//! plates from nearly smooth to rough mirror four lamps from small to large. Sampling lamps fails for large lamps in smooth
//! plates, sampling the BSDF for small ones in rough plates; the two combined do not fail. The measures are ours.

use std::f64::consts::PI;

use glam::{Affine3A, Mat3A, Vec2, Vec3};

use super::shapes::Shape;
use super::solids::{area, box_faces};
use super::{add_material, add_mesh, place};
use crate::{Camera, Instance, Material, Scene};

/// Radius and place along x of the lamps; all at the origin of y and z.
const LAMPS: [(f32, f32); 4] = [(0.033, -3.6), (0.1, -1.3), (0.3, 1.1), (0.9, 3.7)];
/// Radiant power of each lamp per colour channel, watts: pi x area x radiance.
const POWER: f64 = 40.0;
/// GGX alpha (roughness squared) and centre (y, z) of the plates, far to near.
const PLATES: [(f32, f32, f32); 4] =
    [(0.005, -1.85, 1.4), (0.02, -2.6, 2.8), (0.05, -3.2, 4.4), (0.1, -3.65, 6.2)];
const EYE: Vec3 = Vec3::new(0.0, 1.6, 15.0);

pub(super) fn scene() -> Scene {
    let mut scene = Scene::default();
    let grey = add_material(&mut scene, Material::lambertian("grey", Vec3::splat(0.4)));
    let mut room = Shape::default();
    room.quad(Vec3::new(-14.0, -4.6, 14.0), Vec3::X * 28.0, Vec3::Z * -18.0, Vec2::ONE, grey);
    room.quad(Vec3::new(-14.0, -4.6, -4.0), Vec3::X * 28.0, Vec3::Y * 14.0, Vec2::ONE, grey);
    place(&mut scene, "room", room);

    for (alpha, y, z) in PLATES {
        let center = Vec3::new(0.0, y, z);
        // Half way between the eye and the row of lamps: each plate mirrors all of them.
        let normal = ((EYE - center).normalize() + (-center).normalize()).normalize();
        let name = format!("plate of alpha {alpha}");
        let metal =
            add_material(&mut scene, Material::metal(&name, Vec3::new(0.55, 0.58, 0.62), alpha.sqrt()));
        let mut plate = Shape::default();
        let turn = Mat3A::from_cols(Vec3::X.into(), normal.into(), Vec3::X.cross(normal).into());
        for face in
            box_faces(Vec3::new(4.4, 0.03, 0.62), Affine3A { matrix3: turn, translation: center.into() })
        {
            plate.polygon(&face, |_| Vec2::ZERO, metal);
        }
        place(&mut scene, &name, plate);
    }
    for (radius, x) in LAMPS {
        let name = format!("lamp of radius {radius}");
        let mut body = Shape::default();
        let material = scene.materials.len() as u32;
        body.icosphere(Vec3::ZERO, radius, 3, true, material);
        let body = body.into_mesh();
        let radiance = POWER / (PI * area(&body));
        add_material(&mut scene, Material::lamp(&name, Vec3::splat(radiance as f32)));
        let mesh = add_mesh(&mut scene, &name, body.into());
        scene.instances.push(Instance::new(&name, mesh, Affine3A::from_translation(x * Vec3::X)));
    }
    scene.cameras.push(Camera::look_at("front", EYE, Vec3::new(0.0, -2.4, 0.0), 0.64));
    scene
}
