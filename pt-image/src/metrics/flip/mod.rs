//! FLIP in floating point: the LDR metric for values that were never rounded to 8 bits, and the HDR metric on top of it.
//!
//! Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images" (here: FLIP 2020), and Andersson et
//! al. 2021, "Visualizing Errors in Rendered High Dynamic Range Images" (here: FLIP 2021). All filters are separable.

mod colour;
mod hdr;
mod kernels;

use rayon::prelude::*;

use self::colour::{ColourSpace, hyab};
use self::kernels::FeatureKernels;
use super::convolve::Plane;

pub use hdr::{EXPOSURE_LUMINANCE_FLOOR, Exposures, HdrFlip, hdr_flip};

/// Distance to the observer for which FLIP is measured here, pixels per degree of visual angle: 0.7 m from a display of
/// 3840 pixels on 0.7 m (67.02), the default of FLIP 2020, section 3.
pub const PIXELS_PER_DEGREE: f32 = 3840.0 * std::f32::consts::PI / 180.0;

/// Exponent of the HyAB distance (FLIP 2020, section 4.1.3).
const COLOUR_EXPONENT: f32 = 0.7;
/// Part of the largest colour error below which errors are spread over 0 to [`KNEE_ERROR`].
const KNEE: f32 = 0.4;
/// Colour error at [`KNEE`].
const KNEE_ERROR: f32 = 0.95;
/// Exponent of the feature difference (FLIP 2020, section 4.2.2).
const FEATURE_EXPONENT: f32 = 0.5;

/// LDR FLIP of one viewing distance.
pub struct LdrFlip {
    space: ColourSpace,
    contrast: [Vec<Vec<f32>>; 3],
    features: FeatureKernels,
    /// HyAB distance of green and blue, the farthest corners of the RGB cube, to the power of [`COLOUR_EXPONENT`].
    largest: f32,
}

/// What of an image enters the differences.
struct Appearance {
    /// Hunt-adjusted L*a*b* of the colours that the eye resolves.
    colours: Vec<[f32; 3]>,
    /// Magnitude of the smoothed first and second derivatives of lightness.
    features: Vec<[f32; 2]>,
}

impl LdrFlip {
    /// For an observer who sees so many pixels in one degree of visual angle (more than 0).
    pub fn new(pixels_per_degree: f32) -> Self {
        let space = ColourSpace::new();
        let largest = {
            let seen = |rgb| space.hunt_lab(space.opponent(rgb));
            hyab(seen([0.0, 1.0, 0.0]), seen([0.0, 0.0, 1.0])).powf(COLOUR_EXPONENT)
        };
        Self {
            space,
            contrast: kernels::contrast_sensitivity(pixels_per_degree.into()),
            features: FeatureKernels::new(pixels_per_degree.into()),
            largest,
        }
    }

    /// The difference of each pixel, 0 to 1, of two images in rows of `width` pixels: linear RGB (Rec. 709 primaries)
    /// of a display, 0 to 1. Symmetric.
    ///
    /// # Panics
    /// When the images differ in length or are no whole rows.
    pub fn map(&self, width: usize, reference: &[[f32; 3]], test: &[[f32; 3]]) -> Vec<f32> {
        assert!(reference.len() == test.len() && reference.len().is_multiple_of(width));
        let (reference, test) = (self.appearance(width, reference), self.appearance(width, test));
        let colours = reference.colours.par_iter().zip(&test.colours);
        let features = reference.features.par_iter().zip(&test.features);
        colours
            .zip(features)
            .map(|(colours, features)| {
                let colour = self.colour_difference(*colours.0, *colours.1);
                let feature = feature_difference(*features.0, *features.1);
                colour.powf(1.0 - feature)
            })
            .collect()
    }

    fn appearance(&self, width: usize, pixels: &[[f32; 3]]) -> Appearance {
        let opponent: Vec<_> = pixels.par_iter().map(|&rgb| self.space.opponent(rgb)).collect();
        let channels: [_; 3] =
            std::array::from_fn(|channel| Plane::from_pixels(width, &opponent, |pixel| pixel[channel]));
        Appearance { features: self.features(&channels[0]), colours: self.colours(&channels) }
    }

    /// FLIP 2020, section 4.1: the contrast sensitivity filters, then a perceptually uniform space.
    fn colours(&self, channels: &[Plane<f32>; 3]) -> Vec<[f32; 3]> {
        let filtered: [Vec<f32>; 3] = std::array::from_fn(|channel| {
            let terms =
                self.contrast[channel].iter().map(|kernel| channels[channel].convolve(kernel, kernel));
            let sum = terms.reduce(|mut sum, term| {
                sum.values.par_iter_mut().zip(&term.values).for_each(|(sum, value)| *sum += value);
                sum
            });
            sum.expect("each channel has a kernel").values
        });
        let [achromatic, red_green, blue_yellow] = filtered;
        let pixels = achromatic.into_par_iter().zip(red_green).zip(blue_yellow);
        pixels.map(|((y, red_green), blue_yellow)| self.space.hunt_lab([y, red_green, blue_yellow])).collect()
    }

    /// FLIP 2020, section 4.2: edges and points of the luminance relative to white, which is what the paper scales its
    /// achromatic channel back to.
    fn features(&self, luminance: &Plane<f32>) -> Vec<[f32; 2]> {
        let FeatureKernels { smooth, first, second } = &self.features;
        let magnitudes = |derivative: &[f32]| -> Vec<f32> {
            let (x, y) = (luminance.convolve(derivative, smooth), luminance.convolve(smooth, derivative));
            x.values.into_par_iter().zip(y.values).map(|(x, y)| x.hypot(y)).collect()
        };
        let (edges, points) = (magnitudes(first), magnitudes(second));
        edges.into_par_iter().zip(points).map(|(edge, point)| [edge, point]).collect()
    }

    /// The HyAB distance, spread over 0 to 1 so that small and middling errors take most of the range.
    fn colour_difference(&self, a: [f32; 3], b: [f32; 3]) -> f32 {
        let error = hyab(a, b).powf(COLOUR_EXPONENT) / self.largest;
        let spread = if error < KNEE {
            error * KNEE_ERROR / KNEE
        } else {
            KNEE_ERROR + (error - KNEE) / (1.0 - KNEE) * (1.0 - KNEE_ERROR)
        };
        spread.min(1.0)
    }
}

fn feature_difference(a: [f32; 2], b: [f32; 2]) -> f32 {
    let larger = (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
    (larger * std::f32::consts::FRAC_1_SQRT_2).powf(FEATURE_EXPONENT).min(1.0)
}
