//! The white furnace: light of radiance 1 from everywhere on bodies that absorb nothing. Where no energy is lost, nothing
//! is seen: every pixel is 1.

use glam::{Affine3A, Vec3};

use super::shapes::Shape;
use super::{add_material, add_mesh};
use crate::{Camera, Environment, Instance, Material, Projection, Scene};

/// Columns: roughness 0, 0.1 .. 1 from left to right. Rows: metalness 1, 0.5, 0 from top to bottom. A cell is 1 m wide and high.
const COLUMNS: u32 = 11;
const ROWS: u32 = 3;

/// Base colour 1, index of refraction 1.5. The bodies are convex polyhedra of 1280 triangles (radius 0.42 m) with their own
/// flat normals, not spheres with interpolated ones: each point sees exactly the hemisphere over its normal, so that the
/// expected radiance is exactly 1 wherever the BSDF reflects everything. The orthographic camera frames the grid;
/// there is nothing else.
pub(super) fn scene() -> Scene {
    let mut scene = Scene { environment: Environment::constant(Vec3::ONE), ..Scene::default() };
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            let roughness = column as f32 / (COLUMNS - 1) as f32;
            let metallic = 1.0 - row as f32 / (ROWS - 1) as f32;
            let name = format!("roughness {roughness:.1} metalness {metallic:.1}");
            let material = Material { roughness, metallic, ..Material::diffuse(&name, Vec3::ONE) };
            let material = add_material(&mut scene, material);
            let mut body = Shape::default();
            body.icosphere(Vec3::ZERO, 0.42, 3, false, material);
            let mesh = add_mesh(&mut scene, &name, body);
            let at = Vec3::new(column as f32 - 0.5 * (COLUMNS - 1) as f32, 1.0 - row as f32, 0.0);
            scene.instances.push(Instance::new(&name, mesh, Affine3A::from_translation(at)));
        }
    }
    let camera = Camera::look_at("front", 10.0 * Vec3::Z, Vec3::ZERO, 1.0);
    scene.cameras.push(Camera { projection: Projection::Orthographic { ymag: 3.2 }, ..camera });
    scene
}
