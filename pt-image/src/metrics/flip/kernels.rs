//! The filters of FLIP as one-dimensional kernels.

use std::f64::consts::PI;

/// A Gaussian of a contrast sensitivity function: `scale` and `spread` are a and b of FLIP 2020, table 1.
#[derive(Clone, Copy)]
struct Sensitivity {
    scale: f64,
    spread: f64,
}

/// Achromatic, red-green, blue-yellow.
const SENSITIVITIES: [&[Sensitivity]; 3] = [
    &[Sensitivity { scale: 1.0, spread: 0.0047 }],
    &[Sensitivity { scale: 1.0, spread: 0.0053 }],
    &[Sensitivity { scale: 34.1, spread: 0.04 }, Sensitivity { scale: 13.5, spread: 0.025 }],
];

/// The largest spread, which sets the size of all three filters.
const LARGEST_SPREAD: f64 = 0.04;

/// Width of a feature, degrees of visual angle (FLIP 2020, section 4.2.1).
const FEATURE_WIDTH: f64 = 0.082;

/// For each opponent channel the kernels whose outer products with themselves add up to the contrast sensitivity filter:
/// `scale sqrt(pi / spread) exp(-pi^2 r^2 / spread)`, r in degrees, cut at three standard deviations of the widest and
/// scaled to unit sum.
pub fn contrast_sensitivity(pixels_per_degree: f64) -> [Vec<Vec<f32>>; 3] {
    let radius = (3.0 * (LARGEST_SPREAD / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil();
    SENSITIVITIES.map(|terms| {
        let gaussians = terms.iter().map(|term| {
            let weight = (term.scale * (PI / term.spread).sqrt()).sqrt();
            samples(radius, |x| weight * (-(PI * x / pixels_per_degree).powi(2) / term.spread).exp())
        });
        let gaussians: Vec<_> = gaussians.collect();
        let total: f64 = gaussians.iter().map(|kernel| kernel.iter().sum::<f64>().powi(2)).sum();
        gaussians.iter().map(|kernel| scaled(kernel, 1.0 / total.sqrt())).collect()
    })
}

/// Smoothed derivatives along one axis, for edges and for points.
pub struct FeatureKernels {
    /// Gaussian of unit sum, across the derivative.
    pub smooth: Vec<f32>,
    /// First derivative of the Gaussian; its positive weights add up to 1 and its negative ones to -1.
    pub first: Vec<f32>,
    /// Second derivative, normalised in the same way.
    pub second: Vec<f32>,
}

impl FeatureKernels {
    pub fn new(pixels_per_degree: f64) -> Self {
        let sigma = 0.5 * FEATURE_WIDTH * pixels_per_degree;
        let radius = (3.0 * sigma).ceil();
        let gaussian = |x: f64| (-x * x / (2.0 * sigma * sigma)).exp();
        let smooth = samples(radius, gaussian);
        let total: f64 = smooth.iter().sum();
        Self {
            smooth: scaled(&smooth, 1.0 / total),
            first: balanced(&samples(radius, |x| -x * gaussian(x))),
            second: balanced(&samples(radius, |x| (x * x / (sigma * sigma) - 1.0) * gaussian(x))),
        }
    }
}

/// Values of `f` at the whole numbers from `-radius` to `radius`.
fn samples(radius: f64, f: impl Fn(f64) -> f64) -> Vec<f64> {
    let radius = radius as i32;
    (-radius..=radius).map(|x| f(x.into())).collect()
}

fn scaled(kernel: &[f64], scale: f64) -> Vec<f32> {
    kernel.iter().map(|weight| (weight * scale) as f32).collect()
}

/// Scales the positive weights to sum 1 and the negative ones to sum -1.
fn balanced(kernel: &[f64]) -> Vec<f32> {
    let positive: f64 = kernel.iter().filter(|&&weight| weight > 0.0).sum();
    let negative: f64 = -kernel.iter().filter(|&&weight| weight < 0.0).sum::<f64>();
    kernel.iter().map(|&weight| (weight / if weight > 0.0 { positive } else { negative }) as f32).collect()
}
