//! The knob `gbuffer.random` reaches every stage, and no source of random numbers changes how much light there is.

use pt_app::args::BackendChoice;
use pt_app::params::{self, FrameParams};
use pt_shaders::channels::{ACCUMULATED, COLOR_HF, ChannelId, VIEW_DIRECTION, VISIBILITY};
use pt_tests::{Frames, builtin};

const SOURCES: [&str; 3] = ["white", "blue-noise", "sobol"];

fn with(source: &str, sets: &[&str]) -> FrameParams {
    let mut all = vec![format!("gbuffer.random={source}")];
    all.extend(sets.iter().map(|set| (*set).to_owned()));
    params::resolve(None, &all).unwrap()
}

fn frames(scene: &str, params: FrameParams, backend: BackendChoice, accumulate: bool) -> Frames {
    let scene = builtin(scene);
    let camera = scene.default_camera();
    Frames::with_params(scene, &camera, backend, [64, 48], 3, accumulate, params)
}

/// A channel of one frame, as bits.
fn channel(scene: &str, params: FrameParams, backend: BackendChoice, id: ChannelId) -> Vec<u32> {
    let mut frames = frames(scene, params, backend, false);
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
    let cases: [(&str, &str, &[&str], ChannelId); 5] = [
        ("position in the pixel", "cornell", &["gbuffer.depth_of_field=false"], VIEW_DIRECTION),
        ("position on the lens", "cornell", &lens, VIEW_DIRECTION),
        ("points on lights", "cornell", &still, COLOR_HF),
        ("lobe of glass", "glass", &choices, VIEW_DIRECTION),
        ("blended surfaces", "kinds", &still, VISIBILITY),
    ];
    for (what, scene, sets, id) in cases {
        let seen = SOURCES.map(|source| channel(scene, with(source, sets), BackendChoice::Compute, id));
        assert!(seen[0] != seen[1] && seen[1] != seen[2] && seen[0] != seen[2], "{what}");
        assert_eq!(seen[2], channel(scene, with("sobol", sets), BackendChoice::Compute, id), "{what}, again");
    }
}

/// Surfaces that blend are found alike by the driver's traversal, which asks for their coverage in shaders of its own.
#[test]
fn backends_agree_on_blended_surfaces() {
    let still = ["gbuffer.jitter=none", "gbuffer.depth_of_field=false"];
    for source in &SOURCES[1..] {
        let seen = [BackendChoice::Compute, BackendChoice::RayQuery, BackendChoice::RtPipeline]
            .map(|backend| channel("kinds", with(source, &still), backend, VISIBILITY));
        for other in &seen[1..] {
            let same = seen[0].chunks_exact(2).zip(other.chunks_exact(2)).filter(|(a, b)| a == b).count();
            assert!(same * 1000 >= seen[0].len() / 2 * 999, "{source}: {same} of {}", seen[0].len() / 2);
        }
    }
}

/// Means of 64 frames: the light of the whole picture and of each of its quarters. With white noise a quarter's is known to 0.7 % (standard
/// error between seeds).
#[test]
fn every_source_gives_the_same_light() {
    for scene in ["cornell", "kinds"] {
        let quarters = SOURCES.map(|source| {
            let mut frames = frames(scene, with(source, &[]), BackendChoice::Compute, true);
            (0..64).for_each(|_| frames.render(0.0));
            let image = frames.image(ACCUMULATED);
            frames.finish();
            let mut sums = [0.0f64; 4];
            for (i, pixel) in image.pixels.iter().enumerate() {
                let (x, y) = (i % 64, i / 64);
                sums[x / 32 + y / 24 * 2] += pixel.iter().map(|&v| f64::from(v)).sum::<f64>();
            }
            sums
        });
        println!("{scene}: {quarters:?}");
        for (source, sums) in SOURCES.iter().zip(&quarters).skip(1) {
            for (a, b) in sums.iter().zip(&quarters[0]) {
                assert!((a / b - 1.0).abs() < 0.03, "{scene}, {source}: {a} and {b}");
            }
        }
    }
}
