//! The answer of a study: for each metric, how each variant stands against the baseline.

use crate::record::{CellRecord, MetricRecord, StudyRecord};
use crate::statistics::{FEWEST_FOR_BOOTSTRAP, Interval, LEVEL, estimate, holm, mean_and_interval};
use serde::Serialize;
use std::collections::BTreeMap;

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

impl SummaryRow {
    /// The verdict as it is printed. A part of a study may have no cell of the variant.
    pub fn verdict_text(&self) -> &'static str {
        if self.cells == 0 { "no cells" } else { self.verdict.text() }
    }
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

/// Scene, camera, size, backend and seed.
type Pair<'a> = (&'a str, &'a str, [u32; 2], &'a str, u64);

/// What a cell has in common with the cell of the baseline that it is compared with.
pub(crate) fn pair_of(cell: &CellRecord) -> Pair<'_> {
    (&cell.scene, &cell.camera, cell.size, &cell.backend, cell.seed)
}

/// Summarizes all metrics of a study, in its order. The p-values of all comparisons are corrected together.
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
            let is_baseline = variant == study.baseline;
            let (mean, interval) = mean_and_interval(&strata(values.iter().map(|(pair, &v)| (*pair, v))));
            let differences = values.iter().filter(|_| !is_baseline).filter_map(|(pair, &v)| {
                Some((*pair, metric.distance(v) - metric.distance(*baseline.get(pair)?)))
            });
            let difference = estimate(&strata(differences));
            SummaryRow {
                variant: variant.into(),
                cells: values.len(),
                mean,
                interval,
                difference: difference.map(|e| e.mean),
                difference_interval: difference.and_then(|e| e.interval),
                p: difference.and_then(|e| e.p),
                verdict: if is_baseline { Verdict::Baseline } else { Verdict::NoDifference },
            }
        };
        let rows = study.variants.iter().map(|variant| row(&variant.name)).collect();
        Summary { metric: metric.name.clone(), rows }
    };
    let mut summaries: Vec<Summary> = study.metrics.iter().map(summary).collect();
    judge(&mut summaries);
    summaries
}

/// Values by strata: all that cells have in common with the cell of the baseline but the seed.
pub(crate) fn strata<'a>(values: impl Iterator<Item = (Pair<'a>, f64)>) -> Vec<Vec<f64>> {
    let mut strata: BTreeMap<_, Vec<f64>> = BTreeMap::new();
    for ((scene, camera, size, backend, _), value) in values {
        strata.entry((scene, camera, size, backend)).or_default().push(value);
    }
    strata.into_values().collect()
}

/// What few seeds mean for the intervals, in a sentence; `None` where every variant has enough of them for the bootstrap.
pub fn few_seeds(cells: &[CellRecord]) -> Option<String> {
    let mut seeds: BTreeMap<_, usize> = BTreeMap::new();
    for cell in cells {
        let (scene, camera, size, backend, _) = pair_of(cell);
        *seeds.entry((&cell.variant, scene, camera, size, backend)).or_default() += 1;
    }
    match seeds.into_values().min()? {
        1 => Some(
            "1 seed: nothing tells the noise, so that there is no interval and no difference can be shown; give 3 seeds or more".into(),
        ),
        n if n < FEWEST_FOR_BOOTSTRAP => Some(format!(
            "{n} seeds: the intervals are Student's, wide for want of values and right only if the noise is nearly normal, which {n} values cannot \
             tell; from {FEWEST_FOR_BOOTSTRAP} seeds on they are a bootstrap's"
        )),
        _ => None,
    }
}

/// Corrects the p-values, and gives the verdicts that follow.
fn judge(summaries: &mut [Summary]) {
    let compared = |summaries: &mut [Summary], f: &mut dyn FnMut(&mut SummaryRow, f64)| {
        for row in summaries.iter_mut().flat_map(|summary| &mut summary.rows) {
            if let Some(p) = row.p {
                f(row, p);
            }
        }
    };
    let mut p = Vec::new();
    compared(summaries, &mut |_, found| p.push(found));
    let mut corrected = holm(&p, LEVEL).into_iter();
    compared(summaries, &mut |row, _| {
        row.p = corrected.next().map(|corrected| corrected.p);
        row.verdict = match (row.p, row.difference) {
            (Some(p), Some(difference)) if p < LEVEL && difference < 0.0 => Verdict::Better,
            (Some(p), Some(difference)) if p < LEVEL && difference > 0.0 => Verdict::Worse,
            _ => Verdict::NoDifference,
        };
    });
}

impl Summary {
    /// The rows from the best to the worst. Those that are not told apart from the baseline stand with it, in the order of the study: they have no rank.
    pub fn ranked(&self) -> Vec<&SummaryRow> {
        let mut rows: Vec<&SummaryRow> = self.rows.iter().collect();
        let place = |row: &SummaryRow| match row.verdict {
            Verdict::Better => (0, row.difference.unwrap_or(0.0)),
            Verdict::Baseline | Verdict::NoDifference => (1, 0.0),
            Verdict::Worse => (2, row.difference.unwrap_or(0.0)),
        };
        rows.sort_by(|a, b| {
            let (a, b) = (place(a), place(b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{FORMAT, VariantRecord};

    /// A variant with its value of a scene's brightness and of noise.
    type TestVariant = (&'static str, fn(f64, f64) -> f64);

    /// Two scenes of different brightness, `seeds` seeds; the value of a variant from scene and seed.
    fn study(seeds: u64, variants: &[TestVariant]) -> (StudyRecord, Vec<CellRecord>) {
        let mut random = fastrand::Rng::with_seed(3);
        let mut cells = Vec::new();
        for scene in [1.0, 10.0] {
            for (variant, value) in variants {
                for seed in 0..seeds {
                    let noise = (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
                    cells.push(CellRecord {
                        cell: format!("{scene} {variant} {seed}"),
                        variant: (*variant).into(),
                        scene: scene.to_string(),
                        camera: String::new(),
                        size: [16, 16],
                        backend: "auto".into(),
                        seed,
                        metrics: BTreeMap::from([("relmse".into(), Some(value(scene, noise)))]),
                        frames: BTreeMap::new(),
                        first_frame: 0,
                        ledger: None,
                        images: BTreeMap::new(),
                        command: String::new(),
                    });
                }
            }
        }
        let record = StudyRecord {
            format: FORMAT,
            name: "test".into(),
            question: String::new(),
            file: String::new(),
            command: String::new(),
            version: String::new(),
            revision: String::new(),
            device: String::new(),
            driver: String::new(),
            metrics: vec![MetricRecord { name: "relmse".into(), formula: String::new(), perfect: 0.0 }],
            axes: Vec::new(),
            baseline: variants[0].0.into(),
            variants: variants
                .iter()
                .map(|(name, _)| VariantRecord {
                    name: (*name).into(),
                    axes: BTreeMap::new(),
                    set: Vec::new(),
                })
                .collect(),
            cells: cells.len(),
        };
        (record, cells)
    }

    /// The noise within a scene is small against the difference between scenes: only pairs show it.
    #[test]
    fn differences_are_paired_and_a_placebo_shows_none() {
        let variants: [TestVariant; 4] = [
            ("on", |scene, noise| scene * (1.0 + 0.02 * noise)),
            ("placebo", |scene, noise| scene * (1.0 + 0.02 * noise)),
            ("off", |scene, noise| scene * (1.5 + 0.02 * noise)),
            ("best", |scene, noise| scene * (0.8 + 0.02 * noise)),
        ];
        let (study, cells) = study(5, &variants);
        let found = &summarize(&study, &cells)[0];
        let verdicts: Vec<_> = found.rows.iter().map(|row| row.verdict).collect();
        assert_eq!(
            verdicts,
            [Verdict::Baseline, Verdict::NoDifference, Verdict::Worse, Verdict::Better],
            "{found:?}"
        );
        let order: Vec<_> = found.ranked().iter().map(|row| row.variant.as_str()).collect();
        assert_eq!(order, ["best", "on", "placebo", "off"]);
        assert!((found.rows[2].difference.unwrap() - 2.75).abs() < 0.2, "{found:?}");
        assert_eq!(found.rows[0].cells, 10);
    }

    #[test]
    fn few_seeds_are_said() {
        let variants: [TestVariant; 2] = [("on", |scene, noise| scene + noise), ("off", |scene, _| scene)];
        let said = |seeds: u64| few_seeds(&study(seeds, &variants).1);
        assert!(said(1).unwrap().starts_with("1 seed: ") && said(1).unwrap().contains("no interval"));
        assert!(said(2).unwrap().starts_with("2 seeds: the intervals are Student's"));
        assert!(said(4).unwrap().contains("which 4 values cannot tell; from 5 seeds on"));
        assert_eq!((said(5), few_seeds(&[])), (None, None));
        // One variant on one scene is short of seeds.
        let (_, mut cells) = study(5, &variants);
        cells.truncate(cells.len() - 3);
        assert!(few_seeds(&cells).unwrap().starts_with("2 seeds"));
        // The intervals that the sentence is about.
        let (record, cells) = study(2, &variants);
        assert!(summarize(&record, &cells)[0].rows.iter().all(|row| row.interval.is_some()));
    }

    #[test]
    fn one_seed_shows_nothing() {
        let variants: [TestVariant; 2] = [("on", |scene, _| scene), ("off", |scene, _| 2.0 * scene)];
        let (study, cells) = study(1, &variants);
        let row = &summarize(&study, &cells)[0].rows[1];
        assert_eq!((row.verdict, row.p, row.interval), (Verdict::NoDifference, None, None));
    }
}
