//! The figure of a study as a file of its own, for a page of findings: the error of the first metric over GPU time, a panel for each view, over
//! frames beside it where a study measures enough of them, and the error ledger below.

use super::figure::{Figure, Panel, Source};
use super::input::Results;
use super::ledger;
use super::series::{Series, series};
use super::{ReportError, render_template};
use serde::Serialize;
use std::path::Path;

/// Measured frames of a cell from which on a curve over frames says more than its mean.
const MANY_FRAMES: usize = 8;
/// Height of the title of a panel, and of a line of the legend.
const LINE: u32 = 22;
/// Width of a letter of the legend, at most.
const LETTER: u32 = 8;
const MARGIN: u32 = 18;

/// What the template places.
#[derive(Default, Serialize)]
struct Sheet {
    width: u32,
    height: u32,
    panels: Vec<Placed>,
    legend: Vec<Entry>,
}

#[derive(Serialize)]
struct Placed {
    x: u32,
    y: u32,
    /// Where the middle of the title is, from the left of the panel.
    middle: u32,
    title: String,
    svg: String,
}

#[derive(Serialize)]
struct Entry {
    x: u32,
    y: u32,
    series: Series,
}

/// The figure of a result folder as the text of an SVG file.
///
/// # Errors
/// [`ReportError`]: the folder does not hold the results of a study, or the study has nothing to draw.
pub fn figure_svg(folder: &Path) -> Result<String, ReportError> {
    let results = Results::read(folder)?;
    let study = &results.study;
    let series = series(study.variants.iter().map(|variant| variant.name.as_str()), Some(&study.baseline));
    let source = Source::new(&results, &series);
    let mut errors = Vec::new();
    if let Some(metric) = study.metrics.first() {
        let many = |frames: &Vec<Option<f64>>| frames.iter().filter(|v| v.is_some()).count() >= MANY_FRAMES;
        if results.cells.iter().any(|cell| cell.frames.get(&metric.name).is_some_and(many)) {
            errors.extend(source.over_frames(metric)?);
        }
        errors.extend(source.over_cost(metric)?);
    }
    let mut sheet = Sheet::default();
    sheet.add(interleaved(errors), &series);
    if let Some(ledger) = ledger::figures(&source)?.into_iter().next() {
        sheet.add(ledger.panels, &ledger.legend);
    }
    if sheet.panels.is_empty() {
        return Err(ReportError::Figure { title: study.name.clone(), cause: "no cell has a value".into() });
    }
    render_template("figure.xml", &sheet)
}

/// The panels of all figures, view by view.
fn interleaved(figures: Vec<Figure>) -> Vec<Panel> {
    let views = figures.iter().map(|figure| figure.panels.len()).max().unwrap_or(0);
    let mut figures: Vec<_> = figures.into_iter().map(|figure| figure.panels.into_iter()).collect();
    (0..views).flat_map(|_| figures.iter_mut().filter_map(Iterator::next).collect::<Vec<_>>()).collect()
}

impl Sheet {
    /// Adds panels below what is there, two beside each other unless they are wide, and their legend below them.
    fn add(&mut self, panels: Vec<Panel>, series: &[Series]) {
        let Some(widest) = panels.iter().map(|panel| panel.size.0).max() else { return };
        self.width = self.width.max(if panels.len() == 1 { widest } else { 2 * super::draw::PANEL.0 });
        let (mut x, mut row) = (0, 0);
        for Panel { title, svg, size } in panels {
            if x + size.0 > self.width {
                self.height += row;
                (x, row) = (0, 0);
            }
            self.panels.push(Placed { x, y: self.height, middle: size.0 / 2, title, svg });
            x += size.0;
            row = row.max(size.1 + LINE);
        }
        self.height += row + LINE / 2;
        let mut x = MARGIN;
        for series in series {
            let room = LETTER * series.name.chars().count() as u32 + 2 * MARGIN;
            if x + room > self.width && x > MARGIN {
                self.height += LINE;
                x = MARGIN;
            }
            self.legend.push(Entry { x, y: self.height, series: series.clone() });
            x += room;
        }
        self.height += LINE;
    }
}
