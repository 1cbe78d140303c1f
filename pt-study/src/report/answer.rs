//! The answer of the study: a table for each metric, with ranks that do not order what the noise does not.

use super::input::Results;
use super::number::{Column, significant};
use super::rank::ranks;
use super::series::Series;
use super::table::{Datum, Table};
use crate::cost::gpu_time;
use crate::record::MetricRecord;
use crate::statistics::Interval;
use crate::summary::{Summary, SummaryRow, Verdict};
use serde::Serialize;

/// The summary of one metric.
#[derive(Serialize)]
pub struct Answer {
    pub metric: String,
    pub formula: String,
    /// What a perfect picture has, as text.
    pub perfect: String,
    /// Names of variants by verdict.
    pub better: Vec<String>,
    pub worse: Vec<String>,
    pub same: Vec<String>,
    pub table: Table,
}

fn cost_of(results: &Results, variant: &str) -> Option<f64> {
    let cells = results.cells.iter().filter(|cell| cell.variant == variant);
    gpu_time(cells, |cell| Some(results.timings.get(cell)?.gpu_ms))
}

pub fn answers(results: &Results, summaries: &[Summary], series: &[Series]) -> Vec<Answer> {
    let metrics = results.study.metrics.iter();
    let of = |metric: &MetricRecord| summaries.iter().find(|summary| summary.metric == metric.name);
    metrics.filter_map(|metric| Some(answer(results, metric, of(metric)?, series))).collect()
}

fn answer(results: &Results, metric: &MetricRecord, summary: &Summary, series: &[Series]) -> Answer {
    let with = |verdict: Verdict| -> Vec<String> {
        let rows = summary.rows.iter().filter(|row| row.verdict == verdict);
        rows.map(|row| row.variant.clone()).collect()
    };
    let half_width = |i: Interval| (i.high - i.low) / 2.0;
    let rows = || summary.rows.iter();
    let means = Column::of_uncertain(
        rows().filter_map(|row| row.mean),
        rows().filter_map(|row| row.interval.map(half_width)),
    );
    let differences = Column::of_uncertain(
        rows().filter_map(|row| row.difference),
        rows().filter_map(|row| row.difference_interval.map(half_width)),
    );
    let ranks = ranks(&summary.rows);
    let mut table = Table::new([
        "#Rank",
        "Variant",
        "Verdict",
        "#Mean",
        "#95 % interval",
        "#Difference to baseline",
        "#95 % interval of the difference",
        "#p (Holm)",
        "#GPU ms",
        "#Cells",
    ]);
    let mut rows: Vec<(&SummaryRow, Option<usize>)> =
        summary.rows.iter().zip(ranks.iter().copied()).collect();
    // Rows of one rank stay in the order of the study, so that their order says nothing.
    rows.sort_by_key(|(_, rank)| rank.unwrap_or(usize::MAX));
    for (row, rank) in rows {
        let shared = ranks.iter().filter(|other| rank.is_some() && **other == rank).count() > 1;
        let number = |value: Option<f64>, text: &dyn Fn(f64) -> String| {
            value.map_or_else(Datum::none, |value| Datum::number(value, text(value)))
        };
        let interval = |interval: Option<Interval>, text: &dyn Fn(f64) -> String| {
            interval.map_or_else(Datum::none, |i| {
                Datum::number(i.high - i.low, format!("{} to {}", text(i.low), text(i.high)))
            })
        };
        let verdict = match row.verdict {
            Verdict::Better => "better",
            Verdict::Worse => "worse",
            Verdict::Baseline | Verdict::NoDifference => "",
        };
        let series = series.iter().find(|series| series.name == row.variant);
        table.rows.push(vec![
            rank.map_or_else(Datum::none, |rank| {
                Datum::number(rank as f64, format!("{rank}{}", if shared { "=" } else { "" }))
            }),
            series.map_or_else(|| Datum::text(&row.variant), Datum::series),
            Datum { class: verdict, ..Datum::text(row.verdict_text()) },
            number(row.mean, &|v| means.text(v)),
            interval(row.interval, &|v| means.text(v)),
            number(row.difference, &|v| differences.signed(v)),
            interval(row.difference_interval, &|v| differences.signed(v)),
            number(row.p, &p_value),
            number(cost_of(results, &row.variant), &|ms| significant(ms, 3)),
            Datum::number(row.cells as f64, row.cells.to_string()),
        ]);
    }
    Answer {
        metric: metric.name.clone(),
        formula: metric.formula.clone(),
        perfect: super::number::short(metric.perfect),
        better: with(Verdict::Better),
        worse: with(Verdict::Worse),
        same: with(Verdict::NoDifference),
        table,
    }
}

/// p-values below a thousandth are not told apart.
fn p_value(p: f64) -> String {
    if p < 0.001 { "< 0.001".into() } else { significant(p, 2) }
}
