//! Distances between an image and its reference.
//!
//! Sums are f64 in pixel order, so the same images give the same digits. A pixel that is not finite is an error, never
//! a silent zero. Every metric states its formula ([`Metric::formula`]).

mod colour_map;
mod convolve;
mod detail;
mod display;
pub mod flip;
mod metric;
mod sequence;
mod ssim;
mod temporal;
mod z_test;

use crate::image_file::LinearImage;
use detail::detail;

pub use colour_map::{colour_map, heatmap};
pub use display::{DISPLAY_TRANSFORM, display_values};
pub use metric::Metric;
pub use sequence::SequenceMetric;
pub use ssim::{SSIM_K1, SSIM_K2};
pub use temporal::{Correspondence, FramePair, TEMPORAL_BLOCK, TemporalError, temporal_error};
pub use z_test::{VARIANCE_LAYER, Variances, Z_TEST_EPSILON, Z_TEST_SIGNIFICANCE, variance_layer};

/// Epsilon of relMSE, squared radiance: the value of Rousselle et al. 2011, "Adaptive sampling and reconstruction using
/// greedy error minimization". Pixels of the reference well below 0.1 weigh like absolute errors.
pub const RELMSE_EPSILON: f64 = 0.01;

/// Peak of PSNR: display values end at 1.
pub const PSNR_PEAK: f64 = 1.0;

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
    /// A metric needs the variances of both images, and they were not given.
    #[error("{} needs the variances of both images (EXR layer {VARIANCE_LAYER:?})", .0.name())]
    NoVariance(Metric),
    /// Some variances are NaN, infinite or negative.
    #[error(
        "not comparable: the variances of {a} pixels of the image and {b} of the reference are NaN, infinite or \
         negative (of {pixels})"
    )]
    BadVariance {
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
    /// Per-pixel error, rows from the top, for a [`heatmap`]: the FLIP value, 1 - SSIM, the (relative) squared error
    /// averaged over channels (of display values for PSNR), for energy |a - b| / mean(b) of the channel averages, for the
    /// Z-test the largest |z| of the channels.
    pub map: Vec<f32>,
    /// Numbers found on the way that belong to the value, by name: the exposures of HDR FLIP, the critical z.
    pub details: Vec<(&'static str, f64)>,
}

impl Measurement {
    /// The mean of the terms, with their spread.
    fn mean_of(metric: Metric, terms: &[f64], map: Vec<f32>) -> Self {
        let value = mean(terms);
        Self { metric, value, spread: standard_deviation(terms, value), map, details: Vec::new() }
    }

    /// The mean of terms that are the map as well.
    fn mean_error(metric: Metric, terms: &[f64]) -> Self {
        Self::mean_of(metric, terms, to_map(terms))
    }
}

/// Measures `a` against the reference `b`.
///
/// # Errors
/// [`MetricError::Size`] and [`MetricError::NonFinite`]; [`MetricError::NoVariance`] for a metric that is not of
/// [`Metric::OF_IMAGES`].
pub fn compare(
    a: &LinearImage,
    b: &LinearImage,
    metrics: &[Metric],
) -> Result<Vec<Measurement>, MetricError> {
    compare_estimates(a, b, None, metrics)
}

/// As [`compare`], of Monte Carlo estimates with the variances of their pixels.
///
/// # Errors
/// As [`compare`], and [`MetricError::BadVariance`].
pub fn compare_estimates(
    a: &LinearImage,
    b: &LinearImage,
    variances: Option<Variances<'_>>,
    metrics: &[Metric],
) -> Result<Vec<Measurement>, MetricError> {
    check_pair(a, b)?;
    if let Some(variances) = variances {
        check_variances(a, variances)?;
    }
    let width = a.width as usize;
    let display = metrics.iter().any(|metric| metric.uses_display_values()).then(|| display_values(a, b));
    let display = display.as_ref().map(|(a, b)| (a.as_slice(), b.as_slice())).unwrap_or_default();
    let measure = |&metric: &Metric| {
        Ok(match metric {
            Metric::RelMse => {
                Measurement::mean_error(metric, &per_pixel(&a.pixels, &b.pixels, relative_squared_error))
            }
            Metric::Mse => Measurement::mean_error(metric, &per_pixel(&a.pixels, &b.pixels, squared_error)),
            Metric::Psnr => psnr(display.0, display.1),
            Metric::Ssim => ssim(width, display.0, display.1),
            Metric::Flip => {
                Measurement::mean_error(metric, &flip_8bit(a.width, a.height, display.0, display.1))
            }
            Metric::HdrFlip => hdr_flip(width, &a.pixels, &b.pixels),
            Metric::Energy => energy(&a.pixels, &b.pixels),
            Metric::Detail => detail(width, &a.pixels, &b.pixels),
            Metric::ZTest => z_test(&a.pixels, &b.pixels, variances.ok_or(MetricError::NoVariance(metric))?),
        })
    };
    metrics.iter().map(measure).collect()
}

fn check_pair(a: &LinearImage, b: &LinearImage) -> Result<(), MetricError> {
    if (a.width, a.height) != (b.width, b.height) {
        return Err(MetricError::Size { a: (a.width, a.height), b: (b.width, b.height) });
    }
    match (non_finite_pixels(a), non_finite_pixels(b)) {
        (0, 0) => Ok(()),
        (bad_a, bad_b) => Err(MetricError::NonFinite { a: bad_a, b: bad_b, pixels: a.pixels.len() }),
    }
}

fn check_variances(image: &LinearImage, variances: Variances<'_>) -> Result<(), MetricError> {
    let (a, b) = (variances.a, variances.b);
    if let Some(other) = [a, b].into_iter().find(|v| (v.width, v.height) != (image.width, image.height)) {
        return Err(MetricError::Size { a: (image.width, image.height), b: (other.width, other.height) });
    }
    let unusable = |pixel: &&[f32; 3]| pixel.iter().any(|value| !value.is_finite() || *value < 0.0);
    match [a, b].map(|image| image.pixels.iter().filter(unusable).count()) {
        [0, 0] => Ok(()),
        [bad_a, bad_b] => Err(MetricError::BadVariance { a: bad_a, b: bad_b, pixels: image.pixels.len() }),
    }
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
        details: Vec::new(),
    }
}

fn ssim(width: usize, a: &[[f32; 3]], b: &[[f32; 3]]) -> Measurement {
    let terms = ssim::ssim(width, a, b);
    let map = terms.iter().map(|term| (1.0 - term) as f32).collect();
    Measurement::mean_of(Metric::Ssim, &terms, map)
}

fn flip_8bit(width: u32, height: u32, a: &[[f32; 3]], b: &[[f32; 3]]) -> Vec<f64> {
    let eight_bits = |pixels: &[[f32; 3]]| -> Vec<u8> {
        pixels.iter().flatten().map(|value| (value * 255.0).round() as u8).collect()
    };
    let image = |pixels| nv_flip::FlipImageRgb8::with_data(width, height, &eight_bits(pixels));
    let map = nv_flip::flip(image(b), image(a), flip::PIXELS_PER_DEGREE);
    map.to_vec().into_iter().map(f64::from).collect()
}

fn hdr_flip(width: usize, a: &[[f32; 3]], b: &[[f32; 3]]) -> Measurement {
    let flip::HdrFlip { exposures, map } = flip::hdr_flip(width, b, a);
    let terms: Vec<_> = map.iter().copied().map(f64::from).collect();
    Measurement {
        details: vec![
            ("start_exposure", exposures.start),
            ("stop_exposure", exposures.stop),
            ("exposures", exposures.count.into()),
        ],
        ..Measurement::mean_of(Metric::HdrFlip, &terms, map)
    }
}

fn z_test(a: &[[f32; 3]], b: &[[f32; 3]], variances: Variances<'_>) -> Measurement {
    let scores = z_test::z_scores(a, b, variances);
    let level = z_test::level_per_test(scores.len());
    let critical = z_test::two_sided_quantile(level);
    let passed: Vec<_> = scores.iter().map(|&z| f64::from(u8::from(z <= critical))).collect();
    Measurement {
        details: vec![("critical_z", critical), ("significance_per_test", level)],
        ..Measurement::mean_of(Metric::ZTest, &passed, to_map(&scores))
    }
}

/// Ratio of means. Two black images have ratio 1; light against a black reference is infinite.
fn energy(a: &[[f32; 3]], b: &[[f32; 3]]) -> Measurement {
    let level = |pixel: &[f32; 3]| pixel.iter().copied().map(f64::from).sum::<f64>() / 3.0;
    let (levels_a, levels_b): (Vec<_>, Vec<_>) =
        (a.iter().map(level).collect(), b.iter().map(level).collect());
    let (mean_a, mean_b) = (mean(&levels_a), mean(&levels_b));
    if mean_b == 0.0 {
        let value = if mean_a == 0.0 { 1.0 } else { f64::INFINITY.copysign(mean_a) };
        return Measurement {
            metric: Metric::Energy,
            value,
            spread: 0.0,
            map: vec![0.0; a.len()],
            details: Vec::new(),
        };
    }
    let value = mean_a / mean_b;
    let pairs = || levels_a.iter().zip(&levels_b);
    let residuals: Vec<_> = pairs().map(|(a, b)| (a - value * b) / mean_b).collect();
    Measurement {
        metric: Metric::Energy,
        value,
        spread: standard_deviation(&residuals, 0.0),
        map: pairs().map(|(a, b)| ((a - b) / mean_b).abs() as f32).collect(),
        details: Vec::new(),
    }
}
