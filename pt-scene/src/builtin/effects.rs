//! Effects: a scene of all kinds, and one of many sprites that overlap.

use glam::{Vec2, Vec3};

use super::noise::{fbm, picture};
use super::shapes::Shape;
use super::{add_material, place};
use crate::hash::hash;
use crate::{Beam, Camera, Drift, Effects, FogVolume, Light, Look, Material, Particle, Scene, Sprite};

const PUFFS: i32 = 120;
const SPARKS: i32 = 300;
const SPRITES: i32 = 1000;

/// On a floor: smoke and sparks of a fire, fog that is denser near the floor, two beams, and a picture in the air; behind them a mirror, beside
/// them a ball of glass.
pub(super) fn scene() -> Scene {
    let sky = crate::sky::sky(Vec3::new(0.4, 0.5, 0.7).normalize(), 0.35);
    let mut scene = Scene { environment: sky, ..Scene::default() };
    let floor = add_material(&mut scene, Material::lambertian("floor", Vec3::new(0.35, 0.32, 0.3)));
    let brick = add_material(&mut scene, Material::lambertian("brick", Vec3::new(0.5, 0.22, 0.14)));
    let mirror = add_material(&mut scene, Material::metal("mirror", Vec3::splat(0.95), 0.0));
    let glass = add_material(&mut scene, Material::solid("glass", 1.5));
    let mut shape = Shape::default();
    shape.quad(Vec3::new(-20.0, 0.0, 10.0), Vec3::X * 40.0, Vec3::Z * -30.0, Vec2::ONE, floor);
    shape.cuboid(Vec3::new(-0.35, 0.0, -0.35), Vec3::new(0.35, 0.3, 0.35), 1.0, brick);
    shape.cuboid(Vec3::new(-3.0, 0.0, -1.0), Vec3::new(-2.6, 1.6, -0.6), 1.0, brick);
    shape.quad(Vec3::new(-2.4, 0.0, -2.2), Vec3::X * 4.8, Vec3::Y * 2.4, Vec2::ONE, mirror);
    place(&mut scene, "hall", shape);
    let mut ball = Shape::default();
    ball.icosphere(Vec3::new(1.5, 0.45, 0.6), 0.45, 4, true, glass);
    place(&mut scene, "ball", ball);
    scene.lights.push(Light::directional("sun", Vec3::new(-0.4, -0.7, -0.6), Vec3::new(1.4, 1.3, 1.1)));
    scene.textures.push(picture("emblem", 128, |uv| {
        let p = 2.0 * uv - 1.0;
        let ring = (p.length() - 0.7).abs() < 0.18 || p.abs().max_element() < 0.3;
        let cloud = fbm(uv, 4, 3, 7);
        (Vec3::new(0.3 + 0.6 * cloud, 0.8, 1.0), f32::from(u8::from(ring)))
    }));

    let random = |i: i32, k: i32| hash(i, k, 19);
    let fire = Vec3::new(0.0, 0.35, 0.0);
    let puffs = (0..PUFFS).map(|i| {
        let shade = 0.03 + 0.05 * random(i, 0);
        Particle {
            position: fire + 0.25 * Vec3::new(random(i, 1) - 0.5, 0.0, random(i, 2) - 0.5),
            radius: 0.12 + 0.2 * random(i, 3),
            look: Look { radiance: Vec3::splat(shade), opacity: 0.35 },
            drift: Drift {
                velocity: Vec3::new(
                    0.25 * (random(i, 4) - 0.3),
                    0.7 + 0.3 * random(i, 5),
                    0.2 * (random(i, 6) - 0.5),
                ),
                period: 2.5,
                phase: 2.5 * f64::from(random(i, 7)),
            },
        }
    });
    let sparks = (0..SPARKS).map(|i| Particle {
        position: fire,
        radius: 0.012 + 0.012 * random(i, 10),
        look: Look { radiance: (4.0 + 16.0 * random(i, 11)) * Vec3::new(1.0, 0.45, 0.12), opacity: 0.0 },
        drift: Drift {
            velocity: Vec3::new(
                1.6 * (random(i, 12) - 0.5),
                0.8 + 1.2 * random(i, 13),
                1.6 * (random(i, 14) - 0.5),
            ),
            period: 1.0 + f64::from(random(i, 15)),
            phase: 2.0 * f64::from(random(i, 16)),
        },
    });
    let beam = |ends: [Vec3; 2], radius: f32, radiance: Vec3, velocity: Vec3| Beam {
        ends,
        radius,
        look: Look { radiance, opacity: 0.6 },
        drift: Drift { velocity, period: 4.0, phase: 0.0 },
    };
    scene.effects = Effects {
        particles: puffs.chain(sparks).collect(),
        beams: vec![
            beam(
                [Vec3::new(-2.6, 1.3, -0.8), Vec3::new(1.9, 0.5, 1.2)],
                0.035,
                Vec3::new(6.0, 0.4, 0.3),
                Vec3::ZERO,
            ),
            beam(
                [Vec3::new(-1.6, 0.2, 0.8), Vec3::new(-1.6, 1.1, 0.8)],
                0.06,
                Vec3::new(0.3, 1.2, 5.0),
                0.3 * Vec3::X,
            ),
        ],
        sprites: vec![Sprite {
            position: Vec3::new(-0.9, 1.5, 0.3),
            half_sides: [Vec3::new(0.35, 0.0, 0.1), Vec3::new(0.0, 0.35, 0.0)],
            texture: Some(0),
            look: Look { radiance: Vec3::splat(0.8), opacity: 0.9 },
            drift: Drift::default(),
        }],
        fog: vec![FogVolume {
            corners: [Vec3::new(-6.0, 0.0, -2.1), Vec3::new(6.0, 0.8, 2.0)],
            density: 0.4,
            gradient: Vec3::new(0.0, -0.5, 0.0),
            radiance: Vec3::new(0.35, 0.4, 0.48),
            drift: Drift::default(),
        }],
        ..Effects::default()
    };
    let (eye, target) = (Vec3::new(1.2, 1.5, 4.6), Vec3::new(-0.1, 0.95, 0.0));
    scene.cameras.push(Camera::look_at("front", eye, target, 0.72));
    scene
}

/// 1,000 discs with soft rims, of all colours and turned in all directions, in a box of 2 m before a grey wall.
pub(super) fn sprites() -> Scene {
    let mut scene = Scene { environment: crate::sky::sky(Vec3::Y, 0.5), ..Scene::default() };
    let wall = add_material(&mut scene, Material::lambertian("wall", Vec3::splat(0.5)));
    let mut shape = Shape::default();
    shape.quad(Vec3::new(-4.0, -4.0, -1.5), Vec3::X * 8.0, Vec3::Y * 8.0, Vec2::ONE, wall);
    place(&mut scene, "wall", shape);
    scene.textures.push(picture("disc", 64, |uv| {
        let d = (2.0 * uv - 1.0).length_squared().min(1.0);
        (Vec3::ONE, (1.0 - d) * (1.0 - d))
    }));
    let random = |i: i32, k: i32| hash(i, k, 23);
    let direction = |i: i32, k: i32| {
        let z = 2.0 * random(i, k) - 1.0;
        let (sin, cos) = (std::f32::consts::TAU * random(i, k + 1)).sin_cos();
        Vec3::new((1.0 - z * z).max(0.0).sqrt() * cos, (1.0 - z * z).max(0.0).sqrt() * sin, z)
    };
    let sprites = (0..SPRITES).map(|i| {
        let (u, v) = direction(i, 0).any_orthonormal_pair();
        let size = 0.15 + 0.25 * random(i, 2);
        let color = Vec3::new(random(i, 3), random(i, 4), random(i, 5));
        let opacity = 0.2 + 0.6 * random(i, 6);
        Sprite {
            position: 2.0 * Vec3::new(random(i, 7), random(i, 8), random(i, 9)) - 1.0,
            half_sides: [size * u, size * v],
            texture: Some(0),
            look: Look { radiance: opacity * color, opacity },
            drift: Drift::default(),
        }
    });
    scene.effects = Effects { sprites: sprites.collect(), ..Effects::default() };
    scene.cameras.push(Camera::look_at("front", Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, 0.6));
    scene
}
