//! Sub-pixel offsets.

/// Length of the Halton sequence before it repeats.
const PERIOD: u32 = 128;

/// Van der Corput's radical inverse in `base` (Halton 1960).
fn radical_inverse(mut index: u32, base: u32) -> f32 {
    let (mut inverse, mut digit_weight) = (0.0, 1.0 / base as f32);
    while index > 0 {
        inverse += (index % base) as f32 * digit_weight;
        index /= base;
        digit_weight /= base as f32;
    }
    inverse
}

/// Offset of frame `index` in [-0.5, 0.5)^2: Halton sequence in bases 2 and 3.
pub fn halton(index: u32) -> [f32; 2] {
    // The sequence's first point is a corner of the square: start at the second.
    let i = index % PERIOD + 1;
    [radical_inverse(i, 2) - 0.5, radical_inverse(i, 3) - 0.5]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_points_and_mean() {
        assert_eq!(halton(0)[0], 0.0);
        assert!((halton(0)[1] - (1.0 / 3.0 - 0.5)).abs() < 1e-6);
        assert_eq!(halton(1)[0], -0.25);
        assert_eq!(halton(5), halton(5 + PERIOD));
        for axis in 0..2 {
            let mean: f32 = (0..PERIOD).map(|i| halton(i)[axis]).sum::<f32>() / PERIOD as f32;
            assert!(mean.abs() < 0.01, "axis {axis} leans by {mean}");
        }
    }
}
