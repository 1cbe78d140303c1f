//! The metrics of a study.

use crate::record::MetricRecord;
use pt_image::metrics::{Metric, TEMPORAL_BLOCK};

/// Which picture of a frame is measured, and of its ground truth alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeasureAt {
    /// Linear radiance before bloom and exposure.
    Radiance,
    /// The picture as shown, as linear display values: after bloom, exposure, tone curve and FSR 1. The ground truth is shown with the same
    /// knobs, and metered by itself.
    Display,
}

/// What is measured of a frame against its ground truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StudyMetric {
    /// Of the frame alone.
    Image(Metric),
    /// Of the change from the frame before, by pixels.
    TemporalPixel,
    /// The same by blocks.
    TemporalBlock,
}

impl StudyMetric {
    /// All metrics, in the order in which messages list them. The PSNR has no perfect value, and the Z-test needs variances.
    pub const ALL: [Self; 9] = [
        Self::Image(Metric::RelMse),
        Self::Image(Metric::Mse),
        Self::Image(Metric::Flip),
        Self::Image(Metric::HdrFlip),
        Self::Image(Metric::Ssim),
        Self::Image(Metric::Energy),
        Self::Image(Metric::Detail),
        Self::TemporalPixel,
        Self::TemporalBlock,
    ];

    /// Name in study files and results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Image(metric) => metric.name(),
            Self::TemporalPixel => "temporal_pixel",
            Self::TemporalBlock => "temporal_block",
        }
    }

    /// The metric of a name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|metric| metric.name() == name)
    }

    /// Whether it compares a frame with the frame before.
    pub fn is_temporal(self) -> bool {
        matches!(self, Self::TemporalPixel | Self::TemporalBlock)
    }

    /// Value of a perfect picture.
    pub fn perfect(self) -> f64 {
        match self {
            Self::Image(Metric::Ssim | Metric::Energy | Metric::Detail) => 1.0,
            _ => 0.0,
        }
    }

    /// As results describe it.
    pub fn record(self, measure_at: MeasureAt) -> MetricRecord {
        let change =
            "d = (a(x) - a_before(x')) - (b(x) - b_before(x')), x': where pixel x was in the frame before";
        let formula = match self {
            Self::Image(metric) => metric.formula(),
            Self::TemporalPixel => format!("mean over pixels seen before of d^2 / (b^2 + epsilon), {change}"),
            Self::TemporalBlock => format!(
                "mean over blocks of {TEMPORAL_BLOCK} x {TEMPORAL_BLOCK} pixels of mean(d)^2 / (mean(b)^2 + epsilon), {change}"
            ),
        };
        let formula = match measure_at {
            MeasureAt::Radiance => formula,
            MeasureAt::Display => format!("{formula}; a, b: linear display values of the pictures as shown"),
        };
        MetricRecord { name: self.name().into(), formula, perfect: self.perfect() }
    }
}
