//! A G-buffer without a camera: what the stage's program and benchmark light.

use glam::Vec3;
use pt_core::pack::pack_unit_vector;
use pt_core::rng::random4;
use pt_core::{ChannelImages, Result};
use pt_light_sampling::AliasTable;
use pt_scene::{Clusters, Scene};
use pt_shaders::channels::{
    BASE_COLOR, CLUSTER, ChannelId, METALLIC_ROUGHNESS, NORMAL, RNG_SEED, SHADING_POSITION, VERTEX_NORMAL,
    VIEW_DIRECTION,
};

/// Fills the channels that direct lighting reads, but for [`RNG_SEED`], with points spread over the scene's triangles,
/// uniform in area, on front faces, seen along their normals; white and Lambertian. A scene without area gives no surface.
pub fn fill_surfaces(images: &ChannelImages, scene: &Scene, clusters: &Clusters) -> Result<()> {
    let mut triangles = Vec::new();
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh as usize];
        let side = instance.world_from_object.matrix3.determinant().signum();
        triangles.extend((0..mesh.triangle_count()).map(|t| {
            let [a, b, c] = mesh.triangle(t).map(|p| instance.world_from_object.transform_point3(p));
            let area = side * (b - a).cross(c - a);
            ([a, b - a, c - a], area.normalize_or_zero(), f64::from(area.length()))
        }));
    }
    let areas: Vec<f64> = triangles.iter().map(|(.., area)| *area).collect();
    let table = AliasTable::new(&areas);
    let [width, height] = images.current(SHADING_POSITION).extent();
    let points: Vec<(Vec3, Vec3)> = (0..width * height)
        .map(|i| {
            let Some(table) = &table else { return Default::default() };
            let xi = random4([i % width, i / width], 0, 0, 0);
            let other = random4([i % width, i / width], 0, 1, 0);
            let ([a, e1, e2], normal, _) = triangles[table.pick((xi[0] * 4_294_967_296.0) as u32, xi[1])];
            let root = other[0].sqrt();
            (a + root * (1.0 - other[1]) * e1 + root * other[1] * e2, normal)
        })
        .collect();
    let material = u32::from(table.is_some());
    let write = |id: ChannelId, words: Vec<u32>| images.current(id).write(bytemuck::cast_slice(&words));
    write(
        SHADING_POSITION,
        points.iter().flat_map(|(p, _)| [p.x.to_bits(), p.y.to_bits(), p.z.to_bits(), material]).collect(),
    )?;
    let cluster = points.iter().map(|(p, _)| clusters.find(*p) as u16).collect::<Vec<_>>();
    images.current(CLUSTER).write(bytemuck::cast_slice(&cluster))?;
    let pack = |n: Vec3| if n == Vec3::ZERO { 0 } else { pack_unit_vector(n) };
    for id in [NORMAL, VERTEX_NORMAL] {
        write(id, points.iter().map(|(_, n)| pack(*n)).collect())?;
    }
    write(VIEW_DIRECTION, points.iter().flat_map(|(_, n)| [pack(-*n), 1]).collect())?;
    // 16-bit unorm: white without a specular lobe; roughness 1, not metallic.
    write(BASE_COLOR, points.iter().flat_map(|_| [0xffff_ffff, 0x0000_ffff]).collect())?;
    write(METALLIC_ROUGHNESS, vec![0xffff_0000; points.len()])
}

/// Sets the arguments of the random numbers: a pixel's index and the frame.
pub fn fill_seeds(images: &ChannelImages, frame: u32) -> Result<()> {
    let [width, height] = images.current(RNG_SEED).extent();
    let words: Vec<u32> = (0..width * height).flat_map(|i| [i, frame]).collect();
    images.current(RNG_SEED).write(bytemuck::cast_slice(&words))
}
