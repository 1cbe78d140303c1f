//! Bloom: kernels against oracle, energy, and input that is not finite.

use crate::common::gpu::{download, largest_difference, random_hdr, run, upload};
use proptest::test_runner::TestRunner;
use pt_core::test_support::TestDevice;
use pt_core::{ChannelImages, FrameSizes};
use pt_post::images::BLOOMED;
use pt_post::{Bloom, BloomMix, BloomMode, BloomParams, oracle};

fn bloomed(device: &TestDevice, source: &oracle::Image, params: &BloomParams) -> oracle::Image {
    let image = upload(device, source, 1.0);
    let stages = [Bloom::io(params.mode), BloomMix::IO];
    let images = ChannelImages::alone(device, FrameSizes::same(source.size), &stages).unwrap();
    let (bloom, mix) = (Bloom::new(device).unwrap(), BloomMix::new(device).unwrap());
    run(device, |frame| {
        let bloomed = bloom.record(frame, &images, &image, params).unwrap();
        mix.record(frame, &images, bloomed).unwrap();
    });
    download(images.current(BLOOMED))
}

fn of(mode: BloomMode, intensity: f32) -> BloomParams {
    BloomParams { mode, intensity, ..BloomParams::default() }
}

#[test]
fn kernels_agree_with_the_oracle() {
    let device = TestDevice::open();
    let mut runner = TestRunner::deterministic();
    for size in [[1, 1], [3, 2], [5, 9], [33, 31], [64, 40], [101, 57]] {
        let source = random_hdr(&mut runner, size);
        for mode in [BloomMode::Gaussian, BloomMode::Chain] {
            // Much of it, so that it shows; a wide blur, so that it reaches the borders.
            let params = BloomParams { sigma: 0.2, levels: 4, ..of(mode, 0.7) };
            let difference = largest_difference(
                &bloomed(&device, &source, &params),
                &oracle::bloom(&source, &params),
                true,
            );
            // Half floats between the passes (2^-11 each), and 8 bits of place in the device's bilinear filter, which at a
            // contrast of the neighbours of 1e4 would show more; blurred images have little of it.
            assert!(difference < 8e-3, "{mode:?} {size:?}: {difference}");
        }
    }
}

#[test]
fn constant_images_stay_as_they_are() {
    let device = TestDevice::open();
    let flat = oracle::Image::from_fn([37, 23], |_, _| [0.5, 2.0, 1000.0]);
    for mode in [BloomMode::Gaussian, BloomMode::Chain] {
        let result = bloomed(&device, &flat, &of(mode, 1.0));
        // Four stores as half floats, and at 1000 these are 5e-4 apart: drivers may cut off what is between.
        assert!(largest_difference(&result, &flat, true) <= 4.0 * 5e-4, "{mode:?}");
    }
}

/// The light of a small bright spot in the middle spreads and none is lost or made.
#[test]
fn energy_is_kept() {
    let device = TestDevice::open();
    let spot = oracle::Image::from_fn([128, 128], |x, y| {
        [if (60..68).contains(&x) && (60..68).contains(&y) { 1000.0 } else { 0.0 }; 3]
    });
    let sum = |image: &oracle::Image| image.pixels.iter().map(|c| c[1]).sum::<f64>();
    for mode in [BloomMode::Gaussian, BloomMode::Chain] {
        let params = BloomParams { levels: 4, ..of(mode, 0.3) };
        let result = bloomed(&device, &spot, &params);
        // Half floats round far tails; the Gaussian ends at 4 sigma by definition of its weights.
        assert!((sum(&result) / sum(&spot) - 1.0).abs() < 5e-3, "{mode:?}: {}", sum(&result) / sum(&spot));
        let (centre, near) = (result.at(64, 64)[1], result.at(48, 64)[1]);
        assert!((700.0..900.0).contains(&centre) && near > 0.05, "{mode:?}: {centre}, {near}");
    }
}

#[test]
fn pixels_that_are_not_finite_do_not_spread() {
    let device = TestDevice::open();
    let clean = oracle::Image::from_fn([40, 40], |_, _| [1.0; 3]);
    let mut broken = clean.clone();
    broken.pixels[20 * 40 + 20] = [f64::NAN, 1.0, 1.0];
    broken.pixels[5 * 40 + 7] = [f64::INFINITY; 3];
    broken.pixels[0] = [-3.0; 3];
    broken.pixels[30 * 40 + 3] = [1e30; 3];
    for mode in [BloomMode::Gaussian, BloomMode::Chain] {
        let result = bloomed(&device, &broken, &of(mode, 0.1));
        for (i, c) in result.pixels.iter().enumerate() {
            let is_broken = [20 * 40 + 20, 5 * 40 + 7].contains(&i);
            assert_eq!(c.iter().all(|v| v.is_finite()), !is_broken, "{mode:?} at {i}: {c:?}");
            assert!(is_broken || c.iter().all(|v| *v >= 0.0), "{mode:?} at {i}: {c:?}");
        }
    }
    let black = oracle::Image::from_fn([9, 9], |_, _| [0.0; 3]);
    assert_eq!(bloomed(&device, &black, &of(BloomMode::Chain, 0.5)), black);
}
