//! Direct light averaged over 1024 frames against what it must be.
//!
//! The standard error comes from the frames themselves: random numbers differ from frame to frame, so the frames' values of a
//! block of pixels are independent, and their standard deviation over the root of the number of frames is the standard error of the
//! block's mean. Among n blocks that are right, about 0.27 % lie beyond three standard errors; a test takes as many as chance
//! exceeds in one of a thousand runs.

use glam::{DVec2, DVec3};
use pt_core::trace::TraceBackend;
use pt_reference::direct::{DirectLight, Quality};
use pt_scene::{Camera, Projection, Scene};
use pt_shaders::channels::{ACCUMULATED, FLAT_COLOR};
use pt_tests::{Frames, builtin, direct_light_only};
use rayon::prelude::*;
use std::f64::consts::PI;

const FRAMES: u32 = 1024;
/// Chance of a normal variable beyond three standard deviations.
const BEYOND_THREE: f64 = 0.0027;
/// Rounding that no averaging removes, relative: 16-bit albedo (1 / 65535 / 2 of 0.5) and the fp32 light path.
const ROUNDING: f64 = 3e-5;

/// Mean and standard error of the mean of one channel of one block.
#[derive(Clone, Copy)]
struct Estimate {
    mean: f64,
    error: f64,
}

struct Accumulated {
    /// Red, green and blue of every block, row by row.
    blocks: Vec<[Estimate; 3]>,
    /// The same of the whole image.
    whole: [Estimate; 3],
}

/// Averages `block` x `block` pixels of an image of `size`.
fn to_blocks(pixels: &[[f64; 3]], size: [u32; 2], block: u32) -> Vec<[f64; 3]> {
    let [columns, rows] = size.map(|s| s / block);
    assert_eq!([columns * block, rows * block], size);
    let mut blocks = vec![[0.0; 3]; (columns * rows) as usize];
    for (i, pixel) in (0..).zip(pixels) {
        let (x, y) = (i % size[0] / block, i / size[0] / block);
        for c in 0..3 {
            blocks[(y * columns + x) as usize][c] += pixel[c] / f64::from(block * block);
        }
    }
    blocks
}

fn accumulate(scene: Scene, camera: &Camera, size: [u32; 2], block: u32) -> Accumulated {
    let direct = direct_light_only();
    let mut frames = Frames::with_params(scene, camera, TraceBackend::Compute, size, 11, true, direct);
    let rgb = |image: pt_image::image_file::LinearImage| -> Vec<[f64; 3]> {
        image.pixels.iter().map(|p| p.map(f64::from)).collect()
    };
    let (mut sums, mut squares) = (Vec::new(), Vec::new());
    for _ in 0..FRAMES {
        frames.render(0.0);
        let mut values = to_blocks(&rgb(frames.image(FLAT_COLOR)), size, block);
        let whole = std::array::from_fn(|c| values.iter().map(|v| v[c]).sum::<f64>() / values.len() as f64);
        values.push(whole);
        sums.resize(values.len(), [0.0; 3]);
        squares.resize(values.len(), [0.0; 3]);
        for (i, value) in values.iter().enumerate() {
            for c in 0..3 {
                sums[i][c] += value[c];
                squares[i][c] += value[c] * value[c];
            }
        }
    }
    // The mean is what the frame's own pass made of it.
    let mut means = to_blocks(&rgb(frames.image(ACCUMULATED)), size, block);
    means.push(std::array::from_fn(|c| means.iter().map(|v| v[c]).sum::<f64>() / means.len() as f64));
    frames.finish();

    let n = f64::from(FRAMES);
    let mut blocks: Vec<[Estimate; 3]> = (0..means.len())
        .map(|i| {
            std::array::from_fn(|c| {
                let (mean, sum) = (means[i][c], sums[i][c] / n);
                assert!(
                    (mean - sum).abs() <= 1e-5 * sum,
                    "the accumulated image is the mean of the frames: {mean} {sum}"
                );
                let variance = (squares[i][c] - n * sum * sum).max(0.0) / (n - 1.0);
                Estimate { mean, error: (variance / n).sqrt().hypot(ROUNDING * mean) }
            })
        })
        .collect();
    let whole = blocks.pop().unwrap();
    Accumulated { blocks, whole }
}

/// Deviations in standard errors.
fn deviation(estimate: Estimate, truth: f64) -> f64 {
    let difference = estimate.mean - truth;
    if difference == 0.0 { 0.0 } else { difference / estimate.error }
}

/// The most of `n` blocks that chance puts beyond three standard errors, but for one of a thousand runs.
fn taken(n: usize) -> usize {
    let mut probability = (1.0 - BEYOND_THREE).powi(n as i32);
    let (mut k, mut total) = (0, probability);
    while total < 0.999 {
        probability *= (n - k) as f64 / (k + 1) as f64 * BEYOND_THREE / (1.0 - BEYOND_THREE);
        k += 1;
        total += probability;
    }
    k
}

/// Blocks are judged by their green value: the three channels see the same random numbers.
fn check(name: &str, actual: &Accumulated, truth: &[[f64; 3]]) {
    assert_eq!(actual.blocks.len(), truth.len());
    let n = truth.len();
    let allowed = taken(n);
    let deviations: Vec<f64> = actual.blocks.iter().zip(truth).map(|(b, t)| deviation(b[1], t[1])).collect();
    let outside = deviations.iter().filter(|d| d.abs() > 3.0).count();
    let spread = (deviations.iter().map(|d| d * d).sum::<f64>() / n as f64).sqrt();
    let worst = deviations.iter().fold(0.0f64, |w, d| w.max(d.abs()));
    let whole: [f64; 3] = std::array::from_fn(|c| {
        deviation(actual.whole[c], truth.iter().map(|t| t[c]).sum::<f64>() / truth.len() as f64)
    });
    let relative = actual.whole[1].error / actual.whole[1].mean;
    println!(
        "{name}: {outside} of {n} blocks beyond 3 standard errors (chance expects {:.2}, at most {allowed} taken), \
         largest {worst:.2}, root mean square {spread:.2}; whole image {whole:.2?} standard errors of {relative:.1e}",
        BEYOND_THREE * n as f64,
    );
    assert!(outside <= allowed, "{name}: {deviations:.1?}");
    assert!(whole.iter().all(|d| d.abs() <= 3.0), "{name}: {whole:?}");
    // Errors that are much too large would hide everything.
    assert!(spread > 0.5 && relative < 0.01, "{name}: {spread} {relative}");
}

/// Pixel means of a function of the camera ray and two more numbers of the unit square, over 4096 points of a Kronecker
/// sequence in four dimensions (Roberts 2018). Unlike a grid it has no rows, so that an edge along one costs nothing.
fn pixel_means(
    camera: &Camera,
    size: [u32; 2],
    f: impl Fn(DVec3, DVec3, DVec2) -> DVec3 + Sync,
) -> Vec<[f64; 3]> {
    const POINTS: u32 = 4096;
    /// Root of x^5 = x + 1.
    const G: f64 = 1.167_303_978_261_418_7;
    let Projection::Perspective { yfov } = camera.projection else { panic!("a perspective camera") };
    let half_height = (0.5 * f64::from(yfov)).tan();
    let half_width = half_height * f64::from(size[0]) / f64::from(size[1]);
    let world = camera.world_from_camera;
    let axes = [world.matrix3.x_axis, world.matrix3.y_axis, world.matrix3.z_axis].map(|a| a.as_dvec3());
    let eye = world.translation.as_dvec3();
    let pixel = |i: u32| {
        let sum: DVec3 = (0..POINTS)
            .map(|k| {
                let [a, b, c, d] = [1, 2, 3, 4].map(|j| (0.5 + f64::from(k) * G.powi(-j)).fract());
                let (x, y) = (f64::from(i % size[0]) + a, f64::from(i / size[0]) + b);
                let right = (2.0 * x / f64::from(size[0]) - 1.0) * half_width;
                let up = (1.0 - 2.0 * y / f64::from(size[1])) * half_height;
                f(eye, (right * axes[0] + up * axes[1] - axes[2]).normalize(), DVec2::new(c, d))
            })
            .sum();
        (sum / f64::from(POINTS)).to_array()
    };
    (0..size[0] * size[1]).into_par_iter().map(pixel).collect()
}

/// 100 cd, 2 m over a plane of albedo 1/2: L = I x albedo / pi x cos / d^2, in every pixel.
#[test]
fn a_point_light_over_a_plane() {
    let scene = builtin("plane");
    let camera = scene.cameras[0].clone();
    let size = [24, 16];
    let truth = pixel_means(&camera, size, |eye, direction, _| {
        assert!(direction.y < 0.0, "the plane fills the picture");
        let foot = eye - direction * (eye.y / direction.y);
        assert!(foot.abs().max_element() < 100.0);
        let distance = foot.distance(DVec3::Y * 2.0);
        DVec3::splat(100.0 * 0.5 / PI * (2.0 / distance) / (distance * distance))
    });
    check("plane", &accumulate(scene, &camera, size, 1), &truth);
}

/// An area light with penumbras, and the lamp itself, against brute-force integration on the CPU.
#[test]
fn the_cornell_box() {
    let scene = builtin("cornell");
    let camera = scene.default_camera();
    let size = [32, 32];
    // One point on each of the lamp's triangles for every point of the pixel.
    let light = DirectLight::new(&scene, Quality { emitter: 1, ..Quality::default() }).unwrap();
    let truth = pixel_means(&camera, size, |eye, direction, shift| light.radiance(eye, direction, shift));
    check("cornell", &accumulate(scene.clone(), &camera, size, 4), &to_blocks(&truth, size, 4));
}
