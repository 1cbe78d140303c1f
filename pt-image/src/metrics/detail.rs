//! How much detail an image has kept.

use super::{Measurement, Metric};

/// Rec. 709 luminance.
fn luminance(pixel: &[f32; 3]) -> f64 {
    0.2126 * f64::from(pixel[0]) + 0.7152 * f64::from(pixel[1]) + 0.0722 * f64::from(pixel[2])
}

/// Squared gradient of each pixel. Luminance is compressed, so that highlights do not stand for the whole image.
fn gradients(width: usize, pixels: &[[f32; 3]], scale: f64) -> Vec<f64> {
    let value = |pixel: &[f32; 3]| {
        let y = (luminance(pixel) * scale).max(0.0);
        y / (1.0 + y)
    };
    let values: Vec<f64> = pixels.iter().map(value).collect();
    let gradient = |i: usize| {
        let right = if (i + 1).is_multiple_of(width) { 0.0 } else { values[i + 1] - values[i] };
        let below = values.get(i + width).map_or(0.0, |below| below - values[i]);
        right * right + below * below
    };
    (0..values.len()).map(gradient).collect()
}

/// [`Metric::Detail`].
pub(super) fn detail(width: usize, a: &[[f32; 3]], b: &[[f32; 3]]) -> Measurement {
    let mean = b.iter().map(luminance).sum::<f64>() / b.len() as f64;
    let scale = if mean > 0.0 { mean.recip() } else { 1.0 };
    let [of_a, of_b] = [a, b].map(|pixels| gradients(width, pixels, scale));
    let [sum_a, sum_b] = [&of_a, &of_b].map(|terms| terms.iter().sum::<f64>());
    let value = if sum_a == sum_b { 1.0 } else { sum_a / sum_b };
    let n = b.len() as f64;
    // First order: of the quotient of two means.
    let terms: Vec<f64> = of_a.iter().zip(&of_b).map(|(a, b)| (a - value * b) * n / sum_b).collect();
    let spread =
        if sum_b > 0.0 { (terms.iter().map(|term| term * term).sum::<f64>() / n).sqrt() } else { 0.0 };
    let map = of_a.iter().zip(&of_b).map(|(a, b)| (a.sqrt() - b.sqrt()).abs() as f32).collect();
    Measurement { metric: Metric::Detail, value, spread, map, details: Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stripes, and the same after a blur over three pixels: a third of the contrast, a ninth of the energy.
    #[test]
    fn a_blur_takes_detail_away() {
        let image = |contrast: f32| -> Vec<[f32; 3]> {
            (0..64).map(|i| [1.0 + if i % 2 == 0 { contrast } else { -contrast }; 3]).collect()
        };
        let (sharp, blurred) = (image(0.03), image(0.01));
        assert_eq!(detail(8, &sharp, &sharp).value, 1.0);
        let ratio = detail(8, &blurred, &sharp).value;
        assert!((ratio - 1.0 / 9.0).abs() < 1e-3, "{ratio}");
        let flat = vec![[0.0; 3]; 64];
        assert_eq!(detail(8, &flat, &flat).value, 1.0);
        assert_eq!(detail(8, &sharp, &flat).value, f64::INFINITY);
    }
}
