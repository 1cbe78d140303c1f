//! A transparent background: alpha is the coverage, and the picture over the sky is the opaque one.

use crate::common::renders::{Stage, add_mesh};
use glam::{DVec2, Vec2, Vec3};
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_reference::{Background, ReferenceParams};
use pt_scene::{AlphaMode, Camera, Environment, Material, Projection, Scene};

const SIZE: u32 = 16;
const SPP: u32 = 256;
/// Radiance of the sky.
const SKY: Vec3 = Vec3::new(3.0, 2.0, 1.0);

/// A square in the plane z = 0 that faces +Z; its alpha.
struct Square {
    center: Vec2,
    half: f32,
    angle: f32,
    alpha: f32,
    material: Material,
}

impl Square {
    fn corners(&self) -> [Vec2; 4] {
        let axis = Vec2::from_angle(self.angle) * self.half;
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| self.center + x * axis + y * axis.perp())
    }
}

/// What a camera ray can see first: a wall, a mirror, a surface that is there for a quarter of the rays, a pane of glass.
fn squares() -> [Square; 4] {
    let square =
        |x, y, angle, material| Square { center: Vec2::new(x, y), half: 0.33, angle, alpha: 1.0, material };
    let veil = Material {
        base_color: Vec3::splat(0.5).extend(0.25),
        alpha_mode: AlphaMode::Blend,
        ..Material::lambertian("veil", Vec3::ONE)
    };
    let pane = Material { thickness: 0.0, ..Material::solid("pane", 1.5) };
    [
        square(-0.45, 0.45, 0.3, Material::lambertian("wall", Vec3::splat(0.5))),
        square(0.45, 0.45, 0.1, Material::metal("mirror", Vec3::splat(0.9), 0.0)),
        Square { alpha: 0.25, ..square(-0.45, -0.45, 0.2, veil) },
        square(0.45, -0.45, -0.25, pane),
    ]
}

fn scene() -> Scene {
    let mut scene = Scene { environment: Environment::constant(SKY), ..Scene::default() };
    for square in squares() {
        let positions = square.corners().map(|corner| corner.extend(0.0)).to_vec();
        let masked = square.material.is_masked();
        add_mesh(&mut scene, positions, vec![Vec3::Z; 4], vec![[0, 1, 2], [0, 2, 3]], square.material);
        if masked {
            scene.meshes.last_mut().unwrap().first_masked = 0;
        }
    }
    scene
}

/// Sees -1 to 1 in x and y.
fn camera() -> Camera {
    let along_z = Camera::look_at("front", 5.0 * Vec3::Z, Vec3::ZERO, 1.0);
    Camera { projection: Projection::Orthographic { ymag: 1.0 }, ..along_z }
}

/// Area of the part of a convex polygon, counter-clockwise, in the axis-aligned square of the side `side` (Sutherland and Hodgman 1974).
fn area_within(polygon: &[DVec2], corner: DVec2, side: f64) -> f64 {
    let mut polygon = polygon.to_vec();
    for (axis, limit) in [
        (DVec2::X, corner.x),
        (DVec2::Y, corner.y),
        (DVec2::NEG_X, -corner.x - side),
        (DVec2::NEG_Y, -corner.y - side),
    ] {
        let height = |p: DVec2| p.dot(axis) - limit;
        let mut cut = Vec::new();
        for (i, &a) in polygon.iter().enumerate() {
            let b = polygon[(i + 1) % polygon.len()];
            if height(a) >= 0.0 {
                cut.push(a);
            }
            if (height(a) >= 0.0) != (height(b) >= 0.0) {
                cut.push(a.lerp(b, height(a) / (height(a) - height(b))));
            }
        }
        polygon = cut;
    }
    (0..polygon.len()).map(|i| polygon[i].perp_dot(polygon[(i + 1) % polygon.len()])).sum::<f64>() / 2.0
}

/// Share of the rays of a pixel that see a surface.
fn expected_coverage(x: u32, y: u32) -> f64 {
    let side = 2.0 / f64::from(SIZE);
    let corner = DVec2::new(f64::from(x), f64::from(SIZE - 1 - y)) * side - 1.0;
    let share = |square: Square| {
        let polygon = square.corners().map(Vec2::as_dvec2);
        f64::from(square.alpha) * area_within(&polygon, corner, side) / (side * side)
    };
    squares().map(share).iter().sum()
}

#[test]
fn alpha_is_the_coverage_and_over_the_sky_it_is_the_opaque_picture() {
    let device = TestDevice::open();
    for backend in TraceBackend::available(&device) {
        let mut stage = Stage::on(&device, scene(), backend);
        let mut render = |background| {
            let params = ReferenceParams { background, ..Default::default() };
            stage.render(&camera(), [SIZE; 2], &params, 7, SPP)
        };
        let opaque = render(Background::Environment);
        let transparent = render(Background::Transparent);
        assert_eq!((opaque.dropped, transparent.dropped), (0, 0));
        let mut kinds = [0; 3];
        for (i, (a, b)) in (0..).zip(transparent.pixels.iter().zip(&opaque.pixels)) {
            let (x, y) = (i % SIZE, i / SIZE);
            let (alpha, expected) = (f64::from(a.coverage), expected_coverage(x, y));
            assert_eq!(a.coverage, b.coverage, "pixel {x},{y}: the background moves no ray");
            if !(1e-6..=1.0 - 1e-6).contains(&expected) {
                assert_eq!(alpha, expected.round(), "pixel {x},{y}");
                kinds[alpha as usize] += 1;
            } else {
                // Four standard errors of independent samples; Sobol's are more even.
                let error = (expected * (1.0 - expected) / f64::from(SPP)).sqrt();
                assert!((alpha - expected).abs() <= 4.0 * error, "pixel {x},{y}: {alpha} {expected}");
                kinds[2] += 1;
            }
            if alpha == 0.0 {
                assert_eq!(a.mean, Vec3::ZERO, "pixel {x},{y}");
            }
            // Sample for sample the same random numbers: only the rounding of two means is left.
            let over = a.mean + (1.0 - a.coverage) * SKY;
            let off = (over - b.mean).abs();
            assert!(off.cmple(1e-6 * b.mean).all(), "{backend}, pixel {x},{y}: {over} {}", b.mean);
        }
        println!("{backend}: {} pixels see the sky, {} surfaces, {} both", kinds[0], kinds[1], kinds[2]);
        assert!(kinds.iter().all(|&count| count > 30), "{kinds:?}");
        // Mirrors and glass show the sky.
        for (x, y, share) in [(11, 4, 0.9), (11, 11, 1.0)] {
            let pixel = transparent.pixels[(y * SIZE + x) as usize];
            assert_eq!(pixel.coverage, 1.0);
            assert!((pixel.mean - share * SKY).abs().max_element() < 1e-3 * SKY.x, "{x},{y}: {}", pixel.mean);
        }
    }
}
