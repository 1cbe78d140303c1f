//! A field to measure how times grow: as many triangles, lamps and instances as its name asks for, all in view.

use super::shapes::Shape;
use super::{add_material, add_mesh, place};
use crate::hash::hash;
use crate::{Camera, Instance, Material, Motion, Scene};
use glam::{Affine3A, Quat, Vec2, Vec3};

/// Side of the ground, metres.
const SIDE: f32 = 64.0;
/// Radiant flux of all lamps together, W, however many there are.
const FLUX: f32 = 4000.0;
/// Side of a lamp, metres.
const LAMP: f32 = 0.1;

/// How much of each there is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Counts {
    /// Triangles of the ground; the next larger 2 n^2.
    triangles: u32,
    /// Emissive triangles.
    lights: u32,
    /// Instances of a stone of 20 triangles.
    instances: u32,
    /// How many of them turn.
    moving: u32,
}

/// More than any device holds.
const MOST: u32 = 100_000_000;

impl Counts {
    /// Of a name as `triangles=1000,lights=64,instances=10,moving=10`, in which parts may be missing.
    fn parse(text: &str) -> Option<Self> {
        let mut counts = Self { triangles: 10_000, lights: 64, instances: 1, moving: 0 };
        for part in text.split(',').filter(|part| !part.is_empty()) {
            let (name, value) = part.split_once('=')?;
            let count = match name {
                "triangles" => &mut counts.triangles,
                "lights" => &mut counts.lights,
                "instances" => &mut counts.instances,
                "moving" => &mut counts.moving,
                _ => return None,
            };
            *count = value.parse().ok().filter(|count| *count <= MOST)?;
        }
        let Self { triangles, lights, instances, .. } = counts;
        [triangles, lights, instances].iter().all(|&count| count > 0).then_some(counts)
    }
}

/// The scene of a name as `field:triangles=1000000,lights=64,instances=10,moving=10`, without `field:`.
pub(super) fn scene(counts: &str) -> Option<Scene> {
    let Counts { triangles, lights, instances, moving } = Counts::parse(counts)?;
    let mut scene = Scene::default();
    let earth = add_material(&mut scene, Material::diffuse("earth", Vec3::new(0.42, 0.36, 0.28)));
    let rock = Material { roughness: 0.5, ..Material::diffuse("rock", Vec3::new(0.5, 0.5, 0.52)) };
    let rock = add_material(&mut scene, rock);
    let area = 0.5 * LAMP * LAMP;
    let radiance = FLUX / (lights as f32 * area * std::f32::consts::PI);
    let lamp = add_material(&mut scene, Material::lamp("lamp", Vec3::splat(radiance)));

    let cells = (f64::from(triangles) / 2.0).sqrt().ceil() as usize;
    let mut ground = Shape::default();
    ground.surface(cells, cells, Vec2::ONE, earth, |u, v| {
        let (x, z) = (SIDE * (u - 0.5), SIDE * (0.5 - v));
        Vec3::new(x, height(x, z), z)
    });
    place(&mut scene, "ground", ground);

    let mut lamps = Shape::default();
    for i in 0..lights as i32 {
        let [x, z] = [1, 2].map(|seed| SIDE * (hash(i, 0, seed) - 0.5));
        let corner = Vec3::new(x, height(x, z) + 1.5 + 2.0 * hash(i, 0, 3), z);
        let corners = [corner, corner + LAMP * Vec3::X, corner + LAMP * Vec3::Z];
        let [a, b, c] = corners.map(|p| lamps.vertex(p, Vec3::NEG_Y, Vec2::ZERO));
        lamps.triangle([a, b, c], lamp);
    }
    place(&mut scene, "lamps", lamps);

    let stone = add_mesh(&mut scene, "stone", stone(rock));
    // All stones together cover the same part of the ground.
    let size = 0.3 * SIDE / (instances as f32).sqrt();
    scene.instances.extend((0..instances as i32).map(|i| {
        let [x, z] = [4, 5].map(|seed| SIDE * (hash(i, 0, seed) - 0.5));
        let turn = Quat::from_rotation_y(std::f32::consts::TAU * hash(i, 0, 6));
        let at = Vec3::new(x, height(x, z), z);
        let rest = Affine3A::from_scale_rotation_translation(Vec3::splat(0.5 * size), turn, at);
        if i as u32 >= moving {
            return Instance::new("stone", stone, rest);
        }
        let motion = Motion::Spin { rest, axis: Vec3::Y, center: at, deg_per_s: 90.0 };
        Instance::moving("stone", stone, motion)
    }));
    let eye = Vec3::new(0.0, 12.0, 0.55 * SIDE);
    scene.cameras.push(Camera::look_at("edge", eye, Vec3::new(0.0, 0.0, -0.1 * SIDE), 0.9));
    Some(scene)
}

/// Of the ground, metres.
fn height(x: f32, z: f32) -> f32 {
    0.9 * (0.35 * x).sin() * (0.27 * z).cos() + 0.15 * (1.9 * x + 0.8 * z).sin() * (2.3 * z - 0.4 * x).sin()
}

/// A flattened sphere of 20 triangles: an icosahedron, flat shaded.
fn stone(material: u32) -> Shape {
    let golden = 0.5 * (1.0 + 5.0_f32.sqrt());
    let corner = |i: usize| {
        let [a, b] = [if i & 1 == 0 { 1.0 } else { -1.0 }, if i & 2 == 0 { golden } else { -golden }];
        let p = match i / 4 {
            0 => Vec3::new(0.0, a, b),
            1 => Vec3::new(a, b, 0.0),
            _ => Vec3::new(b, 0.0, a),
        };
        p.normalize() * Vec3::new(1.0, 0.6, 1.0)
    };
    let mut shape = Shape::default();
    let edge = 1.2 / golden.hypot(1.0) * 2.0;
    let near = |a: usize, b: usize| {
        let unsquash = |i: usize| corner(i) / Vec3::new(1.0, 0.6, 1.0);
        unsquash(a).distance(unsquash(b)) < edge
    };
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(c, a) {
                    let [p, q, r] = [a, b, c].map(corner);
                    let outward = (q - p).cross(r - p).dot(p + q + r) > 0.0;
                    shape.polygon(&if outward { [p, q, r] } else { [p, r, q] }, |_| Vec2::ZERO, material);
                }
            }
        }
    }
    shape
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_as_much_as_the_name_says() {
        let counts = |text| Counts::parse(text).map(|c| (c.triangles, c.lights, c.instances, c.moving));
        assert_eq!(counts(""), Some((10_000, 64, 1, 0)));
        assert_eq!(counts("instances=7,triangles=50,moving=2"), Some((50, 64, 7, 2)));
        for wrong in ["lights", "lights=0", "lights=-1", "lamps=3", "lights=200000000"] {
            assert_eq!(counts(wrong), None, "{wrong}");
        }
        let mut scene = scene("triangles=200,lights=30,instances=9,moving=4").unwrap();
        let rest: Vec<_> = scene.instances.iter().map(|instance| instance.world_from_object).collect();
        scene.set_time(0.5, 0.0);
        let moved = scene.instances.iter().zip(rest).filter(|(now, rest)| now.world_from_object != *rest);
        assert_eq!(moved.count(), 4);
        let found = scene.statistics();
        assert_eq!(scene.meshes[0].triangle_count(), 200);
        assert_eq!((found.emissive_triangles, scene.instances.len()), (30, 2 + 9));
        assert_eq!(scene.meshes[2].triangle_count(), 20);
        let up = |mesh: usize| scene.meshes[mesh].normals.iter().map(|n| n.y.signum()).sum::<f32>();
        assert!(up(0) > 0.0 && up(1) < 0.0, "the ground is seen from above, lamps shine down");
    }

    #[test]
    fn the_lamps_give_the_same_light_however_many_they_are() {
        let flux = |lights: u32| {
            let scene = scene(&format!("triangles=2,lights={lights}")).unwrap();
            let radiance = scene.materials[2].emissive.x;
            let area: f32 = (0..lights as usize)
                .map(|t| {
                    let [a, b, c] = scene.meshes[1].triangle(t);
                    let normal = 0.5 * (b - a).cross(c - a);
                    assert!(normal.y < 0.0, "the front is below");
                    normal.length()
                })
                .sum();
            std::f32::consts::PI * area * radiance
        };
        for lights in [1, 64, 4096] {
            assert!((flux(lights) / FLUX - 1.0).abs() < 1e-2, "{}", flux(lights));
        }
    }
}
