//! The list of emissive triangles and the weight by which each is picked.

use crate::luminance;
use crate::texture_mean::TextureMeans;
use glam::{Vec2, Vec3};
use pt_scene::{Instance, Material, Mesh, Scene, TextureRef};
use std::collections::{BTreeMap, HashMap};

/// Sides of the grid of small triangles over which an emissive texture is averaged: 16 of them.
const SUBDIVISIONS: i32 = 4;

/// A triangle that emits, placed in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmissiveTriangle {
    /// Instance index.
    pub instance: u32,
    /// Triangle of the instance's mesh.
    pub triangle: u32,
    /// Area (m^2) x mean luminance of the radiance: its luminous power but for a factor pi.
    pub weight: f64,
    /// Mean luminance of its radiance, with its texture.
    pub luminance: f32,
}

/// An emissive triangle that lies in the same place as one of the list and shines as it does: a ray that meets both meets one light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Twin {
    /// Instance index.
    pub instance: u32,
    /// Triangle of the instance's mesh.
    pub triangle: u32,
    /// Its like in the list.
    pub index: u32,
}

/// Least share of its mesh's mean area that a triangle of a mesh that deforms counts with.
const LEAST_SHARE: f64 = 0.01;

/// All triangles that can emit, by instance and triangle. Left out are materials with KHR_materials_unlit, which emit
/// nothing, triangles without area unless they may gain some because their mesh deforms, and triangles of which the
/// emissive texture shows black parts only. Of triangles in the same place the list has the first; the others are its twins.
pub(crate) fn triangles(scene: &Scene) -> (Vec<EmissiveTriangle>, Vec<Twin>) {
    let mut means: BTreeMap<u32, TextureMeans> = BTreeMap::new();
    for material in scene.materials.iter().filter(|m| emits(m)) {
        if let Some(slot) = material.emissive_texture {
            let texture = &scene.textures[slot.texture as usize];
            means.entry(slot.texture).or_insert_with(|| TextureMeans::new(texture));
        }
    }
    let (mut list, mut twins) = (Vec::new(), Vec::new());
    let mut places = HashMap::new();
    // Of a mesh that many instances share the triangles are gone through once, unless it shines.
    let emits_at = |material: u32| emits(&scene.materials[material as usize]);
    let shines = |mesh: &Mesh| mesh.triangle_materials.iter().any(|&material| emits_at(material));
    let shining: Vec<_> = scene.meshes.iter().map(shines).collect();
    for (i, instance) in scene.instances.iter().enumerate() {
        let mesh = &scene.meshes[instance.mesh as usize];
        if !instance.material.map_or(shining[instance.mesh as usize], emits_at) {
            continue;
        }
        let least = match mesh.deformation {
            Some(_) => {
                let sum: f64 = (0..mesh.triangle_count()).map(|t| area(instance, mesh, t)).sum();
                (LEAST_SHARE * sum / mesh.triangle_count().max(1) as f64).max(f64::MIN_POSITIVE)
            }
            None => 0.0,
        };
        for t in 0..mesh.triangle_count() {
            let material = &scene.materials[instance.material_at(mesh, t) as usize];
            if !emits(material) {
                continue;
            }
            let radiance = match &material.emissive_texture {
                Some(slot) => material.emissive * texture_mean(mesh, t, slot, &means[&slot.texture]),
                None => material.emissive,
            };
            let weight = area(instance, mesh, t).max(least) * luminance(radiance);
            if weight <= 0.0 {
                continue;
            }
            let (instance_index, triangle) = (i as u32, t as u32);
            let index = list.len() as u32;
            // What moves can part from its like.
            let moves = !instance.is_static(mesh);
            let place = (
                moves.then_some(instance_index),
                instance.material_at(mesh, t),
                corners(instance, mesh, t, material),
            );
            match mesh.deformation.is_none().then(|| *places.entry(place).or_insert(index)) {
                Some(index) if (index as usize) < list.len() => {
                    twins.push(Twin { instance: instance_index, triangle, index });
                }
                _ => {
                    let luminance = luminance(radiance) as f32;
                    list.push(EmissiveTriangle { instance: instance_index, triangle, weight, luminance });
                }
            }
        }
    }
    (list, twins)
}

/// Bits of the corners in world space, the same for all triangles that emit from the same place to the same side.
fn corners(instance: &Instance, mesh: &Mesh, triangle: usize, material: &Material) -> [[u32; 3]; 3] {
    let mut corners = mesh
        .triangle(triangle)
        .map(|p| (instance.world_from_object.transform_point3(p) + 0.0).to_array().map(f32::to_bits));
    if instance.world_from_object.matrix3.determinant() < 0.0 {
        corners.swap(1, 2);
    }
    if material.double_sided {
        corners.sort_unstable();
    } else {
        // From the least on, in the order of the winding.
        let least = (0..3).min_by_key(|&i| corners[i]).unwrap_or(0);
        corners.rotate_left(least);
    }
    corners
}

fn emits(material: &Material) -> bool {
    material.is_emissive() && !material.unlit
}

fn area(instance: &Instance, mesh: &Mesh, triangle: usize) -> f64 {
    let [a, b, c] =
        mesh.triangle(triangle).map(|p| instance.world_from_object.transform_point3(p).as_dvec3());
    0.5 * (b - a).cross(c - a).length()
}

/// Mean of the texture over the triangle: over the bounding rectangles of 16 equal parts of it, so that nothing that the
/// triangle shows is missed and little else counts.
fn texture_mean(mesh: &Mesh, triangle: usize, slot: &TextureRef, means: &TextureMeans) -> Vec3 {
    let uv = if slot.uv_set == 0 { &mesh.uv0 } else { &mesh.uv1 };
    let corners = mesh.indices[triangle].map(|v| slot.transform.transform_point2(uv[v as usize]));
    let n = SUBDIVISIONS;
    let at = |i: i32, j: i32| {
        let (x, y) = (i as f32 / n as f32, j as f32 / n as f32);
        corners[0] * (1.0 - x - y) + corners[1] * x + corners[2] * y
    };
    let mut sum = [0.0; 3];
    let mut add = |part: [Vec2; 3]| {
        let (min, max) = (part[0].min(part[1]).min(part[2]), part[0].max(part[1]).max(part[2]));
        for (sum, mean) in sum.iter_mut().zip(means.mean(min.into(), max.into())) {
            *sum += mean;
        }
    };
    for i in 0..n {
        for j in 0..n - i {
            add([at(i, j), at(i + 1, j), at(i, j + 1)]);
            if i + j < n - 1 {
                add([at(i + 1, j + 1), at(i, j + 1), at(i + 1, j)]);
            }
        }
    }
    Vec3::from_array(sum.map(|s| (s / f64::from(n * n)) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Affine2, Affine3A, Vec4};
    use pt_scene::{Texels, Texture, TextureUsage};

    /// Two triangles of a unit square, textured white in the upper left half only, and their instance twice as large.
    fn scene(transform: Affine2) -> Scene {
        let corner = [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE];
        let texels =
            (0..64).flat_map(|y| (0..64).map(move |x| x + y < 60)).flat_map(|on| [255 * u8::from(on); 4]);
        let texture = Texture::rgba8("half", [64, 64], TextureUsage::Data, texels.collect());
        let slot = TextureRef { transform, ..TextureRef::new(0) };
        let lamp = Material { emissive_texture: Some(slot), ..Material::lamp("lamp", Vec3::splat(2.0)) };
        let mesh = Mesh {
            positions: corner.map(|c| c.extend(0.0)).into(),
            normals: vec![Vec3::Z; 4],
            tangents: vec![Vec4::X; 4],
            uv0: corner.into(),
            uv1: corner.into(),
            colors: vec![Vec4::ONE; 4],
            indices: vec![[0, 1, 2], [1, 3, 2]],
            triangle_materials: vec![0, 0],
            first_masked: 2,
            name: "square".into(),
            ..Mesh::default()
        };
        let place = |scale| Instance::new("square", 0, Affine3A::from_scale(Vec3::splat(scale)));
        Scene {
            meshes: vec![mesh],
            instances: vec![place(1.0), place(2.0)],
            materials: vec![lamp],
            textures: vec![texture],
            ..Scene::default()
        }
    }

    #[test]
    fn weight_is_area_times_mean_luminance() {
        let inside = Affine2::from_scale_angle_translation(Vec2::splat(0.3), 0.0, Vec2::splat(0.1));
        let white = triangles(&scene(inside)).0;
        let weights: Vec<f64> = white.iter().map(|t| t.weight).collect();
        for (weight, expected) in weights.iter().zip([1.0, 1.0, 4.0, 4.0]) {
            assert!((weight - expected).abs() < 1e-5, "{weights:?}");
        }
        // The first triangle shows 60 x 61 / 2 white ones of 64 x 64 / 2 texels; the parts' rectangles reach a little too far.
        let half = triangles(&scene(Affine2::IDENTITY)).0;
        assert!((half[0].weight - 60.0 * 61.0 / 4096.0).abs() < 0.15, "{half:?}");
    }

    #[test]
    fn triangles_that_show_a_little_light_stay() {
        // The second triangle covers the black half but touches the white one at its long edge.
        let mut scene = scene(Affine2::IDENTITY);
        let list = triangles(&scene).0;
        assert_eq!(list.iter().filter(|t| t.triangle == 1).count(), 2);
        scene.materials[0].unlit = true;
        assert_eq!(triangles(&scene).0, []);
        scene.materials[0].unlit = false;
        scene.textures[0].texels = Texels::Rgba8(vec![0; 64 * 64 * 4]);
        assert_eq!(triangles(&scene).0, []);
    }

    /// Copies of a triangle are its twins: with its vertices in another order, at another instance, mirrored and turned round; not those that
    /// emit to the other side, from another material or from elsewhere, nor those that may move.
    #[test]
    fn triangles_in_the_same_place_are_twins() {
        let inside = Affine2::from_scale_angle_translation(Vec2::splat(0.3), 0.0, Vec2::splat(0.1));
        let mut scene = scene(inside);
        scene.instances.truncate(1);
        let count = |scene: &Scene| {
            let (list, twins) = triangles(scene);
            (list.len(), twins.len())
        };
        assert_eq!(count(&scene), (2, 0));
        scene.meshes[0].indices.push([1, 2, 0]);
        scene.meshes[0].triangle_materials.push(0);
        assert_eq!(count(&scene), (2, 1), "another order");
        scene.meshes[0].indices.push([1, 0, 2]);
        scene.meshes[0].triangle_materials.push(0);
        assert_eq!(count(&scene), (3, 1), "the other side");
        scene.materials[0].double_sided = true;
        assert_eq!(count(&scene), (2, 2), "both sides");
        scene.instances.push(scene.instances[0].clone());
        assert_eq!(count(&scene), (2, 6), "another instance");
        scene.materials.push(scene.materials[0].clone());
        scene.instances[1].material = Some(1);
        assert_eq!(count(&scene), (4, 4), "another material");
        scene.instances[1].material = None;
        let rest = Affine3A::IDENTITY;
        scene.instances[1].motion = Some(pt_scene::Motion::Slide { rest, reach: Vec3::X, period_s: 1.0 });
        assert_eq!(count(&scene), (4, 4), "what moves");
        let lists = crate::LightLists::new(&scene);
        let lookup = lists.emissive_lookup(&scene);
        assert_eq!(lookup[lookup[0] as usize..][..4], [0, 1, 0, 0]);
    }
}
