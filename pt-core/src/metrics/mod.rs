//! Distances between an image and its reference.
//!
//! Sums are f64 in pixel order, so the same images give the same digits. A pixel that is not finite is an error, never
//! a silent zero. Every metric states its formula ([`Metric::formula`]).

mod colour_map;
mod display;

use std::str::FromStr;

use crate::image_file::LinearImage;

pub use colour_map::{colour_map, heatmap};
pub use display::{DISPLAY_TRANSFORM, display_values};

/// Epsilon of relMSE, squared radiance: the value of Rousselle et al. 2011, "Adaptive sampling and reconstruction using
/// greedy error minimization". Pixels of the reference well below 0.1 weigh like absolute errors.
pub const RELMSE_EPSILON: f64 = 0.01;

/// Peak of PSNR: display values end at 1.
pub const PSNR_PEAK: f64 = 1.0;

/// A distance between an image `a` and its reference `b`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Metric {
    /// Mean squared error relative to the squared reference, linear values. Not symmetric.
    RelMse,
    /// Mean squared error, linear values.
    Mse,
    /// Peak signal-to-noise ratio in decibels, display values; infinite for equal images.
    Psnr,
    /// LDR FLIP (Andersson et al. 2020), display values; 0 (equal) to 1.
    Flip,
    /// Mean of `a` over mean of `b`, linear values; 1 when no energy is lost or gained.
    Energy,
}

impl Metric {
    /// All metrics, in the order in which they are printed.
    pub const ALL: [Self; 5] = [Self::RelMse, Self::Mse, Self::Psnr, Self::Flip, Self::Energy];

    /// Name on the command line and in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::RelMse => "relmse",
            Self::Mse => "mse",
            Self::Psnr => "psnr",
            Self::Flip => "flip",
            Self::Energy => "energy",
        }
    }

    /// The definition in one line: a is the image, b the reference, linear values; A and B are display values.
    pub fn formula(self) -> String {
        match self {
            Self::RelMse => format!("mean((a - b)^2 / (b^2 + epsilon)), epsilon = {RELMSE_EPSILON}"),
            Self::Mse => "mean((a - b)^2)".into(),
            Self::Psnr => format!("10 log10(peak^2 / mean((A - B)^2)) dB, peak = {PSNR_PEAK}"),
            Self::Flip => format!(
                "mean of LDR FLIP(reference B, test A), 8 bits, {} pixels per degree",
                nv_flip::DEFAULT_PIXELS_PER_DEGREE
            ),
            Self::Energy => "mean(a) / mean(b)".into(),
        }
    }

    /// The constant that keeps the denominator away from zero, where the formula has one.
    pub fn epsilon(self) -> Option<f64> {
        (self == Self::RelMse).then_some(RELMSE_EPSILON)
    }

    /// True when the metric looks at display values rather than linear ones.
    pub fn uses_display_values(self) -> bool {
        matches!(self, Self::Psnr | Self::Flip)
    }
}

impl FromStr for Metric {
    type Err = MetricError;

    fn from_str(name: &str) -> Result<Self, MetricError> {
        Self::ALL.into_iter().find(|metric| metric.name() == name).ok_or_else(|| MetricError::Unknown {
            name: name.into(),
            known: Self::ALL.map(Self::name).join(", "),
        })
    }
}

/// Why two images could not be compared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MetricError {
    /// No metric has this name.
    #[error("unknown metric {name:?}, known: {known}")]
    Unknown {
        /// The name asked for.
        name: String,
        /// All names.
        known: String,
    },
    /// The images differ in size.
    #[error("the images differ in size: {}x{} and {}x{}", a.0, a.1, b.0, b.1)]
    Size {
        /// Width and height of the image.
        a: (u32, u32),
        /// Width and height of the reference.
        b: (u32, u32),
    },
    /// Some pixels hold NaN or infinity.
    #[error(
        "not comparable: {a} pixels of the image and {b} of the reference are NaN or infinite (of {pixels})"
    )]
    NonFinite {
        /// Number of such pixels in the image.
        a: usize,
        /// Number of such pixels in the reference.
        b: usize,
        /// Pixels per image.
        pixels: usize,
    },
}

/// The value of one metric for a pair of images.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// Which metric.
    pub metric: Metric,
    /// Its value over the whole image.
    pub value: f64,
    /// Standard deviation over pixels of the per-pixel terms whose mean makes the value; for PSNR and energy, which are
    /// functions of means, of the terms of the first-order expansion. The standard error of independent pixels is
    /// this over the root of their number.
    pub spread: f64,
    /// Per-pixel error, rows from the top, for a [`heatmap`]: the FLIP value, the (relative) squared error averaged over
    /// channels (of display values for PSNR), or for energy |a - b| / mean(b) of the channel averages.
    pub map: Vec<f32>,
}

/// Measures `a` against the reference `b`.
///
/// # Errors
/// [`MetricError::Size`] and [`MetricError::NonFinite`].
pub fn compare(
    a: &LinearImage,
    b: &LinearImage,
    metrics: &[Metric],
) -> Result<Vec<Measurement>, MetricError> {
    if (a.width, a.height) != (b.width, b.height) {
        return Err(MetricError::Size { a: (a.width, a.height), b: (b.width, b.height) });
    }
    let (bad_a, bad_b) = (non_finite_pixels(a), non_finite_pixels(b));
    if bad_a + bad_b > 0 {
        return Err(MetricError::NonFinite { a: bad_a, b: bad_b, pixels: a.pixels.len() });
    }
    let display = metrics.iter().any(|metric| metric.uses_display_values()).then(|| display_values(a, b));
    let display = display.as_ref().map(|(a, b)| (a.as_slice(), b.as_slice())).unwrap_or_default();
    Ok(metrics
        .iter()
        .map(|&metric| match metric {
            Metric::RelMse => mean_of(metric, per_pixel(&a.pixels, &b.pixels, relative_squared_error)),
            Metric::Mse => mean_of(metric, per_pixel(&a.pixels, &b.pixels, squared_error)),
            Metric::Psnr => psnr(display.0, display.1),
            Metric::Flip => mean_of(metric, flip(a.width, a.height, display.0, display.1)),
            Metric::Energy => energy(&a.pixels, &b.pixels),
        })
        .collect())
}

/// Number of pixels with a channel that is NaN or infinite.
pub fn non_finite_pixels(image: &LinearImage) -> usize {
    image.pixels.iter().filter(|pixel| pixel.iter().any(|value| !value.is_finite())).count()
}

fn squared_error(a: f64, b: f64) -> f64 {
    (a - b) * (a - b)
}

fn relative_squared_error(a: f64, b: f64) -> f64 {
    (a - b) * (a - b) / (b * b + RELMSE_EPSILON)
}

/// The error of each pixel, averaged over its channels.
fn per_pixel(a: &[[f32; 3]], b: &[[f32; 3]], error: fn(f64, f64) -> f64) -> Vec<f64> {
    let pixel = |(a, b): (&[f32; 3], &[f32; 3])| {
        (0..3).map(|channel| error(a[channel].into(), b[channel].into())).sum::<f64>() / 3.0
    };
    a.iter().zip(b).map(pixel).collect()
}

fn mean(terms: &[f64]) -> f64 {
    terms.iter().sum::<f64>() / terms.len() as f64
}

fn standard_deviation(terms: &[f64], mean: f64) -> f64 {
    (terms.iter().map(|term| (term - mean) * (term - mean)).sum::<f64>() / terms.len() as f64).sqrt()
}

fn to_map(terms: &[f64]) -> Vec<f32> {
    terms.iter().map(|&term| term as f32).collect()
}

fn mean_of(metric: Metric, terms: Vec<f64>) -> Measurement {
    let value = mean(&terms);
    Measurement { metric, value, spread: standard_deviation(&terms, value), map: to_map(&terms) }
}

fn psnr(a: &[[f32; 3]], b: &[[f32; 3]]) -> Measurement {
    let terms = per_pixel(a, b, squared_error);
    let mse = mean(&terms);
    let value = 10.0 * (PSNR_PEAK * PSNR_PEAK / mse).log10();
    let slope = if mse > 0.0 { 10.0 / (std::f64::consts::LN_10 * mse) } else { 0.0 };
    Measurement {
        metric: Metric::Psnr,
        value,
        spread: slope * standard_deviation(&terms, mse),
        map: to_map(&terms),
    }
}

fn flip(width: u32, height: u32, a: &[[f32; 3]], b: &[[f32; 3]]) -> Vec<f64> {
    let eight_bits = |pixels: &[[f32; 3]]| -> Vec<u8> {
        pixels.iter().flatten().map(|value| (value * 255.0).round() as u8).collect()
    };
    let image = |pixels| nv_flip::FlipImageRgb8::with_data(width, height, &eight_bits(pixels));
    let map = nv_flip::flip(image(b), image(a), nv_flip::DEFAULT_PIXELS_PER_DEGREE);
    map.to_vec().into_iter().map(f64::from).collect()
}

/// Ratio of means. Two black images have ratio 1; light against a black reference is infinite.
fn energy(a: &[[f32; 3]], b: &[[f32; 3]]) -> Measurement {
    let level = |pixel: &[f32; 3]| pixel.iter().copied().map(f64::from).sum::<f64>() / 3.0;
    let (levels_a, levels_b): (Vec<_>, Vec<_>) =
        (a.iter().map(level).collect(), b.iter().map(level).collect());
    let (mean_a, mean_b) = (mean(&levels_a), mean(&levels_b));
    if mean_b == 0.0 {
        let value = if mean_a == 0.0 { 1.0 } else { f64::INFINITY.copysign(mean_a) };
        return Measurement { metric: Metric::Energy, value, spread: 0.0, map: vec![0.0; a.len()] };
    }
    let value = mean_a / mean_b;
    let pairs = || levels_a.iter().zip(&levels_b);
    let residuals: Vec<_> = pairs().map(|(a, b)| (a - value * b) / mean_b).collect();
    Measurement {
        metric: Metric::Energy,
        value,
        spread: standard_deviation(&residuals, 0.0),
        map: pairs().map(|(a, b)| ((a - b) / mean_b).abs() as f32).collect(),
    }
}
