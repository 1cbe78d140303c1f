//! The error ledger: what each stage adds to the error, as stacked figures.

use super::ReportError;
use super::draw::{PANEL, Stack, bars, bars_size, columns};
use super::figure::{Figure, Panel, Source};
use super::number::significant;
use super::series::{Marker, Series};
use super::table::{Datum, Table};
use crate::ledger::{COUNTS_AS, reference_noise};
use crate::record::{CellRecord, LedgerRecord};

/// Name of what the parts do not explain.
const INTERACTION: &str = "interaction";

/// The figures of the ledger: over the frame's mean, and for each frame.
pub fn figures(source: &Source<'_>) -> Result<Vec<Figure>, ReportError> {
    // A study splits one metric; a cell of another one, or with other stages, would not add up with the rest.
    let Some(first) = source.results.cells.iter().find_map(|cell| cell.ledger.as_ref()) else {
        return Ok(vec![]);
    };
    let stages: Vec<&str> = first.parts.iter().map(|(stage, _)| stage.as_str()).collect();
    let alike = |ledger: &LedgerRecord| {
        ledger.metric == first.metric
            && ledger.parts.iter().map(|(stage, _)| stage.as_str()).eq(stages.iter().copied())
    };
    let of = |cell: &&CellRecord| cell.ledger.as_ref().is_some_and(alike);
    let cells: Vec<&CellRecord> = source.results.cells.iter().filter(of).collect();

    let mut series: Vec<Series> =
        stages.iter().enumerate().map(|(number, stage)| Series::numbered(stage, number)).collect();
    series.push(Series::rest(INTERACTION));
    // Bars have no markers: the legend shows squares.
    series.iter_mut().for_each(|series| series.marker = Marker::Square);
    let variants: Vec<(&Series, Vec<&LedgerRecord>)> = source
        .series
        .iter()
        .map(|series| {
            let cells = cells.iter().filter(|cell| cell.variant == series.name);
            (series, cells.filter_map(|cell| cell.ledger.as_ref()).collect())
        })
        .filter(|(_, ledgers): &(_, Vec<_>)| !ledgers.is_empty())
        .collect();
    let mut figures = vec![whole(first, &variants, &series)?];
    figures.extend(frames(first, &variants, &series, &cells)?);
    Ok(figures)
}

fn heads<'a>(first: &'a [&'a str], series: &'a [Series], last: &'a [&'a str]) -> Table {
    let stages: Vec<String> = series.iter().map(|series| format!("#{}", series.name)).collect();
    Table::new(
        first
            .iter()
            .copied()
            .chain(stages.iter().map(String::as_str))
            .chain(["#Total"])
            .chain(last.iter().copied()),
    )
}

fn numbers(stack: &Stack) -> impl Iterator<Item = Datum> + '_ {
    stack.parts.iter().chain([&stack.total]).map(|value| Datum::value(Some(*value)))
}

/// The mean of ledgers: parts, interaction and total alike, so that they still add up.
fn mean(label: &str, ledgers: &[&LedgerRecord]) -> Stack {
    let n = ledgers.len() as f64;
    let mean =
        |value: &dyn Fn(&LedgerRecord) -> f64| ledgers.iter().map(|ledger| value(ledger)).sum::<f64>() / n;
    let stages = ledgers.iter().map(|ledger| ledger.parts.len()).min().unwrap_or(0);
    let parts = (0..stages).map(|stage| mean(&|ledger| ledger.parts[stage].1));
    let parts = parts.chain([mean(&|ledger| ledger.interaction)]).collect();
    Stack { label: label.into(), parts, total: mean(&|ledger| ledger.total) }
}

fn whole(
    first: &LedgerRecord,
    variants: &[(&Series, Vec<&LedgerRecord>)],
    series: &[Series],
) -> Result<Figure, ReportError> {
    let title = format!("Error ledger of {}", first.metric);
    let mut table = heads(&["Variant", "#Cells"], series, &["#Noise of the reference"]);
    let mut stacks = Vec::new();
    for (variant, ledgers) in variants {
        let stack = mean(&variant.name, ledgers);
        let head = [Datum::series(variant), Datum::number(ledgers.len() as f64, ledgers.len().to_string())];
        let noise = [Datum::value(reference_noise(ledgers.iter().copied()))];
        table.rows.push(head.into_iter().chain(numbers(&stack)).chain(noise).collect());
        stacks.push(stack);
    }
    let svg = bars(&stacks, series, &first.metric)
        .map_err(|cause| ReportError::Figure { title: title.clone(), cause })?;
    let noise = reference_noise(variants.iter().flat_map(|(_, ledgers)| ledgers.iter().copied()));
    let noise = noise.map_or(String::new(), |noise| {
        format!(
            " Noise of the reference: {}, the {} that a perfect frame has; {COUNTS_AS}.",
            significant(noise, 2),
            first.metric
        )
    });
    let caption = format!(
        "What {} loses when a stage is fed with ground truth, mean over the cells of a variant. Parts that are below 0 are on the left of 0: \
         there, ground truth makes the frame worse. The interaction is what the parts do not explain; parts and interaction add up to the total, \
         the vertical mark.{noise}",
        first.metric
    );
    let panels = vec![Panel { title: "All views".into(), svg, size: bars_size(stacks.len()) }];
    Ok(Figure { id: "ledger".into(), title, caption, legend: series.to_vec(), panels, wide: true, table })
}

fn frames(
    first: &LedgerRecord,
    variants: &[(&Series, Vec<&LedgerRecord>)],
    series: &[Series],
    cells: &[&CellRecord],
) -> Result<Option<Figure>, ReportError> {
    let title = format!("Error ledger of {} per frame", first.metric);
    let first_frame = cells.iter().map(|cell| cell.first_frame).min().unwrap_or(0);
    let mut table = heads(&["Variant", "#Frame"], series, &[]);
    let mut panels = Vec::new();
    for (variant, ledgers) in variants {
        let count = ledgers.iter().map(|ledger| ledger.frames.len()).min().unwrap_or(0);
        let frame = |index: usize| {
            let frames: Vec<&LedgerRecord> = ledgers.iter().map(|ledger| &ledger.frames[index]).collect();
            mean("", &frames)
        };
        let stacks: Vec<Stack> =
            (0..count).map(frame).filter(|stack| stack.parts.len() == series.len()).collect();
        if stacks.is_empty() {
            continue;
        }
        for (number, stack) in (first_frame..).zip(&stacks) {
            let head = [Datum::series(variant), Datum::number(f64::from(number), number.to_string())];
            table.rows.push(head.into_iter().chain(numbers(stack)).collect());
        }
        let svg = columns(&stacks, first_frame, series, &first.metric)
            .map_err(|cause| ReportError::Figure { title: title.clone(), cause })?;
        panels.push(Panel { title: variant.name.clone(), svg, size: PANEL });
    }
    let caption = format!(
        "The same for each frame, mean over the cells of a variant; the total is the horizontal mark. Horizontal: number of the frame. Vertical: {}.",
        first.metric
    );
    let legend = series.to_vec();
    Ok((!panels.is_empty()).then_some(Figure {
        id: "ledger-frames".into(),
        title,
        caption,
        legend,
        panels,
        wide: false,
        table,
    }))
}
