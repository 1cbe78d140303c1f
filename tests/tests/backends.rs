//! The three ways to trace rays see one scene: at the same seed they give the same frames.

use pt_app::params::resolve;
use pt_core::trace::TraceBackend;
use pt_image::image_file::LinearImage;
use pt_image::metrics::{Metric, compare};
use pt_import::{LoadOptions, open};
use pt_scene::Scene;
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

/// Steps that visit two nodes change nothing in the picture, with instances, solids within solids, god rays and caustics, nor in a scene of one
/// instance.
#[test]
fn gpu_traversal() {
    let sets = ["denoise.variant=off", "gbuffer.godrays.density=0.02", "lights.caustics=true"];
    let params = resolve(None, &sets.map(String::from), false).unwrap();
    for name in ["gallery", "glass", "room"] {
        let scene = builtin(name);
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
