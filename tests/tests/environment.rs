//! Where the light of an environment image comes from: an image with one bright spot lights one side of a box.

use glam::{Affine3A, Quat, Vec2, Vec3, Vec4};
use pt_core::trace::TraceBackend;
use pt_image::image_file::{Layer, LayeredImage};
use pt_scene::{Camera, Environment, Instance, Material, Mesh, Scene};
use pt_shaders::channels::FLAT_COLOR;
use pt_tests::{Frames, direct_light_only};
use std::f32::consts::FRAC_PI_2;
use std::path::Path;

const SIZE: u32 = 32;

/// The four upright sides of a Lambertian box round the origin, two metres wide.
fn sides() -> Scene {
    let mut mesh =
        Mesh { name: "sides".into(), triangle_materials: vec![0; 8], first_masked: 8, ..Mesh::default() };
    for side in 0..4 {
        let turn = Quat::from_rotation_y(FRAC_PI_2 * side as f32);
        let first = mesh.positions.len() as u32;
        for corner in [Vec2::new(-1.0, -1.0), Vec2::new(1.0, -1.0), Vec2::new(1.0, 1.0), Vec2::new(-1.0, 1.0)]
        {
            mesh.positions.push(turn * corner.extend(1.0));
            mesh.normals.push(turn * Vec3::Z);
            mesh.tangents.push((turn * Vec3::X).extend(1.0));
            mesh.uv0.push(corner);
            mesh.uv1.push(corner);
            mesh.colors.push(Vec4::ONE);
        }
        mesh.indices.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    Scene {
        meshes: vec![mesh],
        instances: vec![Instance::new("sides", 0, Affine3A::IDENTITY)],
        materials: vec![Material::lambertian("white", Vec3::splat(0.5))],
        ..Scene::default()
    }
}

/// A black lat-long EXR of 64 x 32 texels with a bright 2 x 2 spot round the horizon at `u`.
fn spot_image(path: &Path, u: f32) {
    let (width, height) = (64, 32);
    let column = (u * width as f32) as u32;
    let bright = |i: u32| {
        let (x, y) = (i % width, i / width);
        if (column - 1..=column).contains(&x) && (15..=16).contains(&y) { [500.0; 3] } else { [0.0f32; 3] }
    };
    let values: Vec<f32> = (0..width * height).flat_map(bright).collect();
    let mut image = LayeredImage::new(width, height).unwrap();
    image.layers.push(Layer::from_interleaved("", &["R", "G", "B"], 3, &values));
    image.write_exr(path).unwrap();
}

/// Brightness of the sides towards +X, +Z, -X and -Z.
fn brightness(environment: &Environment) -> [f32; 4] {
    let mut out = [0.0; 4];
    for (view, eye) in [Vec3::new(6.0, 0.0, 6.0), Vec3::new(-6.0, 0.0, -6.0)].into_iter().enumerate() {
        let scene = Scene { environment: environment.clone(), ..sides() };
        scene.validate().unwrap();
        // Narrow enough that the spot itself is not in the picture.
        let camera = Camera::look_at("corner", eye, Vec3::ZERO, 0.4);
        let mut frames = Frames::with_params(
            scene,
            &camera,
            TraceBackend::Compute,
            [SIZE; 2],
            3,
            false,
            direct_light_only(),
        );
        for _ in 0..4 {
            frames.render(0.0);
            let image = frames.image(FLAT_COLOR);
            for (i, pixel) in (0u32..).zip(&image.pixels) {
                // From (1, 0, 1) the side towards +X is on the right; from the other corner that towards -X.
                let right = i % SIZE >= SIZE / 2;
                out[2 * view + usize::from(!right)] += pixel[1];
            }
        }
        frames.finish();
    }
    out
}

#[test]
fn a_bright_spot_lights_the_side_that_faces_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("spot.exr");
    // u of the spot, rotation in quarter turns, index of the side.
    for (u, quarters, side) in [
        (0.5, 0.0, 0),  // +X
        (0.25, 0.0, 3), // -Z
        (0.75, 0.0, 1), // +Z
        (0.5, 1.0, 3),  // +X turned counter-clockwise, seen from above: -Z
    ] {
        spot_image(&file, u);
        let mut environment = Environment::load(&file).unwrap();
        environment.rotation = quarters * FRAC_PI_2;
        let lit = brightness(&environment);
        let others = (0..4).filter(|&i| i != side).map(|i| lit[i]).fold(0.0, f32::max);
        assert!(lit[side] > 1.0 && others < 0.1 * lit[side], "u {u}, {quarters} quarter turns: {lit:?}");
    }
}
