//! The answer of a study on the terminal.

use anyhow::Result;
use pt_study::cost::gpu_time;
use pt_study::ledger::{COUNTS_AS, reference_noise};
use pt_study::record::{CellRecord, StudyRecord, TimingRecord};
use pt_study::statistics::Interval;
use pt_study::summary::{SummaryRow, few_seeds, summarize};
use std::collections::BTreeMap;
use std::io::Write;

/// Prints a table for each metric: the variants from the best to the worst, those that are not told apart from the baseline beside it.
///
/// # Errors
/// When the output is closed.
pub fn print(study: &StudyRecord, cells: &[CellRecord], out: &mut impl Write) -> Result<()> {
    writeln!(out, "{}: {}", study.name, study.question)?;
    writeln!(out, "{}, {}, {} cells", study.device, study.driver, cells.len())?;
    let width = study.variants.iter().map(|v| v.name.chars().count()).max().unwrap_or(0).max(7);
    for (summary, metric) in summarize(study, cells).iter().zip(&study.metrics) {
        writeln!(out, "\n{}: {} (perfect: {})", metric.name, metric.formula, metric.perfect)?;
        writeln!(
            out,
            "{:<width$}  {:>5}  {:>10}  {:>23}  {:>11}  {:>25}  {:>7}  verdict",
            "variant", "cells", "mean", "95 % interval", "difference", "95 % interval", "p"
        )?;
        for row in summary.ranked() {
            let [mean, of_mean, difference, of_difference, p, verdict] = columns(row);
            writeln!(
                out,
                "{:<width$}  {:>5}  {mean:>10}  {of_mean:>23}  {difference:>11}  {of_difference:>25}  {p:>7}  {verdict}",
                row.variant, row.cells,
            )?;
        }
    }
    let ledgers = || cells.iter().filter_map(|cell| cell.ledger.as_ref());
    if let (Some(noise), Some(first)) = (reference_noise(ledgers()), ledgers().next()) {
        writeln!(
            out,
            "\nnoise of the reference: {} of {}, which a perfect frame has; in the ledger {COUNTS_AS}",
            digits(noise),
            first.metric
        )?;
    }
    writeln!(
        out,
        "\ndifference: of the distance from the perfect value to that of the baseline ({}), paired by scene, camera, size, backend and seed; \
         p: corrected for all comparisons (Holm)",
        study.baseline
    )?;
    if let Some(sentence) = few_seeds(cells) {
        writeln!(out, "{sentence}")?;
    }
    Ok(())
}

/// The same as Markdown, with the command and the device, and the GPU time of a frame.
pub fn markdown(study: &StudyRecord, cells: &[CellRecord], timings: &[TimingRecord]) -> String {
    let mut text = format!(
        "`{}`; {} cells on {} ({}), revision {}.\n",
        study.command,
        cells.len(),
        study.device,
        study.driver,
        study.revision
    );
    if let Some(sentence) = few_seeds(cells) {
        text += &format!("\n{sentence}.\n");
    }
    let times: BTreeMap<&str, f64> = timings.iter().map(|t| (t.cell.as_str(), t.gpu_ms)).collect();
    let cost_of = |variant: &str| {
        let cells = cells.iter().filter(|cell| cell.variant == variant);
        gpu_time(cells, |cell| times.get(cell).copied())
    };
    for (summary, metric) in summarize(study, cells).iter().zip(&study.metrics) {
        text += &format!(
            "\n**{}**: {}; a perfect picture has {}.\n\n",
            metric.name, metric.formula, metric.perfect
        );
        text += "| variant | mean | 95 % interval | difference | 95 % interval | p | verdict | GPU ms |\n";
        text += "| --- | --- | --- | --- | --- | --- | --- | --- |\n";
        for row in summary.ranked() {
            let cost = number(cost_of(&row.variant));
            text +=
                &format!("| {} | {} | {cost} |\n", row.variant.replace('|', "\\|"), columns(row).join(" | "));
        }
    }
    text
}

/// Mean, its interval, difference, its interval, p-value and verdict of a variant.
fn columns(row: &SummaryRow) -> [String; 6] {
    [
        number(row.mean),
        interval(row.interval),
        signed(row.difference),
        interval(row.difference_interval),
        p_value(row.p),
        row.verdict_text().into(),
    ]
}

fn p_value(p: Option<f64>) -> String {
    p.map_or("-".into(), |p| if p < 1e-4 { "<0.0001".into() } else { format!("{p:.4}") })
}

fn number(value: Option<f64>) -> String {
    value.map_or("-".into(), digits)
}

fn signed(value: Option<f64>) -> String {
    value.map_or("-".into(), |value| if value > 0.0 { format!("+{}", digits(value)) } else { digits(value) })
}

fn interval(interval: Option<Interval>) -> String {
    interval.map_or("-".into(), |Interval { low, high }| format!("{} to {}", digits(low), digits(high)))
}

/// Four digits that count.
fn digits(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        size if (1e-3..1e4).contains(&size) => {
            let decimals = (3 - size.log10().floor() as i32).max(0) as usize;
            format!("{value:.decimals$}")
        }
        _ => format!("{value:.3e}"),
    }
}
