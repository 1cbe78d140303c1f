//! The figure of a study as a file of its own, for a page of findings: the error of the first metric over GPU time, a panel for each view, and
//! over frames beside it where a study measures enough of them.

use super::draw::PANEL;
use super::figure::{Panel, Source};
use super::input::Results;
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
const MARGIN: u32 = 10;

#[derive(Serialize)]
struct Sheet {
    width: u32,
    height: u32,
    panel_width: u32,
    panels: Vec<Placed>,
    legend: Vec<Entry>,
}

#[derive(Serialize)]
struct Placed {
    x: u32,
    y: u32,
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
    let series =
        series(results.study.variants.iter().map(|v| v.name.as_str()), Some(&results.study.baseline));
    let source = Source::new(&results, &series);
    let title = || ReportError::Figure {
        title: results.study.name.clone(),
        cause: "there is no cell with a value".into(),
    };
    let metric = results.study.metrics.first().ok_or_else(title)?;
    let many = results
        .cells
        .iter()
        .any(|cell| cell.frames.get(&metric.name).is_some_and(|f| f.len() >= MANY_FRAMES));
    let frames = if many { source.over_frames(metric)? } else { None };
    let cost = source.over_cost(metric)?;
    let figures: Vec<_> = frames.into_iter().chain(cost).collect();
    if figures.is_empty() {
        return Err(title());
    }
    let columns = if many { figures.len() } else { 2 };
    let panels: Vec<Panel> = interleaved(figures.into_iter().map(|figure| figure.panels).collect());
    render_template("figure.xml", &sheet(panels, columns as u32, &series))
}

/// The panels of all figures, view by view.
fn interleaved(figures: Vec<Vec<Panel>>) -> Vec<Panel> {
    let views = figures.iter().map(Vec::len).max().unwrap_or(0);
    let mut figures: Vec<_> = figures.into_iter().map(Vec::into_iter).collect();
    (0..views).flat_map(|_| figures.iter_mut().filter_map(Iterator::next).collect::<Vec<_>>()).collect()
}

/// Places panels in rows, and the legend below them.
fn sheet(panels: Vec<Panel>, columns: u32, series: &[Series]) -> Sheet {
    let columns = columns.min(panels.len() as u32).max(1);
    let (width, row) = (columns * PANEL.0, PANEL.1 + LINE);
    let rows = (panels.len() as u32).div_ceil(columns);
    let placed = (0..)
        .zip(panels)
        .map(|(n, Panel { title, svg })| Placed {
            x: n % columns * PANEL.0,
            y: n / columns * row,
            title,
            svg,
        })
        .collect();
    let (mut x, mut y) = (MARGIN + 8, rows * row + LINE);
    let mut legend = Vec::new();
    for series in series {
        let room = 13 + LETTER * series.name.chars().count() as u32 + 2 * MARGIN;
        if x + room > width && x > MARGIN + 8 {
            (x, y) = (MARGIN + 8, y + LINE);
        }
        legend.push(Entry { x, y, series: series.clone() });
        x += room;
    }
    Sheet { width, height: y + LINE, panel_width: PANEL.0, panels: placed, legend }
}
