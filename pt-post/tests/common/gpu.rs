//! Images in and out of the device, and random pixels.

use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use pt_core::{Device, Frame, Image, Recorder};
use pt_post::oracle;
use pt_shaders::channels::Format;

/// An RGBA32F image with the pixels' colours and one alpha for all.
pub fn upload(device: &Device, image: &oracle::Image, alpha: f32) -> Image {
    upload_as(device, image, alpha, Format::Rgba32F)
}

/// As [`upload`] in another format.
pub fn upload_as(device: &Device, image: &oracle::Image, alpha: f32, format: Format) -> Image {
    let texels: Vec<f32> =
        image.pixels.iter().flat_map(|c| [c[0] as f32, c[1] as f32, c[2] as f32, alpha]).collect();
    let target = Image::new(device, "input", format, image.size).unwrap();
    target.write_f32(&texels).unwrap();
    target
}

/// Red, green and blue of an image.
pub fn download(image: &Image) -> oracle::Image {
    let pixels = image.read_f32().unwrap();
    let pixels = pixels.chunks_exact(4).map(|c| [c[0], c[1], c[2]].map(f64::from)).collect();
    oracle::Image { size: image.extent(), pixels }
}

/// Records and submits one frame; what reads its results waits for it.
pub fn run(device: &Device, record: impl FnOnce(&mut Frame<'_>)) {
    let mut recorder = Recorder::new(device).unwrap();
    let mut frame = recorder.begin().unwrap();
    record(&mut frame);
    frame.submit().unwrap();
}

/// Colours over eight orders of magnitude, the same in every run.
pub fn random_hdr(runner: &mut TestRunner, size: [u32; 2]) -> oracle::Image {
    let value = (-4.0f32..4.0).prop_map(|e| 10f32.powf(e));
    let rgb = (value, 0.0f32..1.0, 0.0f32..1.0).prop_map(|(r, g, b)| [r, g * r, b * r].map(f64::from));
    let count = (size[0] * size[1]) as usize;
    let pixels = prop::collection::vec(rgb, count).new_tree(runner).unwrap().current();
    oracle::Image { size, pixels }
}

/// Values from 0 to 1, rounded to half floats.
pub fn random_codes(runner: &mut TestRunner, size: [u32; 2]) -> oracle::Image {
    let rgb = (0.0f32..1.0, 0.0f32..1.0, 0.0f32..1.0).prop_map(|(r, g, b)| [r, g, b].map(half_rounded));
    let count = (size[0] * size[1]) as usize;
    let pixels = prop::collection::vec(rgb, count).new_tree(runner).unwrap().current();
    oracle::Image { size, pixels }
}

/// To 11 bits, as half floats keep.
pub fn half_rounded(v: f32) -> f64 {
    f64::from((v * 2048.0).round() / 2048.0)
}

/// Largest difference of any channel, relative to the larger of 1 and the value where `relative`.
pub fn largest_difference(a: &oracle::Image, b: &oracle::Image, relative: bool) -> f64 {
    assert_eq!(a.size, b.size);
    let pairs = a.pixels.iter().flatten().zip(b.pixels.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs() / if relative { b.abs().max(1e-6) } else { 1.0 }).fold(0.0, f64::max)
}
