//! Temporal anti-aliasing on the built-in scenes, with shading that has no noise: what is left is aliasing and history.

use pt_app::params::resolve;
use pt_core::pack::unpack_unit_vector;
use pt_core::split::to_flat;
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, FrameSizes, StageInputs};
use pt_core::{Device, Recorder};
use pt_image::image_file::{ImageState, LinearImage};
use pt_image::metrics::{Metric, compare};
use pt_post::images::RESOLVED;
use pt_post::oracle::Image;
use pt_post::{ClipSpace, Rectify, Taa, TaaParams};
use pt_shaders::channels::{BASE_COLOR, FLAT_MOTION, Format, NORMAL, VISIBILITY};
use pt_tests::{Frames, builtin};

const SIZE: [u32; 2] = [160, 90];

/// FLIP of a converged picture.
const LIMIT: f64 = 0.02;

/// One frame as temporal anti-aliasing gets it.
struct Shot {
    color: Image,
    motion: Vec<[f32; 2]>,
    jitter: [f32; 2],
    /// Which instance each pixel shows.
    instance: Vec<u32>,
}

/// Renders frames with one offset each and shades them by their base colour and the angle to a fixed direction.
fn shoot(scene: &str, count: u32, seconds_per_frame: f64) -> Vec<Shot> {
    // Gradient pixels of a denoiser would show the surfaces of the last frame.
    let params =
        resolve(Some("realtime"), &["indirect.bounces=0", "denoise.variant=off"].map(String::from), false)
            .unwrap();
    let scene = builtin(scene);
    let camera = scene.default_camera();
    let mut frames = Frames::with_params(scene, &camera, TraceBackend::Compute, SIZE, 0, false, params);
    let light = glam::Vec3::new(0.4, 0.8, 0.45).normalize();
    let shots = (0..count)
        .map(|index| {
            frames.render(f64::from(index) * seconds_per_frame);
            let base = to_flat(frames.floats(BASE_COLOR).as_chunks::<4>().0, SIZE);
            let normals = to_flat(&frames.integers(NORMAL), SIZE);
            let instance = to_flat(frames.integers(VISIBILITY).as_chunks::<2>().0, SIZE);
            let shade = |(base, &word): (&[f32; 4], &u32)| {
                if word == 0 {
                    return [1.5; 3];
                }
                let lit = 0.15 + 1.2 * unpack_unit_vector(word).dot(light).max(0.0);
                [0, 1, 2].map(|i| f64::from(base[i] * lit))
            };
            let pixels = base.iter().zip(&normals).map(shade).collect();
            let motion = frames.floats(FLAT_MOTION);
            Shot {
                color: Image { size: SIZE, pixels },
                motion: motion.as_chunks::<2>().0.to_vec(),
                jitter: pt_gbuffer::halton(index),
                instance: instance.iter().map(|v| v[0]).collect(),
            }
        })
        .collect();
    frames.finish();
    shots
}

/// What the stage makes of the frames, one after the other.
fn resolve_all(device: &Device, shots: &[Shot], params: &TaaParams) -> Vec<Image> {
    let taa = Taa::new(device).unwrap();
    let mut images = ChannelImages::alone(device, FrameSizes::same(SIZE), &[Taa::IO]).unwrap();
    let color = pt_core::Image::new(device, "color", Format::Rgba32F, SIZE).unwrap();
    let motion = pt_core::Image::new(device, "motion", Format::Rg32F, SIZE).unwrap();
    let mut recorder = Recorder::new(device).unwrap();
    let next = |shot: &Shot| {
        // Alpha holds the pixel's flags: a surface that neither reflects nor refracts.
        let texels: Vec<f32> =
            shot.color.pixels.iter().flat_map(|c| [c[0] as f32, c[1] as f32, c[2] as f32, 1.0]).collect();
        color.write_f32(&texels).unwrap();
        motion.write_f32(shot.motion.as_flattened()).unwrap();
        let mut frame = recorder.begin().unwrap();
        images.begin_frame();
        let inputs = StageInputs::new(&images);
        taa.record(&mut frame, &inputs, &color, &motion, shot.jitter, params).unwrap();
        frame.submit().unwrap();
        recorder.finish().unwrap();
        let texels = images.current(RESOLVED).read_f32().unwrap();
        let pixels = texels.chunks_exact(4).map(|c| [c[0], c[1], c[2]].map(f64::from)).collect();
        Image { size: SIZE, pixels }
    };
    shots.iter().map(next).collect()
}

fn linear(image: &Image) -> LinearImage {
    let pixels = image.pixels.iter().map(|c| c.map(|v| v as f32)).collect();
    LinearImage { width: SIZE[0], height: SIZE[1], pixels, state: ImageState::SceneReferred }
}

fn flip(a: &Image, b: &Image) -> f64 {
    compare(&linear(a), &linear(b), &[Metric::Flip]).unwrap()[0].value
}

/// 256 samples a pixel: two periods of the Halton sequence.
#[test]
fn gallery_converges_to_the_reference() {
    let shots = shoot("gallery", 128, 0.0);
    let mut reference = Image { size: SIZE, pixels: vec![[0.0; 3]; shots[0].color.pixels.len()] };
    for shot in &shots {
        for (sum, c) in reference.pixels.iter_mut().zip(&shot.color.pixels) {
            sum.iter_mut().zip(c).for_each(|(s, v)| *s += v / shots.len() as f64);
        }
    }
    let device = TestDevice::open();
    println!("one sample: FLIP {:.4}", flip(&shots[0].color, &reference));
    for space in [ClipSpace::Pq, ClipSpace::Ycocg, ClipSpace::Rgb] {
        let params = TaaParams { space, ..TaaParams::default() };
        let error = flip(resolve_all(&device, &shots[..64], &params).last().unwrap(), &reference);
        println!("{space:?}: FLIP {error:.4}");
        // Linear RGB has no box over time: it loses the thinnest lines.
        assert!(error < LIMIT || space == ClipSpace::Rgb, "{space:?}: {error}");
    }
}

/// For how many frames the ground shows what something has left there: until its error beyond that of undisturbed ground is less
/// than a quarter of what history as it is would show at once. Mean absolute errors against the frame's own shading.
#[test]
fn trails_behind_moving_edges_are_short() {
    let shots = shoot("flicker", 40, 1.0 / 30.0);
    let pixels = shots[0].instance.len();
    // What fills most of the frame is what the others leave behind them.
    let mut seen = std::collections::BTreeMap::new();
    shots.iter().flat_map(|shot| &shot.instance).for_each(|i| *seen.entry(*i).or_insert(0) += 1);
    let ground = *seen.iter().max_by_key(|(_, count)| **count).unwrap().0;
    let device = TestDevice::open();
    let mut trails = Vec::new();
    let mut at_once = None;
    for (name, space, rectify, temporal) in [
        ("off", ClipSpace::Pq, Rectify::Off, 0.0),
        ("PQ clamp", ClipSpace::Pq, Rectify::Clamp, 0.0),
        ("PQ clamp, temporal (default)", ClipSpace::Pq, Rectify::Clamp, TaaParams::default().temporal),
        ("PQ clip", ClipSpace::Pq, Rectify::Clip, 0.0),
        ("YCoCg clamp", ClipSpace::Ycocg, Rectify::Clamp, 0.0),
        ("YCoCg clip", ClipSpace::Ycocg, Rectify::Clip, 0.0),
        ("RGB clamp", ClipSpace::Rgb, Rectify::Clamp, 0.0),
        ("RGB clip", ClipSpace::Rgb, Rectify::Clip, 0.0),
    ] {
        let params = TaaParams { space, rectify, temporal, ..TaaParams::default() };
        let resolved = resolve_all(&device, &shots, &params);
        let mut age = vec![99usize; pixels];
        let mut errors = vec![(0.0, 0u32); 100];
        for (frame, pair) in shots.windows(2).enumerate() {
            for i in 0..pixels {
                age[i] = if pair[0].instance[i] == pair[1].instance[i] { (age[i] + 1).min(99) } else { 0 };
                // The aliasing of edges is no trail: only pixels whose surroundings show the same.
                let width = SIZE[0] as usize;
                let inner = i > width
                    && i + width + 1 < pixels
                    && [i - 1, i + 1, i - width, i + width]
                        .iter()
                        .all(|&n| pair[1].instance[n] == pair[1].instance[i]);
                if frame < 10 || !inner || pair[1].instance[i] != ground {
                    continue;
                }
                let (c, truth) = (resolved[frame + 1].pixels[i], pair[1].color.pixels[i]);
                let error: f64 = (0..3).map(|k| (c[k] - truth[k]).abs()).sum();
                errors[age[i]].0 += error;
                errors[age[i]].1 += 1;
            }
        }
        let mean = |(sum, count): (f64, u32)| sum / f64::from(count.max(1));
        let still = mean(errors[99]);
        let seen = 0.25 * *at_once.get_or_insert(mean(errors[0]) - still);
        let length =
            (0..30).rev().find(|&a| errors[a].1 > 20 && mean(errors[a]) - still > seen).map_or(0, |a| a + 1);
        println!(
            "{name:<30} {length:>2} frames; error at once {:.4}, after 5 frames {:.4}, undisturbed {still:.4}",
            mean(errors[0]),
            mean(errors[5])
        );
        trails.push(length);
    }
    assert!(trails[1..].iter().all(|&length| 2 * length < trails[0]), "{trails:?}");
}
