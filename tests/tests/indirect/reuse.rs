//! Reuse of bounces in whole frames: the mean of independent frames, block by block, is that without reuse and that of the reference.

use crate::common::{params, session};
use pt_app::session::Session;
use pt_core::test_support::TestDevice;
use pt_core::trace::TraceBackend;
use pt_reference::{Progressive, ReferenceParams};
use pt_scene::gpu::camera_record;
use pt_shaders::channels::{COLOR_LF_SH, FLAT_COLOR};
use pt_shaders::records::FrameRecord;
use pt_tests::{Frames, builtin};

const SIZE: [u32; 2] = [48, 32];
/// Side of a block, pixels.
const BLOCK: usize = 8;
const RUNS: u32 = 64;

/// Sums of values over blocks of the flat frame.
fn blocks(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let (width, height) = (SIZE[0] as usize, SIZE[1] as usize);
    let columns = width / BLOCK;
    let mut sums = vec![0.0; columns * (height / BLOCK)];
    for (i, value) in values.enumerate() {
        sums[i / width / BLOCK * columns + i % width / BLOCK] += value;
    }
    sums
}

/// What frames with random numbers of their own hold.
struct Runs {
    /// Of each frame: sums of the channels of the picture, over blocks.
    blocks: Vec<Vec<f64>>,
    /// Variance of the raw indirect diffuse light of a texel over its squared mean; the median of the texels, as a few have fireflies.
    noise: f64,
}

impl Runs {
    /// The last of `frames` frames that begin without history.
    fn of(scene: &str, sets: &[&str], frames: u32) -> Self {
        let scene = builtin(scene);
        let camera = scene.default_camera();
        let backend = TraceBackend::Compute;
        let mut rig = Frames::with_params(scene, &camera, backend, SIZE, 0, false, params(sets));
        let (mut sums, mut squares, mut all) = (vec![], vec![], vec![]);
        for run in 0..RUNS {
            rig.restart(100 + run);
            (0..frames).for_each(|_| rig.render(0.0));
            let pixels = rig.image(FLAT_COLOR).pixels;
            all.push(blocks(pixels.iter().map(|p| p.iter().map(|&v| f64::from(v)).sum())));
            let luma: Vec<f64> = rig.floats(COLOR_LF_SH).chunks_exact(4).map(|t| t[3].into()).collect();
            sums.resize(luma.len(), 0.0);
            squares.resize(luma.len(), 0.0);
            for (i, v) in luma.iter().enumerate() {
                sums[i] += v;
                squares[i] += v * v;
            }
        }
        rig.finish();
        let n = f64::from(RUNS);
        let noise = |(sum, square): (&f64, &f64)| square / n / (sum / n).powi(2) - 1.0;
        let lit = |(sum, _): &(&f64, &f64)| **sum > 0.0;
        let mut noise: Vec<f64> = sums.iter().zip(&squares).filter(lit).map(noise).collect();
        noise.sort_by(f64::total_cmp);
        Self { blocks: all, noise: noise[noise.len() / 2] }
    }

    /// Mean and standard error of a value of each run.
    fn mean(values: impl Iterator<Item = f64>) -> (f64, f64) {
        let values: Vec<f64> = values.collect();
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean, (variance / n).sqrt())
    }

    /// Differences from `other` with the same random numbers, by blocks, in standard errors; and of the whole picture, over its light.
    fn against(&self, other: &Self) -> (Vec<f64>, f64) {
        let pairs = || self.blocks.iter().zip(&other.blocks);
        let deviation = |b: usize| {
            let (mean, error) = Self::mean(pairs().map(|(x, y)| x[b] - y[b]));
            mean / error.max(1e-12)
        };
        let sum = |runs: &Self| runs.blocks.iter().flatten().sum::<f64>();
        ((0..self.blocks[0].len()).map(deviation).collect(), sum(self) / sum(other) - 1.0)
    }

    /// Differences from the truth, in standard errors of both.
    fn against_truth(&self, truth: &[(f64, f64)]) -> Vec<f64> {
        let deviation = |(b, (mean, error)): (usize, &(f64, f64))| {
            let own = Self::mean(self.blocks.iter().map(|run| run[b]));
            // The first surface has no lobe narrower than 0.03, and normals of 16 bits.
            ((own.0 - mean).abs() - 0.005 * mean).max(0.0) / own.1.hypot(*error)
        };
        truth.iter().enumerate().map(deviation).collect()
    }
}

/// Means and standard errors of the blocks of the reference with paths of one bounce.
fn truth(scene: &str, spp: u32) -> Vec<(f64, f64)> {
    let device = TestDevice::open();
    let scene = builtin(scene);
    let record = camera_record(&scene.default_camera(), SIZE);
    let mut session = session(&device, &scene);
    let frame = FrameRecord::new(record, record, SIZE, 0, 99);
    let params = ReferenceParams { max_bounces: Some(1), spp, ..ReferenceParams::default() };
    let Session { device, scene, gpu, lights, .. } = &mut session;
    params.prepare_lights(device, scene, gpu, lights).unwrap();
    let mut render = Progressive::new(device, gpu, lights, frame, params, None, 0).unwrap();
    while render.next_sample() < spp {
        render.step(scene, gpu, lights, spp).unwrap();
    }
    let pixels = render.state().unwrap().estimate(spp).pixels;
    let means = blocks(pixels.iter().map(|p| f64::from(p.mean.element_sum())));
    // The channels of a pixel are not independent: their errors add up at most.
    let variances = blocks(pixels.iter().map(|p| f64::from(p.variance.map(f32::sqrt).element_sum()).powi(2)));
    means.into_iter().zip(variances.into_iter().map(f64::sqrt)).collect()
}

fn largest(deviations: &[f64]) -> f64 {
    deviations.iter().fold(0.0, |most, d| d.abs().max(most))
}

/// With `settings` beside those of all cases here.
fn reused(scene: &str, settings: &[&str], frames: u32) -> Runs {
    let all = ["indirect.reuse=restir-gi", "indirect.restir_radius=8", "indirect.restir_spatial=4"];
    Runs::of(scene, &[&all[..], settings].concat(), frames)
}

fn assert_unbiased(scene: &str) {
    let truth = truth(scene, 512);
    let none = Runs::of(scene, &[], 1);
    let neighbours = reused(scene, &["indirect.restir_history=0"], 1);
    let (deviations, energy) = neighbours.against(&none);
    let from_truth = neighbours.against_truth(&truth);
    println!(
        "{scene}: energy {energy:+.5}, largest deviation of {} blocks {:.1} from none, {:.1} from the reference (none {:.1}); noise {:.3} of {:.3}",
        deviations.len(),
        largest(&deviations),
        largest(&from_truth),
        largest(&none.against_truth(&truth)),
        neighbours.noise,
        none.noise
    );
    assert!(largest(&deviations) < 4.0, "{deviations:.1?}");
    assert!(largest(&from_truth) < 4.0, "{from_truth:.1?}");
    assert!(neighbours.noise < 0.95 * none.noise, "{} of {}", neighbours.noise, none.noise);
}

#[test]
fn reused_bounces_of_cornell_have_the_mean_of_the_reference() {
    assert_unbiased("cornell");
}

#[test]
fn reused_bounces_of_the_gallery_have_the_mean_of_the_reference() {
    assert_unbiased("gallery");
}

/// The past of a scene that stands still brings no bias. Without rays between surfaces and points there is some, of which frames with the same paths say
/// how much.
fn assert_past(scene: &str) {
    let frames = 6;
    let none = Runs::of(scene, &[], frames);
    let unbiased = reused(scene, &[], frames);
    let cheap = reused(scene, &["indirect.restir_visibility=none"], frames);
    let (deviations, energy) = unbiased.against(&none);
    let (bias, share) = cheap.against(&unbiased);
    println!(
        "{scene}: energy {energy:+.5}, largest deviation from none {:.1}; without rays {share:+.5}, {:.1} from with; noise {:.3}, {:.3} without rays, none {:.3}",
        largest(&deviations),
        largest(&bias),
        unbiased.noise,
        cheap.noise,
        none.noise
    );
    assert!(largest(&deviations) < 4.0, "{deviations:.1?}");
    // It is said to be biased, and it would be a mistake if it were by much.
    assert!(share.abs() < 0.01, "{share} {bias:.1?}");
    assert!(unbiased.noise < 0.6 * none.noise && cheap.noise < 0.6 * none.noise);
}

#[test]
fn the_past_of_reused_bounces_keeps_the_mean_of_cornell() {
    assert_past("cornell");
}

#[test]
fn the_past_of_reused_bounces_keeps_the_mean_of_the_gallery() {
    assert_past("gallery");
}
