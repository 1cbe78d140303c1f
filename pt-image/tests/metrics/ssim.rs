//! Structural similarity against closed forms and a plain oracle.

use proptest::prelude::*;
use pt_core::rng::random4;
use pt_image::image_file::{LinearImage, srgb_decode, srgb_encode};
use pt_image::metrics::{Metric, SSIM_K1, SSIM_K2};

use super::{DISPLAY, SCENE, close, flat, image, measure};

const C1: f64 = 1e-4;
const C2: f64 = 9e-4;

/// A display image whose codes are these.
fn of_codes(width: u32, codes: &[[f32; 3]]) -> LinearImage {
    image(width, DISPLAY, codes.iter().map(|pixel| pixel.map(srgb_decode)).collect())
}

fn noise(width: u32, height: u32, seed: u32) -> Vec<[f32; 3]> {
    let pixel = |index| random4([index % width, index / width], 0, 0, seed);
    (0..width * height).map(pixel).map(|[r, g, b, _]| [r, g, b]).collect()
}

/// Equation 13 with the 121 weights of the window written out.
fn oracle(a: &LinearImage, b: &LinearImage) -> Vec<f64> {
    let luma = |image: &LinearImage| -> Vec<f64> {
        let code = |value: f32| f64::from(srgb_encode(value));
        image.pixels.iter().map(|p| 0.2126 * code(p[0]) + 0.7152 * code(p[1]) + 0.0722 * code(p[2])).collect()
    };
    let (luma_a, luma_b) = (luma(a), luma(b));
    let (width, height) = (a.width as i32, a.height as i32);
    let similarity = |x: i32, y: i32| {
        let mut window = Vec::new();
        for dy in -5..=5 {
            for dx in -5..=5 {
                let weight = (-f64::from(dx * dx + dy * dy) / (2.0 * 1.5 * 1.5)).exp();
                let at = (y + dy).clamp(0, height - 1) * width + (x + dx).clamp(0, width - 1);
                window.push((weight, luma_a[at as usize], luma_b[at as usize]));
            }
        }
        let total: f64 = window.iter().map(|(weight, ..)| weight).sum();
        let mean = |of: &dyn Fn(f64, f64) -> f64| {
            window.iter().map(|&(weight, a, b)| weight * of(a, b)).sum::<f64>() / total
        };
        let (mean_a, mean_b) = (mean(&|a, _| a), mean(&|_, b| b));
        let variance_a = mean(&|a, _| (a - mean_a).powi(2));
        let variance_b = mean(&|_, b| (b - mean_b).powi(2));
        let covariance = mean(&|a, b| (a - mean_a) * (b - mean_b));
        (2.0 * mean_a * mean_b + C1) * (2.0 * covariance + C2)
            / ((mean_a.powi(2) + mean_b.powi(2) + C1) * (variance_a + variance_b + C2))
    };
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| similarity(x, y)).collect()
}

#[test]
fn ssim_is_equation_13() {
    for (width, height) in [(1, 1), (3, 2), (1, 20), (24, 17)] {
        let (a, b) = (noise(width, height, 1), noise(width, height, 2));
        let mixed: Vec<_> =
            a.iter().zip(&b).map(|(a, b)| [0, 1, 2].map(|c| 0.8 * a[c] + 0.2 * b[c])).collect();
        for b in [&b, &mixed] {
            let (a, b) = (of_codes(width, &a), of_codes(width, b));
            let found = measure(Metric::Ssim, &a, &b);
            let expected = oracle(&a, &b);
            close(found.value, expected.iter().sum::<f64>() / expected.len() as f64);
            for (error, expected) in found.map.iter().zip(&expected) {
                close((*error).into(), 1.0 - expected);
            }
        }
    }
}

/// Where the window lies inside, the values are those of scikit-image 0.26 (`structural_similarity` with Gaussian weights of
/// sigma 1.5, population covariance, range 1), which drops the border.
#[test]
fn ssim_away_from_the_border_is_that_of_scikit_image() {
    let (width, height) = (40, 32);
    let codes = |of: fn(u32, u32) -> f32| {
        let pixels: Vec<_> = (0..width * height).map(|i| [of(i % width, i / width); 3]).collect();
        of_codes(width, &pixels)
    };
    let a = codes(|x, y| ((7 * x + 13 * y + x * y) % 17) as f32 / 16.0);
    let b = codes(|x, y| {
        ((7 * x + 13 * y + x * y) % 17) as f32 / 16.0 * 0.8 + ((5 * x + 3 * y) % 11) as f32 / 50.0
    });
    let map = measure(Metric::Ssim, &a, &b).map;
    let value = |x: u32, y: u32| 1.0 - f64::from(map[(y * width + x) as usize]);
    let inside = (5..height - 5).flat_map(|y| (5..width - 5).map(move |x| (x, y)));
    let mean = inside.map(|(x, y)| value(x, y)).sum::<f64>() / f64::from((width - 10) * (height - 10));
    for (found, expected) in
        [(mean, 0.952_496_55), (value(20, 16), 0.934_802_16), (value(5, 5), 0.965_219_02)]
    {
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
    }
}

#[test]
fn ssim_of_flat_images_compares_their_luminance() {
    let (a, b) = (of_codes(4, &[[0.6; 3]; 12]), of_codes(4, &[[0.3; 3]; 12]));
    close(measure(Metric::Ssim, &a, &b).value, (2.0 * 0.18 + C1) / (0.36 + 0.09 + C1));
    // Red alone against black: luma 0.2126.
    let (red, black) = (of_codes(4, &[[1.0, 0.0, 0.0]; 12]), of_codes(4, &[[0.0; 3]; 12]));
    close(measure(Metric::Ssim, &red, &black).value, C1 / (0.2126 * 0.2126 + C1));
    assert_eq!((SSIM_K1 * SSIM_K1, SSIM_K2 * SSIM_K2), (C1, C2));
}

/// A negative of a picture has its structure with the opposite sign.
#[test]
fn ssim_of_a_negative_is_negative() {
    let codes = noise(24, 17, 5);
    let negative: Vec<_> = codes.iter().map(|pixel| pixel.map(|code| 1.0 - code)).collect();
    let found = measure(Metric::Ssim, &of_codes(24, &codes), &of_codes(24, &negative)).value;
    assert!((-1.0..-0.8).contains(&found), "{found}");
}

#[test]
fn ssim_tells_its_constants() {
    let formula = Metric::Ssim.formula();
    assert!(formula.contains("K1 = 0.01, K2 = 0.03") && formula.contains("borders"), "{formula}");
}

/// The display transform of scenes is exposed by the reference: twice the light is darker or brighter, but of the same
/// structure.
#[test]
fn ssim_of_scenes_looks_at_display_values() {
    let (a, b) = (flat(SCENE, [2.0; 3]), flat(SCENE, [1.0; 3]));
    let code = |exposed: f32| f64::from(srgb_encode(exposed / (1.0 + exposed)));
    let (bright, dark) = (code(0.36), code(0.18));
    close(
        measure(Metric::Ssim, &a, &b).value,
        (2.0 * bright * dark + C1) / (bright.powi(2) + dark.powi(2) + C1),
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn ssim_of_display_images_is_symmetric(seed in 0u32..1000) {
        let (a, b) = (of_codes(13, &noise(13, 12, seed)), of_codes(13, &noise(13, 12, seed + 1000)));
        let (found, swapped) = (measure(Metric::Ssim, &a, &b), measure(Metric::Ssim, &b, &a));
        prop_assert_eq!(&found, &swapped);
        prop_assert!(found.map.iter().all(|error| (0.0..=2.0).contains(error)));
        prop_assert_eq!(measure(Metric::Ssim, &a, &a).value, 1.0);
    }
}
