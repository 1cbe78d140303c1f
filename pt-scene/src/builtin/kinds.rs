//! One body of every material, in a grid: from left to right, then from the back row to the front one, in the order in which `bodies` and
//! `named_kinds` list them (pt-scene/README.md has the list). The camera `front` sees all of them; each kind of [`MaterialKind`] has a camera of
//! its name.

use glam::{Affine3A, Vec2, Vec3};

use super::noise::picture;
use super::shapes::Shape;
use super::{add_material, add_mesh, place};
use crate::{AlphaMode, Camera, Instance, Light, Lobes, Material, MaterialKind, Scene, TextureRef, Waves};

const COLUMNS: usize = 8;
const RADIUS: f32 = 0.4;

/// What carries the material.
#[derive(Clone, Copy, PartialEq)]
enum Body {
    /// A closed sphere.
    Ball,
    /// The lower half of a sphere without thickness: its inside is seen over the rim.
    Bowl,
    /// An upright picture.
    Panel,
}

pub(super) fn scene() -> Scene {
    let mut scene =
        Scene { environment: crate::sky::sky(Vec3::new(0.5, 0.6, 0.6).normalize(), 0.8), ..Scene::default() };
    scene.textures.push(picture("squares", 128, |uv| {
        let cell = (uv * 8.0).floor();
        (Vec3::splat(0.9), f32::from(u8::from((cell.x + cell.y) as i32 % 2 == 0)))
    }));
    scene.textures.push(picture("floor", 256, |uv| {
        let cell = (uv * 2.0).floor();
        (Vec3::splat(if (cell.x + cell.y) as i32 % 2 == 0 { 0.5 } else { 0.25 }), 1.0)
    }));
    let floor =
        Material { base_color_texture: Some(TextureRef::new(1)), ..Material::lambertian("floor", Vec3::ONE) };
    let floor = add_material(&mut scene, floor);
    let mut plane = Shape::default();
    plane.quad(Vec3::new(-20.0, 0.0, 10.0), Vec3::X * 40.0, Vec3::Z * -30.0, Vec2::new(20.0, 15.0), floor);
    place(&mut scene, "floor", plane);

    let mut bodies = bodies();
    bodies.extend(named_kinds());
    let mut cameras = Vec::new();
    let rows = bodies.len().div_ceil(COLUMNS);
    for (i, (body, material)) in bodies.into_iter().enumerate() {
        let (column, row) = (i % COLUMNS, i / COLUMNS);
        let name = material.name.clone();
        let material = add_material(&mut scene, material);
        let mut shape = Shape::default();
        match body {
            Body::Ball => shape.icosphere(Vec3::ZERO, RADIUS, 4, true, material),
            Body::Bowl => shape.surface(64, 24, Vec2::new(2.0, 1.0), material, |u, v| {
                let (polar, azimuth) = (0.55 * std::f32::consts::PI * v, std::f32::consts::TAU * u);
                let (sin, cos) = azimuth.sin_cos();
                RADIUS * Vec3::new(polar.sin() * cos, -polar.cos(), -polar.sin() * sin)
            }),
            Body::Panel => {
                let (width, height) = (0.8 * Vec3::X, 0.45 * Vec3::Y);
                shape.quad(-0.5 * (width + height), width, height, Vec2::ONE, material)
            }
        };
        let mesh = add_mesh(&mut scene, &name, shape);
        let at = Vec3::new(
            column as f32 - 0.5 * (COLUMNS - 1) as f32,
            RADIUS + 1e-3,
            1.1 * (row as f32 - (rows - 1) as f32),
        );
        scene.instances.push(Instance::new(&name, mesh, Affine3A::from_translation(at)));
        if MaterialKind::ALL.iter().any(|kind| kind.name() == name) {
            cameras.push(Camera::look_at(&name, at + Vec3::new(0.0, 0.9, 1.5), at, 0.55));
        }
    }
    scene.lights.push(Light {
        angular_radius: 0.01,
        ..Light::directional("sun", Vec3::new(-0.5, -0.6, -0.6), 2.0 * Vec3::new(1.0, 0.95, 0.85))
    });
    let middle = Vec3::new(0.0, 0.2, -0.55 * (rows - 1) as f32);
    scene.cameras.push(Camera::look_at("front", Vec3::new(0.0, 4.6, 5.8), middle, 0.62));
    scene.cameras.append(&mut cameras);
    scene
}

fn bodies() -> Vec<(Body, Material)> {
    use Body::{Ball, Bowl};
    let with = |material: Material, lobes: Lobes| Material { lobes: Some(Box::new(lobes)), ..material };
    let plastic =
        |name: &str, roughness| Material { roughness, ..Material::diffuse(name, Vec3::new(0.05, 0.25, 0.6)) };
    let colored = |name: &str| Material::diffuse(name, Vec3::new(0.75, 0.2, 0.1));
    let thin = |name: &str, roughness| Material {
        transmission: 1.0,
        roughness,
        double_sided: true,
        ..Material::diffuse(name, Vec3::new(0.6, 0.85, 0.7))
    };
    vec![
        (Ball, Material::lambertian("regular", Vec3::new(0.75, 0.2, 0.1))),
        (Ball, plastic("smooth plastic", 0.05)),
        (Ball, plastic("rough plastic", 0.5)),
        (Ball, Material::metal("mirror", Vec3::splat(0.95), 0.0)),
        (Ball, Material::metal("gold", Vec3::new(1.0, 0.71, 0.29), 0.2)),
        (Ball, Material::metal("rough copper", Vec3::new(0.93, 0.52, 0.38), 0.6)),
        (Ball, Material::solid("clear glass", 1.5)),
        (Ball, Material { roughness: 0.3, ..Material::solid("rough glass", 1.5) }),
        (
            Ball,
            Material {
                attenuation_color: Vec3::new(0.2, 0.7, 0.3),
                attenuation_distance: 0.4,
                ..Material::solid("absorbing glass", 1.5)
            },
        ),
        (
            Ball,
            with(
                Material::solid("diamond, dispersion", 2.42),
                Lobes { dispersion: 20.0 / 55.0, ..Lobes::default() },
            ),
        ),
        (Bowl, thin("thin glass", 0.0)),
        (Bowl, thin("thin frosted glass", 0.4)),
        (
            Ball,
            Material {
                emissive: Vec3::new(3.0, 1.6, 0.6),
                ..Material::lambertian("emissive", Vec3::splat(0.2))
            },
        ),
        (
            Bowl,
            Material {
                double_sided: true,
                ..Material::lamp("emissive, both sides", Vec3::new(0.4, 0.8, 2.0))
            },
        ),
        (Ball, Material { unlit: true, ..colored("unlit") }),
        (
            Bowl,
            Material {
                alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
                double_sided: true,
                base_color_texture: Some(TextureRef::new(0)),
                ..colored("mask")
            },
        ),
        (
            Ball,
            Material {
                alpha_mode: AlphaMode::Blend,
                base_color: Vec3::new(0.75, 0.2, 0.1).extend(0.5),
                ..colored("blend")
            },
        ),
        (Bowl, Material { double_sided: true, ..colored("double-sided") }),
        (Bowl, colored("single-sided")),
        (
            Ball,
            Material {
                specular: 0.3,
                specular_color: Vec3::new(0.2, 0.6, 1.0),
                ..plastic("tinted specular", 0.2)
            },
        ),
        (
            Ball,
            with(
                plastic("clearcoat", 0.6),
                Lobes { clearcoat: 1.0, clearcoat_roughness: 0.05, ..Lobes::default() },
            ),
        ),
        (
            Ball,
            with(
                Material::diffuse("sheen", Vec3::new(0.2, 0.02, 0.04)),
                Lobes { sheen_color: Vec3::new(0.9, 0.6, 0.5), sheen_roughness: 0.4, ..Lobes::default() },
            ),
        ),
        (
            Ball,
            with(
                Material::metal("anisotropy", Vec3::splat(0.7), 0.4),
                Lobes { anisotropy_strength: 0.9, ..Lobes::default() },
            ),
        ),
        (
            Ball,
            with(
                Material::metal("iridescence", Vec3::splat(0.6), 0.15),
                Lobes { iridescence: 1.0, iridescence_ior: 1.4, ..Lobes::default() },
            ),
        ),
    ]
}

/// The kinds of [`MaterialKind`] but for the regular one, which all others are.
fn named_kinds() -> Vec<(Body, Material)> {
    use Body::{Ball, Bowl, Panel};
    let of = |kind: MaterialKind, color: Vec3| Material::diffuse(kind.name(), color).with_kind(kind);
    let half = |kind: MaterialKind, color: Vec3| {
        let base_color = color.extend(0.5);
        Material { base_color, ..Material::diffuse(kind.name(), color) }.with_kind(kind)
    };
    // Waves that fit onto a ball.
    let ripples = Some(Waves { length: 0.15, ..Waves::default() });
    let liquid = |kind: MaterialKind| Material { waves: ripples, ..of(kind, Vec3::ONE) };
    let picture = Some(TextureRef::new(1));
    let checks =
        Material { base_color_texture: picture, ..Material::diffuse("screen", Vec3::new(0.4, 1.6, 2.4)) };
    let thick = Material { thickness: 1.0, ..Material::diffuse("glass", Vec3::new(0.8, 0.95, 0.9)) };
    vec![
        (Ball, of(MaterialKind::Chrome, Vec3::splat(0.9))),
        (Bowl, Material { double_sided: true, ..of(MaterialKind::ChromeModel, Vec3::new(0.9, 0.8, 0.6)) }),
        (Ball, thick.with_kind(MaterialKind::Glass)),
        (Ball, liquid(MaterialKind::Water)),
        (Ball, liquid(MaterialKind::Slime)),
        (Ball, of(MaterialKind::Lava, Vec3::new(0.8, 0.2, 0.03))),
        (Panel, of(MaterialKind::Sky, Vec3::ONE)),
        (Ball, of(MaterialKind::Invisible, Vec3::ONE)),
        (Ball, half(MaterialKind::Explosion, Vec3::new(0.5, 0.25, 0.05))),
        (Panel, half(MaterialKind::TransparentWall, Vec3::new(0.1, 0.3, 0.7))),
        (Ball, half(MaterialKind::TransparentModel, Vec3::new(0.1, 0.6, 0.2))),
        (Panel, checks.with_kind(MaterialKind::Screen)),
        (Panel, of(MaterialKind::Camera, Vec3::ONE)),
    ]
}
