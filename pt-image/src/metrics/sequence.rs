//! The metrics of sequences by name and formula: those of single images, and those of the change from frame to frame.

use std::str::FromStr;

use super::{Metric, MetricError, RELMSE_EPSILON, TEMPORAL_BLOCK};

/// What is measured of a frame of a sequence against the same frame of its reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SequenceMetric {
    /// Of the frame alone.
    Image(Metric),
    /// Of the change from the frame before, by pixels ([`TemporalError::pixel`](super::TemporalError::pixel)).
    TemporalPixel,
    /// The same by blocks ([`TemporalError::block`](super::TemporalError::block)).
    TemporalBlock,
}

impl SequenceMetric {
    /// Those that compare a frame with the frame before.
    pub const TEMPORAL: [Self; 2] = [Self::TemporalPixel, Self::TemporalBlock];

    /// Name on the command line, in study files and in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Image(metric) => metric.name(),
            Self::TemporalPixel => "temporal_pixel",
            Self::TemporalBlock => "temporal_block",
        }
    }

    /// The definition in one line, as [`Metric::formula`].
    pub fn formula(self) -> String {
        let change =
            "d = (a(x) - a_before(x')) - (b(x) - b_before(x')), x': where pixel x was in the frame before";
        match self {
            Self::Image(metric) => metric.formula(),
            Self::TemporalPixel => format!(
                "mean over pixels seen before of d^2 / (b^2 + epsilon), epsilon = {RELMSE_EPSILON}, {change}"
            ),
            Self::TemporalBlock => format!(
                "mean over blocks of {TEMPORAL_BLOCK} x {TEMPORAL_BLOCK} pixels of mean(d)^2 / (mean(b)^2 + epsilon), epsilon = \
                 {RELMSE_EPSILON}, {change}"
            ),
        }
    }

    /// The constant that keeps the denominator away from zero, where the formula has one.
    pub fn epsilon(self) -> Option<f64> {
        match self {
            Self::Image(metric) => metric.epsilon(),
            Self::TemporalPixel | Self::TemporalBlock => Some(RELMSE_EPSILON),
        }
    }

    /// The metric of the frame alone; `None` where it compares with the frame before.
    pub fn image(self) -> Option<Metric> {
        match self {
            Self::Image(metric) => Some(metric),
            Self::TemporalPixel | Self::TemporalBlock => None,
        }
    }

    /// Whether it compares a frame with the frame before.
    pub fn is_temporal(self) -> bool {
        Self::TEMPORAL.contains(&self)
    }

    /// Value of a perfect picture.
    pub fn perfect(self) -> f64 {
        match self {
            Self::Image(Metric::Ssim | Metric::Energy | Metric::Detail | Metric::ZTest) => 1.0,
            Self::Image(Metric::Psnr) => f64::INFINITY,
            _ => 0.0,
        }
    }
}

impl FromStr for SequenceMetric {
    type Err = MetricError;

    fn from_str(name: &str) -> Result<Self, MetricError> {
        let all = || Metric::ALL.into_iter().map(Self::Image).chain(Self::TEMPORAL);
        all().find(|metric| metric.name() == name).ok_or_else(|| MetricError::Unknown {
            name: name.into(),
            known: all().map(Self::name).collect::<Vec<_>>().join(", "),
        })
    }
}
