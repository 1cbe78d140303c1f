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
    /// Variance of the raw indirect diffuse light of a texel, over its squared mean; the mean over the texels.
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
        let lit: Vec<f64> = sums
            .iter()
            .zip(&squares)
            .filter(|(sum, _)| **sum > 0.0)
            .map(|(sum, square)| (square / n - (sum / n).powi(2)) / (sum / n).powi(2))
            .collect();
        Self { blocks: all, noise: lit.iter().sum::<f64>() / lit.len() as f64 }
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

const NEIGHBOURS: &[&str] = &[
    "indirect.reuse=restir-gi",
    "indirect.restir_history=0",
    "indirect.restir_radius=8",
    "indirect.restir_spatial=4",
];

fn assert_unbiased(scene: &str) {
    let truth = truth(scene, 512);
    let none = Runs::of(scene, &[], 1);
    let neighbours = Runs::of(scene, NEIGHBOURS, 1);
    let (deviations, energy) = neighbours.against(&none);
    let from_truth = neighbours.against_truth(&truth);
    println!(
        "{scene}: energy {energy:+.5}, largest deviation of {} blocks {:.1} from none, {:.1} from the reference; noise {:.2} of {:.2}",
        deviations.len(),
        largest(&deviations),
        largest(&from_truth),
        neighbours.noise,
        none.noise
    );
    assert!(largest(&deviations) < 4.0, "{deviations:.1?}");
    assert!(largest(&from_truth) < 4.0, "{from_truth:.1?}");
    assert!(neighbours.noise < 0.7 * none.noise, "{} of {}", neighbours.noise, none.noise);
}

#[test]
fn reused_bounces_of_cornell_have_the_mean_of_the_reference() {
    assert_unbiased("cornell");
}

#[test]
fn reused_bounces_of_the_gallery_have_the_mean_of_the_reference() {
    assert_unbiased("gallery");
}
