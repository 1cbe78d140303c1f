//! Sub-pixel offsets.

use crate::Jitter;

/// Length of the sequences before they repeat.
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

/// Offset of frame `index` in [-0.5, 0.5)^2: the R2 sequence (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom
/// Sequences"): multiples of powers of the plastic number's inverse.
pub fn r2(index: u32) -> [f32; 2] {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    let i = f64::from(index % PERIOD);
    // Starts at the pixel's centre.
    [1.0 / PLASTIC, 1.0 / (PLASTIC * PLASTIC)].map(|step| ((0.5 + i * step).fract() - 0.5) as f32)
}

/// Where in its pixels frame `index` is sampled, from the centre, in pixels; the centre when each pixel has an offset of its
/// own, or none has.
pub fn frame_jitter(jitter: Jitter, index: u32) -> [f32; 2] {
    match jitter {
        Jitter::Halton => halton(index),
        Jitter::R2 => r2(index),
        Jitter::None | Jitter::Pixel => [0.0; 2],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every cell of a 4 x 4 grid gets its share of a period, and successive points are apart.
    #[test]
    fn sequences_fill_the_pixel() {
        for jitter in [Jitter::Halton, Jitter::R2] {
            let mut cells = [0; 16];
            for i in 0..PERIOD {
                let p = frame_jitter(jitter, i);
                assert!(p.iter().all(|v| (-0.5..0.5).contains(v)), "{jitter:?} {i}: {p:?}");
                cells[((p[1] + 0.5) * 4.0) as usize * 4 + ((p[0] + 0.5) * 4.0) as usize] += 1;
                let q = frame_jitter(jitter, i + 1);
                assert!((p[0] - q[0]).hypot(p[1] - q[1]) > 0.1, "{jitter:?} {i}");
            }
            assert!(cells.iter().all(|n| (6..=10).contains(n)), "{jitter:?}: {cells:?}");
        }
        assert_eq!(r2(0), [0.0; 2]);
        assert_eq!(r2(3), r2(3 + PERIOD));
        assert_eq!(frame_jitter(Jitter::Pixel, 3), [0.0; 2]);
    }

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
