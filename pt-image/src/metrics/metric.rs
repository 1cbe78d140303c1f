//! The metrics by name and formula.

use super::flip::{EXPOSURE_LUMINANCE_FLOOR, PIXELS_PER_DEGREE};
use super::{
    PSNR_PEAK, RELMSE_EPSILON, SSIM_K1, SSIM_K2, VARIANCE_LAYER, Z_TEST_EPSILON, Z_TEST_SIGNIFICANCE,
};

/// A distance between an image `a` and its reference `b`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Metric {
    /// Mean squared error relative to the squared reference, linear values. Not symmetric.
    RelMse,
    /// Mean squared error, linear values.
    Mse,
    /// Peak signal-to-noise ratio in decibels, display values; infinite for equal images.
    Psnr,
    /// Mean structural similarity (Wang et al. 2004) of the luma of display values; 1 for equal images, -1 at worst.
    Ssim,
    /// LDR FLIP (Andersson et al. 2020), display values; 0 (equal) to 1.
    Flip,
    /// HDR FLIP (Andersson et al. 2021), linear values; 0 (equal) to 1. Not symmetric: exposed for the reference.
    HdrFlip,
    /// Mean of `a` over mean of `b`, linear values; 1 when no energy is lost or gained.
    Energy,
    /// Energy of the gradients of `a` over that of `b`: below 1 where detail was blurred away, above 1 where there is noise.
    Detail,
    /// Share of pixels where two Monte Carlo estimates agree within their standard errors; needs variances.
    ZTest,
}

impl Metric {
    /// All metrics, in the order in which they are printed.
    pub const ALL: [Self; 9] = [
        Self::RelMse,
        Self::Mse,
        Self::Psnr,
        Self::Ssim,
        Self::Flip,
        Self::HdrFlip,
        Self::Energy,
        Self::Detail,
        Self::ZTest,
    ];

    /// Those that need nothing but the two images, in the order in which they are printed.
    pub const OF_IMAGES: [Self; 8] = [
        Self::RelMse,
        Self::Mse,
        Self::Psnr,
        Self::Ssim,
        Self::Flip,
        Self::HdrFlip,
        Self::Energy,
        Self::Detail,
    ];

    /// Name on the command line and in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::RelMse => "relmse",
            Self::Mse => "mse",
            Self::Psnr => "psnr",
            Self::Ssim => "ssim",
            Self::Flip => "flip",
            Self::HdrFlip => "hdr-flip",
            Self::Energy => "energy",
            Self::Detail => "detail",
            Self::ZTest => "z-test",
        }
    }

    /// The definition in one line: a is the image, b the reference, linear values; A and B are display values.
    pub fn formula(self) -> String {
        match self {
            Self::RelMse => format!("mean((a - b)^2 / (b^2 + epsilon)), epsilon = {RELMSE_EPSILON}"),
            Self::Mse => "mean((a - b)^2)".into(),
            Self::Psnr => format!("10 log10(peak^2 / mean((A - B)^2)) dB, peak = {PSNR_PEAK}"),
            Self::Ssim => format!(
                "mean of SSIM(A, B) on luma 0.2126 R + 0.7152 G + 0.0722 B, 11x11 Gaussian window of sigma 1.5, borders \
                 replicated, K1 = {SSIM_K1}, K2 = {SSIM_K2}, L = 1"
            ),
            Self::Flip => {
                format!(
                    "mean of LDR FLIP(reference B, test A), 8 bits, {PIXELS_PER_DEGREE} pixels per degree"
                )
            }
            Self::HdrFlip => format!(
                "mean over pixels of the maximum over exposures c of LDR FLIP(T(2^c b), T(2^c a)), negative values as 0, \
                 T: ACES curve, T(2^c Y_b) = 0.85 for the largest (start) and the median (stop) luminance of b, \
                 max(2, ceil(stop - start)) exposures, {PIXELS_PER_DEGREE} pixels per degree, median >= epsilon = {EXPOSURE_LUMINANCE_FLOOR:.3e}"
            ),
            Self::Energy => "mean(a) / mean(b)".into(),
            Self::Detail => "sum(|grad f(a)|^2) / sum(|grad f(b)|^2), f(x) = y / (1 + y), y: luminance over the mean luminance of b, grad: \
                             differences of neighbours to the right and below"
                .into(),
            Self::ZTest => format!(
                "share of pixels with |a - b| <= z sqrt(v_a + v_b + (epsilon max(|a|, |b|))^2) in all three channels, v: \
                 variance of the mean (layer {VARIANCE_LAYER:?}), z: two-sided, significance {Z_TEST_SIGNIFICANCE} for all \
                 n = 3 x pixels tests together (Sidak: 1 - (1 - {Z_TEST_SIGNIFICANCE})^(1/n) each), epsilon = {Z_TEST_EPSILON}"
            ),
        }
    }

    /// The constant that keeps the denominator away from zero, where the formula has one.
    pub fn epsilon(self) -> Option<f64> {
        match self {
            Self::RelMse => Some(RELMSE_EPSILON),
            Self::HdrFlip => Some(EXPOSURE_LUMINANCE_FLOOR),
            Self::ZTest => Some(Z_TEST_EPSILON),
            _ => None,
        }
    }

    /// True when the metric looks at display values rather than linear ones.
    pub fn uses_display_values(self) -> bool {
        matches!(self, Self::Psnr | Self::Ssim | Self::Flip)
    }

    /// True when the metric needs the variances of both images.
    pub fn uses_variances(self) -> bool {
        self == Self::ZTest
    }
}
