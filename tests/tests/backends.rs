//! The three ways to trace rays see one scene: at the same seed they give the same frames.

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

/// Textures, masked leaves and an environment.
#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn sponza() {
    let file = shared("scenes/Sponza/Sponza.gltf");
    let environment = shared("environments/royal_esplanade_1k.hdr");
    let options = LoadOptions { environment: Some(environment), ..LoadOptions::default() };
    agree("Sponza", &open(file.to_str().unwrap(), &options).unwrap(), [64, 36]);
}
