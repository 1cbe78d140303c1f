//! How noisy the frame is with each source of random numbers, as the table of pt-gbuffer's README:
//! `cargo run --release -p pt-app --example random_sources`.
//!
//! Error: mean squared error of x / (1 + x), x = radiance, per channel, against the mean of many frames of white noise; mean over the
//! seeds. The curve bounds the weight of fireflies, which decide an error in radiance alone. Of one frame it is taken after a 5x5 box blur
//! of both pictures, of 16 accumulated frames as they are.

use anyhow::Result;
use pt_app::args::{CameraArgs, DeviceArgs};
use pt_app::frame::FullFrame;
use pt_app::params::FrameParams;
use pt_app::session::Session;
use pt_core::Recorder;
use pt_core::random::RandomSource;
use pt_core::trace::TraceBackend;
use pt_denoise::Denoiser;
use pt_image::image_file::{ImageState, LinearImage};
use pt_import::LoadOptions;
use pt_shaders::NamedEnum;

const SCENES: [&str; 2] = ["cornell", "gallery"];
const SIZE: [u32; 2] = [128, 96];
const SEEDS: u32 = 32;
const TRUTH_FRAMES: u32 = 4096;
const FRAMES: u32 = 16;
/// Pixels on each side of the blur's centre.
const RADIUS: usize = 2;

/// The mean of `frames` frames.
fn render(session: &mut Session, source: RandomSource, seed: u32, frames: u32) -> Result<LinearImage> {
    let mut params = FrameParams::default();
    params.gbuffer.random = source;
    params.denoise.variant = Denoiser::Off;
    let mut full = FullFrame::new(session, SIZE, true, &params)?;
    let mut recorder = Recorder::new(&session.device)?;
    for _ in 0..frames {
        let mut frame = recorder.begin()?;
        session.update(&mut frame, 0.0, 0.0)?;
        full.record(&mut frame, &session.gpu, &session.camera, seed, None, &params)?;
        frame.submit()?;
    }
    recorder.finish()?;
    let pixels = full.radiance().read_f32()?.chunks_exact(4).map(|p| [p[0], p[1], p[2]]).collect();
    Ok(LinearImage { width: SIZE[0], height: SIZE[1], pixels, state: ImageState::SceneReferred })
}

/// Box filter; the margin that it does not fill is left out.
fn blur(image: &LinearImage) -> LinearImage {
    let [width, height] = [image.width as usize, image.height as usize];
    let side = 2 * RADIUS + 1;
    let mut pixels = Vec::new();
    for y in RADIUS..height - RADIUS {
        for x in RADIUS..width - RADIUS {
            let window = (0..side * side)
                .map(|i| image.pixels[(y + i / side - RADIUS) * width + x + i % side - RADIUS]);
            let sum = window.fold([0.0; 3], |sum, p| [0, 1, 2].map(|c| sum[c] + p[c]));
            pixels.push(sum.map(|v| v / (side * side) as f32));
        }
    }
    let margin = 2 * RADIUS as u32;
    LinearImage { width: image.width - margin, height: image.height - margin, pixels, state: image.state }
}

fn error(image: &LinearImage, truth: &LinearImage) -> f64 {
    let curve = |x: f32| f64::from(x / (1.0 + x));
    let values = image.pixels.iter().flatten().zip(truth.pixels.iter().flatten());
    let sum: f64 = values.map(|(&a, &b)| (curve(a) - curve(b)).powi(2)).sum();
    sum / (3 * truth.pixels.len()) as f64
}

fn main() -> Result<()> {
    println!("| scene | `random` | 1 frame, 5x5 blur | of white | 16 frames | of white |");
    println!("| --- | --- | --- | --- | --- | --- |");
    for name in SCENES {
        let scene = pt_import::open(name, &LoadOptions::default())?;
        let device = DeviceArgs { backend: TraceBackend::Compute, device: None, validation: false };
        let mut session = Session::open(&device, &CameraArgs::default(), scene)?;
        let truth = render(&mut session, RandomSource::White, SEEDS, TRUTH_FRAMES)?;
        let blurred_truth = blur(&truth);
        let mut white = None;
        for source in RandomSource::VALUES.iter().copied() {
            let mut errors = [0.0; 2];
            for seed in 0..SEEDS {
                let one = blur(&render(&mut session, source, seed, 1)?);
                errors[0] += error(&one, &blurred_truth) / f64::from(SEEDS);
                let many = render(&mut session, source, seed, FRAMES)?;
                errors[1] += error(&many, &truth) / f64::from(SEEDS);
            }
            let [white_blurred, white_mean] = *white.get_or_insert(errors);
            println!(
                "| {name} | {} | {:.2e} | {:.2} | {:.2e} | {:.2} |",
                serde_json::to_value(source)?.as_str().unwrap_or_default(),
                errors[0],
                errors[0] / white_blurred,
                errors[1],
                errors[1] / white_mean,
            );
        }
    }
    Ok(())
}
