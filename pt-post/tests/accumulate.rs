//! The running mean: kernel against oracle, oracle against the exact mean.

use pt_core::test_support::TestDevice;
use pt_core::{ChannelImages, FrameSizes, Recorder, StageInputs};
use pt_post::Accumulate;
use pt_post::oracle::RunningMean;
use pt_shaders::channels::{ACCUMULATED, FLAT_COLOR};

const SIZE: [u32; 2] = [7, 3];
const PIXELS: usize = 21;

/// Uniform in [0, 1), a function of its argument alone.
fn random(index: usize) -> f32 {
    let mut h = (index as u32).wrapping_mul(0x9e37_79b9);
    for multiplier in [0x7feb_352d, 0x846c_a68b] {
        h = (h ^ (h >> 16)).wrapping_mul(multiplier);
    }
    (h >> 8) as f32 / (1u32 << 24) as f32
}

/// Mostly a little below 1, rarely far above: what makes an uncompensated fp32 mean drift.
fn skewed(index: usize) -> f32 {
    if random(index) < 1e-3 { 40.0 } else { 0.999 + 0.001 * random(index ^ 0x5555_0000) }
}

/// Runs the kernel over frames of texels; the first frame resets. Returns `accumulated`.
fn run(
    device: &TestDevice,
    images: &mut ChannelImages,
    stage: &Accumulate,
    frames: &[Vec<[f32; 4]>],
) -> Vec<f32> {
    let mut recorder = Recorder::new(device).unwrap();
    for (index, texels) in frames.iter().enumerate() {
        images.current(FLAT_COLOR).write(bytemuck::cast_slice(texels)).unwrap();
        if index == 0 {
            images.reset_history();
        }
        images.begin_frame();
        let mut frame = recorder.begin().unwrap();
        stage.record(&mut frame, &StageInputs::new(images)).unwrap();
        frame.submit().unwrap();
    }
    images.current(ACCUMULATED).read_f32().unwrap()
}

fn setup(device: &TestDevice) -> (ChannelImages, Accumulate) {
    let images = ChannelImages::alone(device, FrameSizes::same(SIZE), &[Accumulate::IO]).unwrap();
    (images, Accumulate::new(device).unwrap())
}

#[test]
fn kernel_agrees_with_the_oracle() {
    let device = TestDevice::open();
    let (mut images, stage) = setup(&device);
    let sample = |frame: usize, pixel: usize, channel: usize| {
        if frame % 7 == 3 && pixel == 5 {
            return [f32::NAN, f32::INFINITY, 1.0][channel];
        }
        skewed((frame * PIXELS + pixel) * 3 + channel) * 10f32.powi(pixel as i32 - 10)
    };
    let frames: Vec<Vec<[f32; 4]>> = (0..200)
        .map(|f| (0..PIXELS).map(|p| [sample(f, p, 0), sample(f, p, 1), sample(f, p, 2), 9.0]).collect())
        .collect();
    let got = run(&device, &mut images, &stage, &frames);
    for pixel in 0..PIXELS {
        let counted = frames.iter().filter(|f| f[pixel][..3].iter().all(|v| v.is_finite()));
        assert_eq!(got[4 * pixel + 3], counted.clone().count() as f32);
        for channel in 0..3 {
            let want = counted.clone().fold(RunningMean::default(), |m, f| m.with(f[pixel][channel])).mean;
            let got = got[4 * pixel + channel];
            // Drivers may divide with an error of 2.5 ulp; one ulp of the mean is what is left of it.
            assert!((got - want).abs() <= 1.2e-7 * want, "pixel {pixel}: {got}, oracle {want}");
        }
    }
}

#[test]
fn reset_forgets_everything() {
    let device = TestDevice::open();
    let (mut images, stage) = setup(&device);
    let frame = |value: f32| vec![[value, value, value, 1.0]; PIXELS];
    run(&device, &mut images, &stage, &[frame(3.0), frame(0.1), frame(7e5)]);
    let got = run(&device, &mut images, &stage, &[frame(0.3), frame(0.5)]);
    let mean = (0.3f32 + 0.5) / 2.0;
    assert!(got.chunks_exact(4).all(|t| t == [mean, mean, mean, 2.0]), "{got:?}");
}

/// 1e5 frames stay within rounding of the exact mean, where a plain fp32 mean is off by far more.
#[test]
fn mean_does_not_drift() {
    let (mut compensated, mut plain, mut sum) = (RunningMean::default(), 0.0f32, 0.0f64);
    for n in 1..=100_000 {
        let x = skewed(n);
        compensated = compensated.with(x);
        plain += (x - plain) / n as f32;
        sum += f64::from(x);
        let mean = sum / n as f64;
        assert!((f64::from(compensated.mean) - mean).abs() <= 1e-7 * mean, "after {n} frames");
    }
    assert_eq!(compensated.count, 1e5);
    let drift = (f64::from(plain) / (sum * 1e-5) - 1.0).abs();
    assert!(drift > 1e-6, "this input is no test: a plain mean is off by {drift:e} only");
}
