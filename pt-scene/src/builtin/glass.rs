//! Nested dielectrics: a tumbler of tinted water with ice, built twice with the same visible surfaces.
//!
//! `glass` (Schmidt and Budge 2002): every solid is one closed mesh. The water reaches 1 mm into the wall of the glass, and
//! ice and water fill the same space; [`Material::priority`] says which solid is there: glass, then ice, then water.
//! `glass-gapless`: no two solids overlap. Where two of them meet there is one surface: the material's own `ior` and attenuation
//! hold behind it, those of [`Material::exterior`] in front. Behind is the glass at its wall, the ice at its faces.

use glam::{Affine3A, DVec2, EulerRot, Quat, Vec2, Vec3};

use super::noise::picture;
use super::shapes::Shape;
use super::solids::{box_faces, on_ring, split_at_level, triangulate};
use super::{add_material, place};
use crate::{Camera, CameraKey, CameraPath, Material, Scene, TextureRef};

const SEGMENTS: usize = 128;
/// Measures in metres: radii of the wall, height of the glass, of its inner bottom and of the water; how far the water reaches
/// into the glass.
const OUTER: f32 = 0.034;
const INNER: f32 = 0.031;
const HEIGHT: f32 = 0.100;
const BOTTOM: f32 = 0.010;
const LEVEL: f32 = 0.072;
const OVERLAP: f32 = 0.001;
/// Half the edge of the ice cubes, their centres and turns: two float, one is under water.
const ICE: f32 = 0.008;
const CUBES: [([f32; 3], [f32; 3]); 3] = [
    ([-0.0150, LEVEL - 0.0035, 0.0040], [0.5, 0.4, 0.3]),
    ([0.0145, LEVEL - 0.0030, -0.0040], [2.1, 0.3, -0.5]),
    ([0.0030, 0.0380, 0.0020], [1.1, -0.6, 0.4]),
];

pub(super) fn scene() -> Scene {
    let mut scene = surroundings();
    let [glass, ice, water] = solids().map(|m| add_material(&mut scene, m));

    let mut shape = Shape::default();
    shape.revolve(Vec3::ZERO, SEGMENTS, &tumbler(), |_| glass);
    place(&mut scene, "glass", shape);

    let (r, low) = (INNER + OVERLAP, BOTTOM - OVERLAP);
    let line = [Vec2::new(0.0, low), Vec2::new(r, low), Vec2::new(r, LEVEL), Vec2::new(0.0, LEVEL)];
    let mut shape = Shape::default();
    shape.revolve(Vec3::ZERO, SEGMENTS, &line, |_| water);
    place(&mut scene, "water", shape);

    let mut shape = Shape::default();
    cubes().iter().flatten().for_each(|face| shape.polygon(face, |_| Vec2::ZERO, ice));
    place(&mut scene, "ice", shape);
    scene
}

pub(super) fn gapless_scene() -> Scene {
    let mut scene = surroundings();
    let [glass, ice, water] = solids().map(|m| add_material(&mut scene, Material { priority: 0, ..m }));
    let mut under_water = |material: u32, name: &str| {
        let material = scene.materials[material as usize].clone();
        add_material(&mut scene, Material { name: name.into(), exterior: Some(water), ..material })
    };
    let (wet_glass, wet_ice) = (under_water(glass, "glass to water"), under_water(ice, "ice to water"));

    // As in `glass`, but the inner wall changes its front side at the water's level.
    let mut line = tumbler();
    line.insert(4, Vec2::new(INNER, LEVEL));
    let mut shape = Shape::default();
    shape.revolve(Vec3::ZERO, SEGMENTS, &line, |piece| if piece < 4 { glass } else { wet_glass });

    let mut holes = Vec::new();
    for cube in cubes() {
        let mut cuts = Vec::new();
        for face in cube {
            let [above, below] = split_at_level(&face, LEVEL);
            // The edge along the level, if the face crosses it: two cuts in a row.
            let n = above.len();
            let edge = (0..n).find(|&i| above[i].y == LEVEL && above[(i + 1) % n].y == LEVEL);
            cuts.extend(edge.filter(|_| n > 2).map(|i| (above[i], above[(i + 1) % n])));
            for (part, material) in [(above, ice), (below, wet_ice)] {
                if part.len() > 2 {
                    shape.polygon(&part, |_| Vec2::ZERO, material);
                }
            }
        }
        if let Some(hole) = chain(cuts) {
            holes.push(hole);
        }
    }
    let ring = (0..SEGMENTS).map(|k| on_ring(Vec3::ZERO, Vec2::new(INNER, LEVEL), k, SEGMENTS)).collect();
    surface_with_holes(&mut shape, ring, &holes, water);
    place(&mut scene, "interfaces", shape);
    scene
}

/// Half the outline of the glass, from the middle of the foot over the rim to the middle of the inner bottom.
fn tumbler() -> Vec<Vec2> {
    [(0.0, 0.0), (OUTER, 0.0), (OUTER, HEIGHT), (INNER, HEIGHT), (INNER, BOTTOM), (0.0, BOTTOM)]
        .map(Vec2::from)
        .into()
}

fn cubes() -> [[[Vec3; 4]; 6]; 3] {
    CUBES.map(|(center, [y, x, z])| {
        let turn = Quat::from_euler(EulerRot::YXZ, y, x, z);
        box_faces(Vec3::splat(ICE), Affine3A::from_rotation_translation(turn, center.into()))
    })
}

/// Edges that make up one closed line, in the order in which they are gone through.
fn chain(mut edges: Vec<(Vec3, Vec3)>) -> Option<Vec<Vec3>> {
    let (first, mut end) = edges.pop()?;
    let mut points = vec![first];
    while end != first {
        points.push(end);
        let next = edges.iter().position(|&(start, _)| start == end)?;
        end = edges.swap_remove(next).1;
    }
    Some(points)
}

/// The level surface inside `ring` and outside of the holes, seen from above; holes in either direction.
fn surface_with_holes(shape: &mut Shape, ring: Vec<Vec3>, holes: &[Vec<Vec3>], material: u32) {
    // From above, +X to the right and -Z up.
    let flat = |p: &Vec3| DVec2::new(f64::from(p.x), -f64::from(p.z));
    let mut points = ring;
    let outer: Vec<DVec2> = points.iter().map(flat).collect();
    let mut inner = Vec::new();
    for hole in holes {
        let mut hole = hole.clone();
        let turn: f64 =
            (0..hole.len()).map(|i| flat(&hole[i]).perp_dot(flat(&hole[(i + 1) % hole.len()]))).sum();
        if turn > 0.0 {
            hole.reverse();
        }
        inner.push(hole.iter().map(flat).collect());
        points.extend(hole);
    }
    let vertices: Vec<u32> = points.iter().map(|&p| shape.vertex(p, Vec3::Y, Vec2::ZERO)).collect();
    for triangle in triangulate(&outer, &inner) {
        shape.triangle(triangle.map(|i| vertices[i]), material);
    }
}

/// Glass, ice and water by rank.
fn solids() -> [Material; 3] {
    [
        Material { priority: 30, ..Material::solid("glass", 1.5) },
        Material { priority: 20, ..Material::solid("ice", 1.31) },
        Material {
            priority: 10,
            attenuation_color: Vec3::new(0.95, 0.55, 0.18),
            attenuation_distance: 0.04,
            ..Material::solid("water", 1.333)
        },
    ]
}

/// A table, a lamp, a sky and the camera.
fn surroundings() -> Scene {
    let mut scene =
        Scene { environment: crate::sky::sky(Vec3::new(0.6, 0.7, 0.4).normalize(), 0.5), ..Scene::default() };
    scene.textures.push(picture("table", 256, |uv| {
        let cell = (uv * 8.0).floor();
        let light = (cell.x + cell.y) as i32 % 2 == 0;
        (if light { Vec3::new(0.62, 0.60, 0.55) } else { Vec3::new(0.16, 0.22, 0.30) }, 1.0)
    }));
    let top =
        Material { base_color_texture: Some(TextureRef::new(0)), ..Material::lambertian("table", Vec3::ONE) };
    let top = add_material(&mut scene, top);
    let lamp = add_material(&mut scene, Material::lamp("lamp", Vec3::new(16.0, 15.0, 13.0)));
    // 0.2 mm under the glass: air, and no two surfaces in one plane.
    let mut shape = Shape::default();
    shape.cuboid(Vec3::new(-0.4, -0.03, -0.4), Vec3::new(0.4, -2e-4, 0.4), 4.0, top);
    shape.quad(Vec3::new(-0.35, 0.38, -0.18), Vec3::X * 0.2, Vec3::new(0.0, 0.14, 0.2), Vec2::ONE, lamp);
    place(&mut scene, "table", shape);
    scene.cameras.push(Camera::look_at(
        "table",
        Vec3::new(0.09, 0.175, 0.25),
        Vec3::new(0.0, 0.05, 0.0),
        0.46,
    ));
    // A quarter of the way round the glasses in four seconds.
    let keys = (0..=4).map(|i| {
        let (sin, cos) = (0.35 + 0.4 * i as f32).sin_cos();
        let position = Vec3::new(0.27 * sin, 0.175, 0.27 * cos);
        CameraKey { time: f64::from(i), position, target: Vec3::new(0.0, 0.05, 0.0) }
    });
    if let Some(path) = CameraPath::new(keys.collect()) {
        scene.cameras.push(Camera::on_path("tour", path, 0.46));
    }
    scene
}
