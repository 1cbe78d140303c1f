//! Lamps of one triangle each, made by the program: those of the hall of a sweep, and those that `--lamps` hangs into a scene.

use anyhow::{Context, Result};
use glam::{Affine3A, Vec2, Vec3, Vec4};
use pt_core::rng::random4;
use pt_scene::{Bounds, Instance, Material, Mesh, Scene};

/// Most lamps: indices of lights have 32 bits, and some bits are kept free.
pub const MOST: u32 = 1 << 24;
/// Side of a lamp that `--lamps` hangs up, as a share of the diagonal of the scene.
const SIDE_SHARE: f32 = 0.005;
/// Flux of all of them over the area of the scene's box: mean radiance times area, W / sr / m^2.
const FLUX: f32 = 0.3;

/// `count` triangles of one size, turned in any direction, with a corner in the box.
pub fn triangles(count: u32, within: Bounds, side: f32) -> Vec<[Vec3; 3]> {
    let triangle = |i| {
        let random = |dimension| random4([i, 0], 0, dimension, 17);
        let ([x, y, z, _], [a, b, c, d]) = (random(0), random(1));
        let middle = within.min + Vec3::new(x, y, z) * within.size();
        let e1 = (Vec3::new(a, b, c) - 0.5).normalize_or(Vec3::X);
        let e2 = e1.any_orthonormal_vector();
        let e2 = e2 * (std::f32::consts::TAU * d).cos() + e1.cross(e2) * (std::f32::consts::TAU * d).sin();
        [middle, middle + side * e1, middle + side * e2]
    };
    (0..count).map(triangle).collect()
}

/// A mesh of one material.
pub fn mesh(name: &str, triangles: &[[Vec3; 3]], material: u32) -> Mesh {
    let vertices = 3 * triangles.len();
    let normal = |t: &[Vec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]).normalize_or(Vec3::Y);
    Mesh {
        name: name.into(),
        positions: triangles.concat(),
        normals: triangles.iter().flat_map(|t| [normal(t); 3]).collect(),
        tangents: vec![Vec4::X; vertices],
        uv0: vec![Vec2::ZERO; vertices],
        uv1: vec![Vec2::ZERO; vertices],
        colors: vec![Vec4::ONE; vertices],
        indices: (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        triangle_materials: vec![material; triangles.len()],
        first_masked: triangles.len(),
        ..Mesh::default()
    }
}

/// Adds an instance of triangles of a material.
pub fn place(scene: &mut Scene, name: &str, triangles: &[[Vec3; 3]], material: Material) {
    scene.instances.push(Instance::new(name, scene.meshes.len() as u32, Affine3A::IDENTITY));
    scene.meshes.push(mesh(name, triangles, scene.materials.len() as u32));
    scene.materials.push(material);
}

/// Hangs `count` lamps into the box of a scene, and returns their corners. Many of them are hidden from any one point, as the scene's walls stand between.
pub fn hang(scene: &mut Scene, count: u32) -> Result<Vec<[Vec3; 3]>> {
    let bounds =
        scene.bounds().context("--lamps: the scene has no surface between which lamps could hang")?;
    let size = bounds.size();
    let side = SIDE_SHARE * size.length();
    let within = Bounds { min: bounds.min + 0.05 * size, max: bounds.max - 0.05 * size };
    let box_area = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
    let area = 0.5 * side * side * count as f32;
    let lamp = Material::lamp("lamp", Vec3::splat(FLUX * box_area / area));
    let lamps = triangles(count, within, side);
    place(scene, "lamps", &lamps, lamp);
    scene.name = format!("{} with {count} lamps", scene.name);
    Ok(lamps)
}

#[cfg(test)]
mod tests {
    use super::*;
    use pt_light_sampling::LightLists;

    #[test]
    fn lamps_hang_inside_the_scene() {
        let mut scene = pt_scene::builtin("cornell").unwrap();
        let (before, bounds) = (LightLists::new(&scene).emissives.len(), scene.bounds().unwrap());
        hang(&mut scene, 40).unwrap();
        assert_eq!(LightLists::new(&scene).emissives.len(), before + 40);
        assert_eq!(scene.bounds().unwrap(), bounds);
        assert!(hang(&mut Scene::default(), 1).unwrap_err().to_string().contains("--lamps"));
    }
}
