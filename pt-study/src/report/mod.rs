//! The report of a result folder: one HTML file that is opened from disk and asks no network for anything.
//!
//! The page is `page.html` with `page.css` and `page.js`; the template library escapes whatever is inserted. Figures are SVG of the plotting
//! library, pictures are data URIs.

mod answer;
mod axis;
mod draw;
mod error;
mod figure;
mod figure_file;
mod input;
mod ledger;
mod number;
mod pictures;
mod provenance;
mod rank;
mod series;
mod table;

pub use error::ReportError;
pub use figure_file::figure_svg;

use crate::record::StudyRecord;
use crate::summary::{few_seeds, summarize};
use answer::Answer;
use figure::{Figure, Source};
use input::Results;
use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{Environment, UndefinedBehavior};
use pictures::Pictures;
use provenance::Fact;
use serde::Serialize;
use series::{Series, series};
use std::path::{Path, PathBuf};
use table::Table;

/// Name of the report in its folder.
pub const REPORT: &str = "report.html";
/// Bytes that a report may have: it is sent by mail and opened from disk.
const LIMIT: usize = 20_000_000;

/// All that the page shows.
#[derive(Serialize)]
struct Page<'a> {
    study: &'a StudyRecord,
    series: &'a [Series],
    answers: Vec<Answer>,
    /// What few seeds mean for the intervals.
    few_seeds: Option<String>,
    /// Error of the first metric over frames.
    frames: Option<Figure>,
    /// The same over GPU time.
    cost: Option<Figure>,
    passes: Option<Table>,
    /// Figures of the other metrics.
    more: Vec<Figure>,
    ledger: Vec<Figure>,
    pictures: Pictures,
    facts: Vec<Fact>,
    knobs: Table,
    commands: Table,
    /// Cells that the table of commands leaves out.
    commands_left_out: usize,
    style: &'static str,
    script: &'static str,
}

/// Writes the report of a result folder beside its results. Returns its path.
///
/// # Errors
/// [`ReportError`]: the folder does not hold the results of a study, or the file cannot be written.
pub fn write(folder: &Path) -> Result<PathBuf, ReportError> {
    let results = Results::read(folder)?;
    let html = render(&results, folder, LIMIT)?;
    let path = folder.join(REPORT);
    pt_image::atomic_file::write_atomic(&path, html.as_bytes())?;
    Ok(path)
}

fn render(results: &Results, folder: &Path, limit: usize) -> Result<String, ReportError> {
    let study = &results.study;
    let series = series(study.variants.iter().map(|variant| variant.name.as_str()), Some(&study.baseline));
    let source = Source::new(results, &series);
    let (mut frames, mut cost, mut more) = (None, None, Vec::new());
    for (number, metric) in study.metrics.iter().enumerate() {
        let (over_frames, over_cost) = (source.over_frames(metric)?, source.over_cost(metric)?);
        if number == 0 {
            (frames, cost) = (over_frames, over_cost);
        } else {
            more.extend(over_frames.into_iter().chain(over_cost));
        }
    }
    let (commands, commands_left_out) = provenance::commands(results);
    let mut page = Page {
        study,
        series: &series,
        answers: answer::answers(results, &summarize(study, &results.cells), &series),
        few_seeds: few_seeds(&results.cells),
        frames,
        cost,
        passes: provenance::passes(results),
        more,
        ledger: ledger::figures(&source)?,
        pictures: Pictures::default(),
        facts: provenance::facts(results),
        knobs: provenance::knobs(study),
        commands,
        commands_left_out,
        style: include_str!("page.css"),
        script: include_str!("page.js"),
    };
    // The pictures get the room that the rest leaves. The first pass embeds none, so that its page tells the size of the rest.
    page.pictures = pictures::pictures(&source, folder, 0);
    let rest = fill_in(&page)?.len();
    // The lists of the viewer grow with the pictures: names and values of each.
    let lists: usize =
        results.cells.iter().map(|cell| 600 + 60 * cell.metrics.len() + cell.variant.len()).sum();
    let room = limit.checked_sub(rest + lists).ok_or(ReportError::Size { bytes: rest + lists, limit })?;
    page.pictures = pictures::pictures(&source, folder, room);
    fill_in(&page)
}

fn fill_in(page: &Page<'_>) -> Result<String, ReportError> {
    render_template("page.html", page)
}

/// Fills in one of the templates; their names say that what is inserted is escaped.
fn render_template(name: &str, values: &impl Serialize) -> Result<String, ReportError> {
    let failed = |error: minijinja::Error| ReportError::Template(format!("{error:#}"));
    let mut templates = Environment::new();
    // A name that is not there is a fault of the template, not an empty text.
    templates.set_undefined_behavior(UndefinedBehavior::Strict);
    templates
        .set_syntax(SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build().map_err(failed)?);
    let files = [
        ("parts.html", include_str!("parts.html")),
        ("page.html", include_str!("page.html")),
        ("figure.xml", include_str!("figure.svg")),
    ];
    for (name, text) in files {
        templates.add_template(name, text).map_err(failed)?;
    }
    templates.get_template(name).and_then(|template| template.render(Serde(values))).map_err(failed)
}
