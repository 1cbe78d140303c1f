//! Metrics against hand-computed values and the properties that define them.

use proptest::prelude::*;
use pt_core::image_file::{ImageState, LinearImage, srgb_encode};
use pt_core::metrics::{
    Measurement, Metric, MetricError, PSNR_PEAK, RELMSE_EPSILON, compare, display_values, non_finite_pixels,
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
    let level = |code: f32| pt_core::image_file::srgb_decode(code);
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

/// Hunt-adjusted L*a*b* of linear RGB as defined in section 4.1 of Andersson et al. 2020, "FLIP: A difference
/// evaluator for alternating images" (white point D65).
fn hunt_lab(rgb: [f64; 3]) -> [f64; 3] {
    let rows = [
        [10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0],
        [2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0],
        [1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0],
    ];
    let f = |row: [f64; 3]| {
        let white: f64 = row.iter().sum();
        let t = row.iter().zip(rgb).map(|(m, c)| m * c).sum::<f64>() / white;
        if t > (6.0f64 / 29.0).powi(3) { t.cbrt() } else { t * (29.0f64 / 6.0).powi(2) / 3.0 + 4.0 / 29.0 }
    };
    let [x, y, z] = rows.map(f);
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// The FLIP colour error of two flat images, which have no features: HyAB distance to the power 0.7, remapped so that
/// 0.4 of the largest (green against blue) becomes 0.95.
fn flat_flip(a: [f64; 3], b: [f64; 3]) -> f64 {
    let hyab = |a: [f64; 3], b: [f64; 3]| {
        let (a, b) = (hunt_lab(a), hunt_lab(b));
        ((a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])).powf(0.7)
    };
    let largest = hyab([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let (knee, value) = (0.4 * largest, hyab(a, b));
    if value < knee { value * 0.95 / knee } else { 0.95 + (value - knee) / (largest - knee) * 0.05 }
}

#[test]
fn flip_of_flat_images_is_the_published_colour_error() {
    for (a, b) in [
        ([1.0, 1.0, 1.0], [0.0, 0.0, 0.0]),
        ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        ([1.0, 1.0, 0.0], [1.0, 1.0, 1.0]),
    ] {
        let found = measure(Metric::Flip, &flat(DISPLAY, a), &flat(DISPLAY, b));
        let expected = flat_flip(a.map(f64::from), b.map(f64::from));
        assert!((found.value - expected).abs() < 2e-3, "{a:?} {b:?}: {} is not {expected}", found.value);
    }
}

#[test]
fn flip_sees_one_bright_pixel_where_it_is() {
    let a = flat(DISPLAY, [0.2; 3]);
    let mut b = a.clone();
    b.pixels[5 * 16 + 9] = [1.0; 3];
    let found = measure(Metric::Flip, &a, &b);
    let brightest = (0..256).max_by(|&i, &j| found.map[i].total_cmp(&found.map[j])).unwrap();
    assert_eq!(brightest, 5 * 16 + 9);
    assert!(found.value > 0.0 && found.value < 0.2, "{}", found.value);
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
    let error = compare(&a, &b, &Metric::ALL).unwrap_err();
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
    for metric in Metric::ALL {
        assert_eq!(metric.name().parse(), Ok(metric));
    }
    let error = "rmse".parse::<Metric>().unwrap_err();
    assert_eq!(error.to_string(), "unknown metric \"rmse\", known: relmse, mse, psnr, flip, energy");
}

fn any_image() -> impl Strategy<Value = LinearImage> {
    let pixel = prop::array::uniform3(prop_oneof![Just(0.0f32), 1e-4f32..1.0, 1.0f32..1e3]);
    prop::collection::vec(pixel, 30).prop_map(|pixels| image(6, SCENE, pixels))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn equal_images_have_no_error(a in any_image()) {
        let found = compare(&a, &a, &Metric::ALL).unwrap();
        let values: Vec<_> = found.iter().map(|found| found.value).collect();
        prop_assert_eq!(values, vec![0.0, 0.0, f64::INFINITY, 0.0, 1.0]);
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
        let first = compare(&a, &b, &Metric::ALL).unwrap();
        prop_assert_eq!(&first, &compare(&a, &b, &Metric::ALL).unwrap());
        let flip = &first[3];
        prop_assert!((0.0..=1.0).contains(&flip.value));
        for found in &first {
            prop_assert!(found.spread >= 0.0 && found.map.len() == a.pixels.len());
        }
    }
}
