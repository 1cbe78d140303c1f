//! The knob `gbuffer.random` reaches every stage, and no source of random numbers changes how much light there is.

use pt_app::params::{self, FrameParams};
use pt_core::trace::TraceBackend;
use pt_shaders::channels::{ACCUMULATED, COLOR_HF, COLOR_LF_SH, ChannelId, VIEW_DIRECTION, VISIBILITY};
use pt_tests::{Frames, builtin};

const SOURCES: [&str; 3] = ["white", "blue-noise", "sobol"];

fn with(source: &str, sets: &[&str]) -> FrameParams {
    let mut all =
        vec![format!("gbuffer.random={source}"), "indirect.bounces=0".into(), "denoise.variant=off".into()];
    all.extend(sets.iter().map(|set| (*set).to_owned()));
    params::resolve(None, &all, false).unwrap()
}

const SIZE: [u32; 2] = [64, 48];

fn frames(scene: &str, params: FrameParams, backend: TraceBackend, seed: u32, accumulate: bool) -> Frames {
    let mut scene = builtin(scene);
    // The disc of the sun in mirrors is a few samples that carry the light of a quarter of the picture.
    scene.lights.iter_mut().for_each(|light| light.angular_radius = 0.0);
    let camera = scene.default_camera();
    Frames::with_params(scene, &camera, backend, SIZE, seed, accumulate, params)
}

/// A channel of one frame, as bits.
fn channel(scene: &str, params: FrameParams, backend: TraceBackend, id: ChannelId) -> Vec<u32> {
    let mut frames = frames(scene, params, backend, 3, false);
    frames.render(0.0);
    let values = match id.channel().format.is_uint() {
        true => frames.integers(id),
        false => frames.floats(id).into_iter().map(f32::to_bits).collect(),
    };
    frames.finish();
    values
}

/// Each decision alone, the others being switched off: what it decides differs from source to source, and is the same twice.
#[test]
fn every_stage_draws_from_the_source() {
    let still = ["gbuffer.jitter=none", "gbuffer.depth_of_field=false"];
    let lens = ["gbuffer.jitter=none", "gbuffer.lens_radius=0.05"];
    let choices = [&still[..], &["gbuffer.alternate_fields=false"]].concat();
    let bounce = [&still[..], &["indirect.bounces=1"]].concat();
    let cases: [(&str, &str, &[&str], ChannelId); 6] = [
        ("position in the pixel", "cornell", &["gbuffer.depth_of_field=false"], VIEW_DIRECTION),
        ("position on the lens", "cornell", &lens, VIEW_DIRECTION),
        ("points on lights", "cornell", &still, COLOR_HF),
        ("bounce rays", "cornell", &bounce, COLOR_LF_SH),
        ("lobe of glass", "glass", &choices, VIEW_DIRECTION),
        ("blended surfaces", "kinds", &still, VISIBILITY),
    ];
    for (what, scene, sets, id) in cases {
        let seen = SOURCES.map(|source| channel(scene, with(source, sets), TraceBackend::Compute, id));
        assert!(seen[0] != seen[1] && seen[1] != seen[2] && seen[0] != seen[2], "{what}");
        assert_eq!(seen[2], channel(scene, with("sobol", sets), TraceBackend::Compute, id), "{what}, again");
    }
}

/// Surfaces that blend are found alike by the driver's traversal, which asks for their coverage in shaders of its own.
#[test]
fn backends_agree_on_blended_surfaces() {
    let still = ["gbuffer.jitter=none", "gbuffer.depth_of_field=false"];
    for source in &SOURCES[1..] {
        let seen = [TraceBackend::Compute, TraceBackend::RayQuery, TraceBackend::RtPipeline]
            .map(|backend| channel("kinds", with(source, &still), backend, VISIBILITY));
        for other in &seen[1..] {
            let same = seen[0].chunks_exact(2).zip(other.chunks_exact(2)).filter(|(a, b)| a == b).count();
            assert!(same * 1000 >= seen[0].len() / 2 * 999, "{source}: {same} of {}", seen[0].len() / 2);
        }
    }
}

/// Means and standard errors over seeds of the light of the picture's quarters.
fn light(scene: &str, source: &str) -> [(f64, f64); 4] {
    const SEEDS: u32 = 8;
    let mut frames = frames(scene, with(source, &[]), TraceBackend::Compute, 0, true);
    let runs: Vec<[f64; 4]> = (0..SEEDS)
        .map(|seed| {
            frames.restart(seed);
            (0..16).for_each(|_| frames.render(0.0));
            let image = frames.image(ACCUMULATED);
            let mut sums = [0.0; 4];
            for (i, pixel) in image.pixels.iter().enumerate() {
                let (x, y) = (i as u32 % SIZE[0], i as u32 / SIZE[0]);
                let quarter = x / (SIZE[0] / 2) + y / (SIZE[1] / 2) * 2;
                sums[quarter as usize] += pixel.iter().map(|&v| f64::from(v)).sum::<f64>();
            }
            sums
        })
        .collect();
    frames.finish();
    std::array::from_fn(|quarter| {
        let n = f64::from(SEEDS);
        let mean = runs.iter().map(|run| run[quarter]).sum::<f64>() / n;
        let variance = runs.iter().map(|run| (run[quarter] - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean, (variance / n).sqrt())
    })
}

/// The means of frames agree within five standard errors of their difference, which are per cents of the light at most.
#[test]
fn every_source_gives_the_same_light() {
    for scene in ["cornell", "kinds"] {
        let [white, others @ ..] = SOURCES.map(|source| light(scene, source));
        for (source, light) in SOURCES[1..].iter().zip(others) {
            for ((a, a_error), (b, b_error)) in light.into_iter().zip(white) {
                let error = a_error.hypot(b_error);
                println!("{scene}, {source}: {a:.2} and {b:.2}, standard error {error:.2}");
                assert!((a - b).abs() < 5.0 * error && error < 0.05 * b, "{scene}, {source}");
            }
        }
    }
}
