//! The three ways to trace rays see one scene: at the same seed they give the same frames.

use glam::{Affine3A, Vec2, Vec3, Vec4};
use pt_app::params::resolve;
use pt_core::rng::random4;
use pt_core::trace::TraceBackend;
use pt_image::image_file::LinearImage;
use pt_image::metrics::{Metric, compare};
use pt_import::{LoadOptions, open};
use pt_scene::{Environment, Instance, Material, Mesh, Scene};
use pt_shaders::channels::{FLAT_COLOR, VISIBILITY};
use pt_test_data::shared;
use pt_tests::{Frames, builtin};

/// Share of pixels that must see the same triangle of the same instance; rounding decides the rest at edges.
const SAME_HITS: f64 = 0.999;
/// The most that linear images may differ by.
const RELMSE: f64 = 1e-3;

struct Seen {
    hits: Vec<u32>,
    image: LinearImage,
    backends: Vec<TraceBackend>,
}

/// The second of two frames: instances have moved, top levels were rebuilt.
fn see(scene: &Scene, size: [u32; 2], backend: TraceBackend) -> Seen {
    let mut frames = Frames::new(scene.clone(), &scene.default_camera(), backend, size, 7, false);
    assert!(backend == TraceBackend::Auto || frames.backend() == backend);
    frames.render(0.4);
    frames.render(0.5);
    let seen = Seen {
        hits: frames.integers(VISIBILITY),
        image: frames.image(FLAT_COLOR),
        backends: frames.backends(),
    };
    frames.finish();
    seen
}

fn agree(name: &str, scene: &Scene, size: [u32; 2]) {
    let compute = see(scene, size, TraceBackend::Compute);
    let surfaces = compute.hits.chunks_exact(2).filter(|hit| hit[0] != u32::MAX).count();
    assert!(surfaces * 2 > compute.hits.len() / 2, "{name}: most of the picture is a surface");
    assert!(compute.image.pixels.iter().any(|p| p[1] > 0.0), "{name}: there is light");
    for backend in compute.backends.iter().copied().filter(|b| *b != TraceBackend::Compute) {
        let other = see(scene, size, backend);
        let pairs = compute.hits.chunks_exact(2).zip(other.hits.chunks_exact(2));
        let same = pairs.filter(|(a, b)| a == b).count() as f64 / (compute.hits.len() / 2) as f64;
        let relmse = compare(&other.image, &compute.image, &[Metric::RelMse]).unwrap()[0].value;
        println!("{name}, {backend} against compute: {:.4} % same hits, relMSE {relmse:.2e}", 100.0 * same);
        assert!(same >= SAME_HITS, "{name}, {backend}: {same}");
        assert!(relmse <= RELMSE, "{name}, {backend}: {relmse}");
    }
}

#[test]
fn cornell() {
    agree("cornell", &builtin("cornell"), [96, 54]);
}

/// With moving instances, alpha and many lights.
#[test]
fn gallery() {
    agree("gallery", &builtin("gallery"), [96, 54]);
}

/// Sheets of two layers, which on a GPU are the two triangles of a leaf: their fronts, their backs, and materials that are seen from both sides.
fn layers() -> Scene {
    let random = |stream, i| Vec3::from_slice(&random4([i, stream], 0, 0, 0)[..3]);
    let mut mesh = Mesh { name: "layers".into(), first_masked: 600, ..Mesh::default() };
    for triangle in 0..600 {
        let sheet = triangle / 2;
        let layer = 0.003 * (triangle % 2) as f32 * Vec3::Z;
        for corner in 0..3 {
            let place = 2.0 * random(1, sheet) + 0.5 * random(2, 3 * sheet + corner) - 1.25;
            mesh.positions.push(place + layer);
            mesh.normals.push(Vec3::Z);
            mesh.tangents.push(Vec4::new(1.0, 0.0, 0.0, 1.0));
            mesh.uv0.push(Vec2::ZERO);
            mesh.uv1.push(Vec2::ZERO);
            mesh.colors.push(Vec4::ONE);
        }
        let choice = random(3, triangle);
        let [a, b, c] = [0, 1, 2].map(|corner| 3 * triangle + corner);
        mesh.indices.push(if choice.x < 0.5 { [a, b, c] } else { [a, c, b] });
        mesh.triangle_materials.push(u32::from(choice.y < 0.5));
    }
    let single = Material { double_sided: false, ..Material::lambertian("one side", Vec3::X) };
    let double = Material { double_sided: true, ..Material::lambertian("both sides", Vec3::Y) };
    Scene {
        meshes: vec![mesh],
        instances: vec![Instance::new("layers", 0, Affine3A::IDENTITY)],
        materials: vec![single, double],
        environment: Environment::constant(Vec3::ONE),
        ..Scene::default()
    }
}

/// Trees and steps as on a GPU change nothing in the picture, with instances, solids within solids, god rays and caustics, in a scene of one instance, and
/// where surfaces are seen from one side.
#[test]
fn gpu_traversal() {
    let sets = ["denoise.variant=off", "gbuffer.godrays.density=0.02", "lights.caustics=true"];
    let params = resolve(None, &sets.map(String::from), false).unwrap();
    let named = ["gallery", "glass", "room"].map(|name| (name, builtin(name)));
    for (name, scene) in named.into_iter().chain([("layers", layers())]) {
        let camera = scene.default_camera();
        let [a, b] = [false, true].map(|gpu| {
            let (scene, params) = (scene.clone(), params.clone());
            let mut frames = Frames::with_gpu_traversal(gpu, scene, &camera, [64, 36], 7, params);
            frames.render(0.4);
            frames.render(0.5);
            let seen = (frames.integers(VISIBILITY), frames.floats(FLAT_COLOR));
            frames.finish();
            seen
        });
        assert!(a.0 == b.0, "{name}: other surfaces");
        let differ = a.1.iter().zip(&b.1).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
        assert_eq!(differ, 0, "{name}: values of {}", a.1.len());
    }
}

/// Textures, masked leaves and an environment.
#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn sponza() {
    let file = shared("scenes/Sponza/Sponza.gltf");
    let environment = shared("environments/royal_esplanade_1k.hdr");
    let options = LoadOptions { environment: Some(environment), ..LoadOptions::default() };
    agree("Sponza", &open(file.to_str().unwrap(), &options).unwrap(), [64, 36]);
}
