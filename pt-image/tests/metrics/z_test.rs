//! The Z-test of two estimates: by hand, by its significance, and what it refuses.

use pt_core::rng::random4;
use pt_image::image_file::LinearImage;
use pt_image::metrics::{
    Measurement, Metric, MetricError, Variances, Z_TEST_EPSILON, compare, compare_estimates,
};

use super::{SCENE, flat, image};

fn z_test(a: &LinearImage, b: &LinearImage, variances: [&LinearImage; 2]) -> Measurement {
    let [variance_a, variance_b] = variances;
    let variances = Some(Variances { a: variance_a, b: variance_b });
    compare_estimates(a, b, variances, &[Metric::ZTest]).unwrap().remove(0)
}

/// Four pixels are 12 tests of level 1 - 0.99^(1/12) = 0.00083718, two-sided: z = 3.3402.
#[test]
fn z_test_by_hand() {
    // Variance 0.09 + 0.16 in every channel: standard error 0.5.
    let variances = [&image(2, SCENE, vec![[0.09; 3]; 4]), &image(2, SCENE, vec![[0.16; 3]; 4])];
    let b = image(2, SCENE, vec![[1.0; 3]; 4]);
    // z = 0; 3.33; 3.35 in blue alone; -3.35 in red alone.
    let pixels = vec![[1.0; 3], [2.665; 3], [1.0, 2.0, 2.675], [-0.675, 1.0, 1.0]];
    let a = image(2, SCENE, pixels);
    let found = z_test(&a, &b, variances);
    assert_eq!(found.value, 0.5);
    for (z, expected) in found.map.iter().zip([0.0, 3.33, 3.35, 3.35]) {
        assert!((z - expected).abs() < 1e-4, "{z} {expected}");
    }
    assert_eq!(found.details[0].0, "critical_z");
    assert!((found.details[0].1 - 3.3402).abs() < 1e-4, "{:?}", found.details);
    assert!((found.details[1].1 - 0.000_837_18).abs() < 1e-8, "{:?}", found.details);
    // Neither order of the images nor of the variances matters.
    assert_eq!(z_test(&b, &a, variances), found);
    assert_eq!(z_test(&a, &b, [variances[1], variances[0]]), found);
    // Twice the error bars accept all of it.
    let wide = &image(2, SCENE, vec![[0.5; 3]; 4]);
    assert_eq!(z_test(&a, &b, [wide, wide]).value, 1.0);
}

#[test]
fn without_variance_only_rounding_passes() {
    let zero = &flat(SCENE, [0.0; 3]);
    let b = flat(SCENE, [3.0; 3]);
    assert_eq!(z_test(&b, &b, [zero, zero]).value, 1.0);
    assert_eq!(z_test(zero, zero, [zero, zero]).value, 1.0);
    assert_eq!(z_test(&flat(SCENE, [3.000_01; 3]), &b, [zero, zero]).value, 1.0);
    let found = z_test(&flat(SCENE, [3.01; 3]), &b, [zero, zero]);
    assert_eq!(found.value, 0.0);
    // 0.01 over the rounding error of 3.01.
    assert!((f64::from(found.map[0]) * 3.01 * Z_TEST_EPSILON - 0.01).abs() < 1e-6);
}

/// Normal noise of a known standard error round `mean`, on 2x2 pixels.
fn estimate(mean: f32, error: f32, trial: u32, dimension: u32) -> LinearImage {
    let normal = |pixel: u32, channel: u32| {
        let [u, v, ..] = random4([pixel, channel], trial, dimension, 17);
        (-2.0 * (1.0 - u).ln()).sqrt() * (std::f32::consts::TAU * v).cos()
    };
    let pixels = (0..4).map(|pixel| [0, 1, 2].map(|channel| mean + error * normal(pixel, channel))).collect();
    image(2, SCENE, pixels)
}

/// Correct estimates fail anywhere in the image with probability 0.01: 40 of 4000 images, standard deviation 6.3.
#[test]
fn correct_estimates_fail_as_often_as_the_significance_says() {
    let variances = [&image(2, SCENE, vec![[0.04; 3]; 4]), &image(2, SCENE, vec![[0.01; 3]; 4])];
    let failing = |bias: f32| {
        let fails = |&trial: &u32| {
            let (a, b) = (estimate(1.0 + bias, 0.2, trial, 0), estimate(1.0, 0.1, trial, 1));
            z_test(&a, &b, variances).value < 1.0
        };
        (0..4000).filter(fails).count()
    };
    let found = failing(0.0);
    assert!((15..=65).contains(&found), "{found}");
    // Two thirds of a standard error of bias is far outside.
    let biased = failing(0.15);
    assert!(biased > 90, "{biased}");
}

#[test]
fn z_test_refuses_what_it_cannot_use() {
    let (a, b) = (flat(SCENE, [1.0; 3]), flat(SCENE, [2.0; 3]));
    let error = compare(&a, &b, &[Metric::Mse, Metric::ZTest]).unwrap_err();
    assert_eq!(error, MetricError::NoVariance(Metric::ZTest));
    assert_eq!(error.to_string(), "z-test needs the variances of both images (EXR layer \"variance\")");
    let mut bad = flat(SCENE, [0.1; 3]);
    bad.pixels[3][1] = -0.1;
    bad.pixels[4][2] = f32::NAN;
    bad.pixels[5][0] = f32::INFINITY;
    let error = compare_estimates(&a, &b, Some(Variances { a: &a, b: &bad }), &[Metric::ZTest]).unwrap_err();
    assert_eq!(error, MetricError::BadVariance { a: 0, b: 3, pixels: 256 });
    let small = image(2, SCENE, vec![[0.0; 3]; 4]);
    let error =
        compare_estimates(&a, &b, Some(Variances { a: &small, b: &a }), &[Metric::ZTest]).unwrap_err();
    assert_eq!(error, MetricError::Size { a: (16, 16), b: (2, 2) });
}
