//! Figures of errors: over frames and over cost. Each has a table of its values.

use super::ReportError;
use super::draw::{PANEL, Point, Points, curves, points};
use super::input::Results;
use super::series::Series;
use super::table::{Datum, Table};
use crate::cost::gpu_time;
use crate::record::{CellRecord, MetricRecord, TimingRecord};
use crate::statistics::mean_and_interval;
use serde::Serialize;
use std::collections::BTreeMap;

/// A figure of one or several panels.
#[derive(Serialize)]
pub struct Figure {
    /// Name in the page.
    pub id: String,
    pub title: String,
    /// What is shown, with units.
    pub caption: String,
    /// Series by their markers, in the order of the table.
    pub legend: Vec<Series>,
    pub panels: Vec<Panel>,
    /// Whether a panel takes the whole width.
    pub wide: bool,
    pub table: Table,
}

/// A panel of a figure.
#[derive(Serialize)]
pub struct Panel {
    pub title: String,
    pub svg: String,
    /// Width and height of the picture, in units of the page.
    #[serde(skip)]
    pub size: (u32, u32),
}

/// What cells have in common that differ in variant and seed only: what they show.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct View {
    scene: String,
    camera: String,
    size: [u32; 2],
    backend: String,
}

impl View {
    pub fn of(cell: &CellRecord) -> Self {
        let (scene, camera) = (cell.scene.clone(), cell.camera.clone());
        Self { scene, camera, size: cell.size, backend: cell.backend.clone() }
    }

    /// All views, in the order of the cells.
    pub fn all(cells: &[CellRecord]) -> Vec<Self> {
        let mut views = Vec::new();
        for view in cells.iter().map(Self::of) {
            if !views.contains(&view) {
                views.push(view);
            }
        }
        views
    }

    /// Name, with what differs between the views.
    pub fn name(&self, all: &[Self]) -> String {
        let mut name = self.scene.clone();
        if !self.camera.is_empty() && all.iter().any(|view| view.camera != self.camera) {
            name += &format!(", camera {}", self.camera);
        }
        if all.iter().any(|view| view.size != self.size) {
            name += &format!(", {}x{}", self.size[0], self.size[1]);
        }
        if all.iter().any(|view| view.backend != self.backend) {
            name += &format!(", {}", self.backend);
        }
        name
    }
}

/// What all panels are drawn from.
pub struct Source<'a> {
    pub results: &'a Results,
    pub series: &'a [Series],
    pub views: Vec<View>,
}

impl<'a> Source<'a> {
    pub fn new(results: &'a Results, series: &'a [Series]) -> Self {
        Self { results, series, views: View::all(&results.cells) }
    }

    pub fn cells_of<'s>(
        &'s self,
        view: &'s View,
        variant: &'s str,
    ) -> impl Iterator<Item = &'a CellRecord> + 's {
        let cells: &'a [CellRecord] = &self.results.cells;
        cells.iter().filter(move |cell| cell.variant == variant && View::of(cell) == *view)
    }

    /// Error over frames: a panel for each view, the mean over seeds with its interval.
    pub fn over_frames(&self, metric: &MetricRecord) -> Result<Option<Figure>, ReportError> {
        let title = format!("{} over frames", metric.name);
        let mut table = Table::new(["View", "Variant", "#Frame", "#Mean", "#Low", "#High", "#Seeds"]);
        let mut panels = Vec::new();
        for view in &self.views {
            let name = view.name(&self.views);
            let mut drawn = Vec::new();
            for series in self.series {
                let mut frames: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
                for cell in self.cells_of(view, &series.name) {
                    let values = cell.frames.get(&metric.name).into_iter().flatten();
                    for (frame, value) in (cell.first_frame..).zip(values) {
                        frames.entry(frame).or_default().extend(value);
                    }
                }
                let mut points = Vec::new();
                for (frame, values) in frames {
                    let (Some(y), interval) = mean_and_interval(&[&values]) else { continue };
                    table.rows.push(vec![
                        Datum::text(&name),
                        Datum::series(series),
                        Datum::number(f64::from(frame), frame.to_string()),
                        Datum::value(Some(y)),
                        Datum::value(interval.map(|i| i.low)),
                        Datum::value(interval.map(|i| i.high)),
                        Datum::number(values.len() as f64, values.len().to_string()),
                    ]);
                    let y_interval = interval.map(|i| (i.low, i.high));
                    points.push(Point { x: f64::from(frame), y, y_interval });
                }
                if !points.is_empty() {
                    drawn.push(Points { series, points });
                }
            }
            if drawn.is_empty() {
                continue;
            }
            let svg = curves(&drawn, "frame", &metric.name, metric.perfect == 0.0)
                .map_err(|cause| ReportError::Figure { title: title.clone(), cause })?;
            panels.push(Panel { title: name, svg, size: PANEL });
        }
        let caption = format!(
            "{}, mean over seeds; the band is the 95 % interval of the mean. A perfect picture has {}. Horizontal: number of the frame.",
            metric.name,
            super::number::short(metric.perfect)
        );
        Ok(self.figure("frames", metric, title, caption, panels, table))
    }

    /// Error over GPU time: a panel for each view, a point for each variant.
    pub fn over_cost(&self, metric: &MetricRecord) -> Result<Option<Figure>, ReportError> {
        let title = format!("{} over GPU time", metric.name);
        let mut table = Table::new([
            "View",
            "Variant",
            "#GPU ms",
            "#95th percentile, ms",
            "#Mean",
            "#Low",
            "#High",
            "#Cells",
        ]);
        let mut panels = Vec::new();
        for view in &self.views {
            let name = view.name(&self.views);
            let mut drawn = Vec::new();
            for series in self.series {
                let cells = || self.cells_of(view, &series.name);
                let values: Vec<f64> =
                    cells().filter_map(|cell| cell.metrics.get(&metric.name).copied().flatten()).collect();
                let time = |of: fn(&TimingRecord) -> f64| {
                    gpu_time(cells(), |cell| self.results.timings.get(cell).map(of))
                };
                let (Some(x), (Some(y), y_interval)) = (time(|t| t.gpu_ms), mean_and_interval(&[&values]))
                else {
                    continue;
                };
                table.rows.push(vec![
                    Datum::text(&name),
                    Datum::series(series),
                    Datum::value(Some(x)),
                    Datum::value(time(|t| t.gpu_ms_p95)),
                    Datum::value(Some(y)),
                    Datum::value(y_interval.map(|i| i.low)),
                    Datum::value(y_interval.map(|i| i.high)),
                    Datum::number(values.len() as f64, values.len().to_string()),
                ]);
                let ends = |i: crate::statistics::Interval| (i.low, i.high);
                let point = Point { x, y, y_interval: y_interval.map(ends) };
                drawn.push(Points { series, points: vec![point] });
            }
            if drawn.is_empty() {
                continue;
            }
            let svg = points(&drawn, "GPU time of a frame, ms", &metric.name, metric.perfect == 0.0)
                .map_err(|cause| ReportError::Figure { title: title.clone(), cause })?;
            panels.push(Panel { title: name, svg, size: PANEL });
        }
        let caption = format!(
            "{}, mean over seeds with its 95 % interval, against the GPU time of a frame in milliseconds (median over its frames), the least of the seeds. \
             A perfect picture has {}.",
            metric.name,
            super::number::short(metric.perfect)
        );
        Ok(self.figure("cost", metric, title, caption, panels, table))
    }

    fn figure(
        &self,
        kind: &str,
        metric: &MetricRecord,
        title: String,
        caption: String,
        panels: Vec<Panel>,
        table: Table,
    ) -> Option<Figure> {
        let number = self.results.study.metrics.iter().position(|m| m.name == metric.name)?;
        let id = format!("{kind}-{number}");
        let legend = self.series.to_vec();
        (!panels.is_empty()).then_some(Figure { id, title, caption, legend, panels, wide: false, table })
    }
}
