//! Pixel by pixel test of two Monte Carlo estimates of the same image, after Subr and Arvo 2007, "Statistical Hypothesis
//! Testing for Assessing Monte Carlo Estimators": the difference is held against its standard error.

use crate::image_file::{ImageState, LayeredImage, LinearImage};

/// Probability that two correct estimates of normal distribution fail in any channel of any pixel.
pub const Z_TEST_SIGNIFICANCE: f64 = 0.01;

/// Relative rounding error that two correct estimates may have without variance: sums in f32, in another order.
pub const Z_TEST_EPSILON: f64 = 1e-5;

/// EXR layer (channels R, G, B) with the variance of the mean that the main layer holds.
pub const VARIANCE_LAYER: &str = "variance";

/// The content of [`VARIANCE_LAYER`]; `None` when the file has no such layer.
pub fn variance_layer(file: &LayeredImage) -> Option<LinearImage> {
    let plane = |channel| Some(file.channel(VARIANCE_LAYER, channel)?.to_f32());
    let (red, green, blue) = (plane("R")?, plane("G")?, plane("B")?);
    let pixels = red.into_iter().zip(green).zip(blue).map(|((r, g), b)| [r, g, b]).collect();
    Some(LinearImage { width: file.width, height: file.height, pixels, state: ImageState::SceneReferred })
}

/// The variances of the mean of an image and of its reference, channel by channel, squared units of the image.
#[derive(Clone, Copy, Debug)]
pub struct Variances<'a> {
    /// Of the image.
    pub a: &'a LinearImage,
    /// Of the reference.
    pub b: &'a LinearImage,
}

/// The level at which every channel of `pixels` pixels is tested, so that all of them together keep
/// [`Z_TEST_SIGNIFICANCE`] (Sidak 1967): 1 - (1 - significance)^(1 / tests).
pub(super) fn level_per_test(pixels: usize) -> f64 {
    -((-Z_TEST_SIGNIFICANCE).ln_1p() / (3 * pixels) as f64).exp_m1()
}

/// The largest |z| of each pixel over its channels.
pub(super) fn z_scores(a: &[[f32; 3]], b: &[[f32; 3]], variances: Variances<'_>) -> Vec<f64> {
    let score = |pixel: usize, channel: usize| {
        let of = |pixels: &[[f32; 3]]| f64::from(pixels[pixel][channel]);
        let (a, b) = (of(a), of(b));
        let rounding = Z_TEST_EPSILON * a.abs().max(b.abs());
        let variance = of(&variances.a.pixels) + of(&variances.b.pixels) + rounding * rounding;
        if a == b { 0.0 } else { (a - b).abs() / variance.sqrt() }
    };
    (0..a.len()).map(|pixel| (0..3).map(|channel| score(pixel, channel)).fold(0.0, f64::max)).collect()
}

/// The z that a standard normal variable exceeds in magnitude with probability `level`, which is below 0.04.
pub(super) fn two_sided_quantile(level: f64) -> f64 {
    let (mut low, mut high) = (2.0, 40.0);
    while high - low > 1e-12 {
        let middle = 0.5 * (low + high);
        if 2.0 * upper_tail(middle) > level { low = middle } else { high = middle }
    }
    high
}

/// P(Z > z) for z >= 2: density times the continued fraction of Mills' ratio (Abramowitz and Stegun 1964, 26.2.14).
fn upper_tail(z: f64) -> f64 {
    let fraction = (1..=200).rev().fold(z, |below, k| z + f64::from(k) / below);
    (-0.5 * z * z).exp() / ((2.0 * std::f64::consts::PI).sqrt() * fraction)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // Abramowitz and Stegun 1964, table 26.5 and 26.6.
        for (level, z) in [
            (0.01, 2.575_829_303_5),
            (0.001, 3.290_526_731_5),
            (1e-4, 3.890_591_886_4),
            (1e-9, 6.109_410_204_9),
        ] {
            assert!((two_sided_quantile(level) - z).abs() < 1e-8, "{level}: {}", two_sided_quantile(level));
        }
    }

    #[test]
    fn levels_of_all_tests_make_the_significance() {
        for pixels in [1, 100, 1920 * 1080] {
            let kept = (1.0 - level_per_test(pixels)).powf((3 * pixels) as f64);
            assert!((1.0 - kept - Z_TEST_SIGNIFICANCE).abs() < 1e-6, "{pixels}");
        }
    }
}
