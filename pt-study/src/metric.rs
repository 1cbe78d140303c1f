//! The metrics of a study.

use crate::record::MetricRecord;
use pt_image::metrics::{Metric, SequenceMetric};

/// Which picture of a frame is measured, and of its ground truth alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeasureAt {
    /// Linear radiance before bloom and exposure.
    Radiance,
    /// The picture as shown, as linear display values: after bloom, exposure, tone curve and FSR 1. The ground truth is shown with the same
    /// knobs, and metered by itself.
    Display,
}

/// All metrics of studies, in the order in which messages list them. The PSNR has no perfect value, and the Z-test needs variances.
pub const STUDY_METRICS: [SequenceMetric; 9] = [
    SequenceMetric::Image(Metric::RelMse),
    SequenceMetric::Image(Metric::Mse),
    SequenceMetric::Image(Metric::Flip),
    SequenceMetric::Image(Metric::HdrFlip),
    SequenceMetric::Image(Metric::Ssim),
    SequenceMetric::Image(Metric::Energy),
    SequenceMetric::Image(Metric::Detail),
    SequenceMetric::TemporalPixel,
    SequenceMetric::TemporalBlock,
];

/// The metric as results describe it.
pub fn record(metric: SequenceMetric, measure_at: MeasureAt) -> MetricRecord {
    let formula = match measure_at {
        MeasureAt::Radiance => metric.formula(),
        MeasureAt::Display => {
            format!("{}; a, b: linear display values of the pictures as shown", metric.formula())
        }
    };
    MetricRecord { name: metric.name().into(), formula, perfect: metric.perfect() }
}
