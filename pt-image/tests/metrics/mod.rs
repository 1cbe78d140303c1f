//! Metrics against hand-computed values and the properties that define them.

mod flip;
mod flip_oracle;
mod ssim;
mod z_test;

use proptest::prelude::*;
use pt_image::image_file::{ImageState, LinearImage, srgb_encode};
use pt_image::metrics::{
    Measurement, Metric, MetricError, PSNR_PEAK, RELMSE_EPSILON, SequenceMetric, compare, display_values,
    non_finite_pixels,
};

fn image(width: u32, state: ImageState, pixels: Vec<[f32; 3]>) -> LinearImage {
    LinearImage { width, height: pixels.len() as u32 / width, pixels, state }
}

fn flat(state: ImageState, value: [f32; 3]) -> LinearImage {
    image(16, state, vec![value; 256])
}

fn measure(metric: Metric, a: &LinearImage, b: &LinearImage) -> Measurement {
    compare(a, b, &[metric]).unwrap().remove(0)
}

fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-6 * expected.abs().max(1.0), "{found} is not {expected}");
}

const SCENE: ImageState = ImageState::SceneReferred;
const DISPLAY: ImageState = ImageState::DisplayReferred;

/// Two pixels. Errors of the first: 1, 0, 2; of the second: 0, 0, 0.
fn pair() -> (LinearImage, LinearImage) {
    let a = image(2, SCENE, vec![[2.0, 1.0, 3.0], [4.0, 4.0, 4.0]]);
    let b = image(2, SCENE, vec![[1.0, 1.0, 1.0], [4.0, 4.0, 4.0]]);
    (a, b)
}

#[test]
fn mse_by_hand() {
    let (a, b) = pair();
    let found = measure(Metric::Mse, &a, &b);
    // Per pixel (1 + 0 + 4) / 3 and 0: mean 5/6, both half a difference away from it.
    close(found.value, 5.0 / 6.0);
    close(found.spread, 5.0 / 6.0);
    close(found.map[0].into(), 5.0 / 3.0);
    close(found.map[1].into(), 0.0);
}

#[test]
fn relmse_by_hand_and_against_the_reference_only() {
    let (a, b) = pair();
    close(measure(Metric::RelMse, &a, &b).value, 5.0 / 1.01 / 6.0);
    let swapped = (1.0 / (4.0 + RELMSE_EPSILON) + 4.0 / (9.0 + RELMSE_EPSILON)) / 6.0;
    close(measure(Metric::RelMse, &b, &a).value, swapped);
    assert!(Metric::RelMse.formula().contains("epsilon = 0.01"));
    assert_eq!(Metric::RelMse.epsilon(), Some(0.01));
    // A black reference weighs by epsilon alone.
    let black = flat(SCENE, [0.0; 3]);
    close(measure(Metric::RelMse, &flat(SCENE, [0.1; 3]), &black).value, 1.0);
}

#[test]
fn psnr_by_hand_on_display_codes() {
    // Codes 0.5 and 0.6 everywhere: MSE 0.01, that is 20 dB.
    let level = |code: f32| pt_image::image_file::srgb_decode(code);
    let (a, b) = (flat(DISPLAY, [level(0.6); 3]), flat(DISPLAY, [level(0.5); 3]));
    let found = measure(Metric::Psnr, &a, &b);
    assert!((found.value - 20.0).abs() < 1e-4, "{}", found.value);
    assert!(found.spread.abs() < 1e-3, "no spread among equal pixels: {}", found.spread);
    assert_eq!(PSNR_PEAK, 1.0);
    // Half of the pixels off by 0.1: MSE 0.005, per-pixel deviation 0.005, so 10/ln 10 decibels to first order.
    let mut half = b.clone();
    half.pixels[..128].fill([level(0.6); 3]);
    let found = measure(Metric::Psnr, &half, &b);
    assert!((found.value - 23.0103).abs() < 1e-3, "{}", found.value);
    assert!((found.spread - 4.34294).abs() < 1e-3, "{}", found.spread);
}

#[test]
fn energy_by_hand() {
    let (a, b) = pair();
    // Means over channels: a 2 and 4, b 1 and 4.
    let found = measure(Metric::Energy, &a, &b);
    close(found.value, 6.0 / 5.0);
    // Residuals (2 - 1.2) / 2.5 and (4 - 4.8) / 2.5.
    close(found.spread, 0.32);
    close(found.map[0].into(), 0.4);
    let (black, grey) = (flat(SCENE, [0.0; 3]), flat(SCENE, [0.5; 3]));
    assert_eq!(measure(Metric::Energy, &black, &black).value, 1.0);
    assert_eq!(measure(Metric::Energy, &grey, &black).value, f64::INFINITY);
    assert_eq!(measure(Metric::Energy, &black, &grey).value, 0.0);
}

#[test]
fn scene_values_are_exposed_by_the_reference_and_compressed() {
    // One grey level: the exposure brings it to 0.18, compression to 0.18 / 1.18.
    let (a, b) = (flat(SCENE, [14.0; 3]), flat(SCENE, [7.0; 3]));
    let (codes_a, codes_b) = display_values(&a, &b);
    let code = |exposed: f32| srgb_encode(exposed / (1.0 + exposed));
    assert!((codes_b[0][0] - code(0.18)).abs() < 1e-6);
    assert!((codes_a[0][0] - code(0.36)).abs() < 1e-6, "twice the light stays twice the light");
    // A black half of the frame does not change the exposure.
    let mut framed = b.clone();
    framed.pixels[..128].fill([0.0; 3]);
    assert_eq!(display_values(&framed, &framed).1[200], codes_b[200]);
    // Display-referred images keep their codes.
    let display = flat(DISPLAY, [0.5; 3]);
    assert!((display_values(&display, &display).0[0][1] - srgb_encode(0.5)).abs() < 1e-7);
    assert_eq!(display_values(&display, &b).1[0], codes_b[0]);
}

#[test]
fn sizes_must_match() {
    let (a, _) = pair();
    let b = image(1, SCENE, a.pixels.clone());
    let error = compare(&a, &b, &Metric::OF_IMAGES).unwrap_err();
    assert_eq!(error.to_string(), "the images differ in size: 2x1 and 1x2");
}

#[test]
fn pixels_that_are_not_finite_are_counted() {
    let (mut a, mut b) = pair();
    a.pixels[0] = [f32::NAN, f32::NAN, 1.0];
    a.pixels[1][2] = f32::NEG_INFINITY;
    b.pixels[1][0] = f32::INFINITY;
    assert_eq!(non_finite_pixels(&a), 2);
    for metric in Metric::ALL {
        let error = compare(&a, &b, &[metric]).unwrap_err();
        assert_eq!(error, MetricError::NonFinite { a: 2, b: 1, pixels: 2 });
        assert!(error.to_string().contains("2 pixels of the image and 1 of the reference"), "{error}");
    }
}

#[test]
fn names_parse_back() {
    for metric in Metric::ALL.map(SequenceMetric::Image).into_iter().chain(SequenceMetric::TEMPORAL) {
        assert_eq!(metric.name().parse(), Ok(metric));
    }
    let error = "rmse".parse::<SequenceMetric>().unwrap_err();
    assert_eq!(
        error.to_string(),
        "unknown metric \"rmse\", known: relmse, mse, psnr, ssim, flip, hdr-flip, energy, detail, z-test, temporal_pixel, temporal_block"
    );
}

/// Negative radiance (a filter's ringing), black frames and the smallest image have values, not errors.
#[test]
fn odd_images_have_a_defined_value() {
    let ringing = image(1, SCENE, vec![[-1.0, 0.5, 2.0]]);
    let black = image(1, SCENE, vec![[0.0; 3]]);
    let huge = image(1, SCENE, vec![[f32::MAX; 3]]);
    let all = [&ringing, &black, &huge];
    for (a, b) in all.iter().flat_map(|a| all.iter().map(move |b| (*a, *b))) {
        for found in compare(a, b, &Metric::OF_IMAGES).unwrap() {
            assert!(
                !found.value.is_nan() && found.map.iter().all(|value| !value.is_nan()),
                "{found:?} {a:?} {b:?}"
            );
        }
    }
    let against_black = compare(&huge, &black, &[Metric::Flip, Metric::HdrFlip, Metric::Ssim]).unwrap();
    assert!(against_black[0].value > 0.9 && against_black[1].value > 0.9 && against_black[2].value < 0.1);
    // What is below black is shown as black.
    let clipped = image(1, SCENE, vec![[0.0, 0.5, 2.0]]);
    for metric in [Metric::Psnr, Metric::Ssim, Metric::Flip, Metric::HdrFlip] {
        let [found, expected] = [&ringing, &clipped].map(|a| measure(metric, a, &clipped).value);
        assert_eq!(found, expected, "{metric:?}");
    }
}

fn any_image() -> impl Strategy<Value = LinearImage> {
    // Ranges whose ends are whole multiples of each other's spacing: proptest's others fail an assertion of theirs for a few seeds.
    let dim = (0.0f32..1.0).prop_map(|x| x + 1e-4);
    let pixel = prop::array::uniform3(prop_oneof![Just(0.0f32), dim, 1.0f32..1e3]);
    prop::collection::vec(pixel, 30).prop_map(|pixels| image(6, SCENE, pixels))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn equal_images_have_no_error(a in any_image()) {
        let found = compare(&a, &a, &Metric::OF_IMAGES).unwrap();
        let values: Vec<_> = found.iter().map(|found| found.value).collect();
        prop_assert_eq!(values, vec![0.0, 0.0, f64::INFINITY, 1.0, 0.0, 0.0, 1.0, 1.0]);
        prop_assert!(found.iter().all(|found| found.spread == 0.0));
    }

    #[test]
    fn symmetry_where_it_holds(a in any_image(), b in any_image()) {
        prop_assert_eq!(measure(Metric::Mse, &a, &b).value, measure(Metric::Mse, &b, &a).value);
        let product = measure(Metric::Energy, &a, &b).value * measure(Metric::Energy, &b, &a).value;
        prop_assert!((product - 1.0).abs() < 1e-9);
    }

    #[test]
    fn values_are_in_range_and_repeat_exactly(a in any_image(), b in any_image()) {
        let first = compare(&a, &b, &Metric::OF_IMAGES).unwrap();
        prop_assert_eq!(&first, &compare(&a, &b, &Metric::OF_IMAGES).unwrap());
        for found in &first {
            let range = match found.metric {
                Metric::Flip | Metric::HdrFlip => 0.0..=1.0,
                Metric::Ssim => -1.0..=1.0,
                _ => f64::MIN..=f64::INFINITY,
            };
            prop_assert!(range.contains(&found.value), "{:?}", found.metric);
            prop_assert!(found.spread >= 0.0 && found.map.len() == a.pixels.len());
        }
    }
}
