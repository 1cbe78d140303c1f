//! Structural similarity (Wang et al. 2004, "Image Quality Assessment: From Error Visibility to Structural Similarity").

use rayon::prelude::*;

use super::convolve::Plane;
use super::display::luma;

/// K1 of Wang et al. 2004; values are display values, so the range L is 1.
pub const SSIM_K1: f64 = 0.01;

/// K2 of Wang et al. 2004.
pub const SSIM_K2: f64 = 0.03;

/// Pixels to each side of the centre of the window.
const RADIUS: i32 = 5;

/// Standard deviation of the Gaussian window, pixels.
const SIGMA: f64 = 1.5;

/// Structural similarity of each pixel (eq. 13), -1 to 1, of the luma of display values. Beyond the border the nearest
/// pixel repeats, so that images smaller than the window have a value too.
pub(super) fn ssim(width: usize, a: &[[f32; 3]], b: &[[f32; 3]]) -> Vec<f64> {
    let window = window();
    let (a, b) = (Plane::from_pixels(width, a, luma), Plane::from_pixels(width, b, luma));
    let smooth = |plane: &Plane<f64>| plane.convolve(&window, &window).values;
    let product = |a: &Plane<f64>, b: &Plane<f64>| {
        let values = a.values.par_iter().zip(&b.values).map(|(a, b)| a * b).collect();
        smooth(&Plane { width, values })
    };
    let means = smooth(&a).into_par_iter().zip(smooth(&b));
    let squares = product(&a, &a).into_par_iter().zip(product(&b, &b)).zip(product(&a, &b));
    means.zip(squares).map(|(means, ((aa, bb), ab))| similarity(means, aa, bb, ab)).collect()
}

/// Equation 13 from the windowed means of a, b, a^2, b^2 and ab.
fn similarity((mean_a, mean_b): (f64, f64), aa: f64, bb: f64, ab: f64) -> f64 {
    let (c1, c2) = (SSIM_K1 * SSIM_K1, SSIM_K2 * SSIM_K2);
    let (variance_a, variance_b) = (aa - mean_a * mean_a, bb - mean_b * mean_b);
    let covariance = ab - mean_a * mean_b;
    (2.0 * mean_a * mean_b + c1) * (2.0 * covariance + c2)
        / ((mean_a * mean_a + mean_b * mean_b + c1) * (variance_a + variance_b + c2))
}

/// Gaussian of unit sum, 11 samples.
fn window() -> Vec<f64> {
    let weights = (-RADIUS..=RADIUS).map(|x| (-f64::from(x * x) / (2.0 * SIGMA * SIGMA)).exp());
    let total: f64 = weights.clone().sum();
    weights.map(|weight| weight / total).collect()
}
