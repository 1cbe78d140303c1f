//! The answer of a study: for each metric, how each variant stands against the baseline.

use crate::record::{CellRecord, MetricRecord, StudyRecord};
use serde::Serialize;
use std::collections::BTreeMap;

/// A range that contains the mean of the population with a probability of 95 %.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// How a variant stands against the baseline, after the correction for the number of comparisons.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The variant is the baseline.
    Baseline,
    /// Nearer to the perfect value.
    Better,
    /// Farther from the perfect value.
    Worse,
    /// The difference is inside the noise, or there are too few cells to tell.
    NoDifference,
}

impl Verdict {
    /// The verdict as it is printed.
    pub fn text(self) -> &'static str {
        match self {
            Self::Baseline => "baseline",
            Self::Better => "better",
            Self::Worse => "worse",
            Self::NoDifference => "no difference shown",
        }
    }
}

/// A variant in the summary of one metric.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SummaryRow {
    /// Name of the variant.
    pub variant: String,
    /// Number of cells with a finite value.
    pub cells: usize,
    /// Mean over these cells; `None`: no cell has a value.
    pub mean: Option<f64>,
    /// Interval of the mean; `None`: fewer than two values.
    pub interval: Option<Interval>,
    /// Mean paired difference to the baseline of the distance from the perfect value ([`MetricRecord::distance`]): negative is better.
    /// `None` for the baseline, and where no cell pairs with one of the baseline.
    pub difference: Option<f64>,
    /// Interval of the difference.
    pub difference_interval: Option<Interval>,
    /// p-value of the difference, corrected for the number of comparisons of the study (Holm).
    pub p: Option<f64>,
    /// Verdict.
    pub verdict: Verdict,
}

/// One metric of a study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Name of the metric.
    pub metric: String,
    /// All variants, in the order of the study.
    pub rows: Vec<SummaryRow>,
}

impl MetricRecord {
    /// Distance of a value from the perfect one: the error itself, and for ratios and SSIM how far they are from 1.
    pub fn distance(&self, value: f64) -> f64 {
        (value - self.perfect).abs()
    }
}

/// What a cell has in common with the cell of the baseline that it is compared with.
fn pair_of(cell: &CellRecord) -> (&str, &str, [u32; 2], &str, u64) {
    (&cell.scene, &cell.camera, cell.size, &cell.backend, cell.seed)
}

/// Summarizes all metrics of a study, in its order.
pub fn summarize(study: &StudyRecord, cells: &[CellRecord]) -> Vec<Summary> {
    let summary = |metric: &MetricRecord| {
        let value = |cell: &CellRecord| cell.metrics.get(&metric.name).copied().flatten();
        let of = |variant: &str| -> BTreeMap<_, f64> {
            let cells = cells.iter().filter(|cell| cell.variant == variant);
            cells.filter_map(|cell| Some((pair_of(cell), value(cell)?))).collect()
        };
        let baseline = of(&study.baseline);
        let row = |variant: &str| {
            let values = of(variant);
            let differences: Vec<f64> = values
                .iter()
                .filter_map(|(pair, &v)| Some(metric.distance(v) - metric.distance(*baseline.get(pair)?)))
                .collect();
            let is_baseline = variant == study.baseline;
            let (mean, interval) = mean_and_interval(&values.values().copied().collect::<Vec<_>>());
            let (difference, difference_interval) =
                if is_baseline { (None, None) } else { mean_and_interval(&differences) };
            let verdict = match difference_interval {
                _ if is_baseline => Verdict::Baseline,
                Some(Interval { high, .. }) if high < 0.0 => Verdict::Better,
                Some(Interval { low, .. }) if low > 0.0 => Verdict::Worse,
                _ => Verdict::NoDifference,
            };
            SummaryRow {
                variant: variant.into(),
                cells: values.len(),
                mean,
                interval,
                difference,
                difference_interval,
                p: None,
                verdict,
            }
        };
        let rows = study.variants.iter().map(|variant| row(&variant.name)).collect();
        Summary { metric: metric.name.clone(), rows }
    };
    study.metrics.iter().map(summary).collect()
}

/// Quantiles 0.975 of Student's distribution for 1, 2, ... degrees of freedom.
const STUDENT: [f64; 20] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131,
    2.120, 2.110, 2.101, 2.093, 2.086,
];

/// Mean, and Student's interval of the mean.
pub(crate) fn mean_and_interval(values: &[f64]) -> (Option<f64>, Option<Interval>) {
    if values.is_empty() {
        return (None, None);
    }
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let interval = (values.len() > 1).then(|| {
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let quantile = STUDENT.get(values.len() - 2).copied().unwrap_or(1.96);
        let half = quantile * (variance / n).sqrt();
        Interval { low: mean - half, high: mean + half }
    });
    (Some(mean), interval)
}
