//! Figures as SVG: curves, points with intervals, stacked bars.
//!
//! They hold no name of a variant but in labels of bars; legends are part of the page.

use super::axis::Axis;
use super::series::{GRID, INK, Marker, Series};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Size of a panel, in units of the page (CSS pixels): two fit beside each other on a wide screen, one on a telephone.
pub const PANEL: (u32, u32) = (500, 310);
/// Height of a bar and its gap.
const BAR: u32 = 30;
/// Room for the labels of bars.
const BAR_LABELS: i32 = 170;
/// Letters of a label of a bar.
const BAR_LETTERS: usize = 18;
/// The library divides sizes of fonts by 1.24.
const FONT: (&str, f64) = ("sans-serif", 13.0 * 1.24);
/// Radius of a marker.
const RADIUS: i32 = 4;
/// About how many markers a curve has.
const MARKERS: usize = 8;

/// A point with the interval of its y.
#[derive(Clone, Copy)]
pub struct Point {
    pub x: f64,
    pub y: f64,
    pub y_interval: Option<(f64, f64)>,
}

/// The points of one series.
pub struct Points<'a> {
    pub series: &'a Series,
    pub points: Vec<Point>,
}

/// What the library reports.
type Failure = DrawingAreaErrorKind<std::io::Error>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Axis, Axis>>;

fn svg(size: (u32, u32), draw: impl FnOnce(&Area<'_>) -> Result<(), Failure>) -> Result<String, String> {
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        draw(&area).and_then(|()| area.present()).map_err(|failure| failure.to_string())?;
    }
    Ok(svg)
}

fn axes<'a, 'b>(area: &'a Area<'b>, x: &Axis, y: &Axis, left: u32) -> Result<Chart<'a, 'b>, Failure> {
    let text = FONT.into_font().color(&INK);
    let mut chart = ChartBuilder::on(area)
        .margin_top(8)
        .margin_right(14)
        .x_label_area_size(46)
        .y_label_area_size(left)
        .build_cartesian_2d(x.clone(), y.clone())?;
    chart
        .configure_mesh()
        .axis_style(INK)
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .label_style(text.clone())
        .axis_desc_style(text)
        .x_desc(x.label.as_str())
        .y_desc(y.label.as_str())
        .draw()?;
    Ok(chart)
}

/// A marker at a pixel.
fn marker(area: &Area<'_>, series: &Series, (x, y): (i32, i32)) -> Result<(), Failure> {
    let filled = series.color.filled();
    let r = RADIUS;
    let shape = |corners: &[(i32, i32)]| {
        let corners: Vec<_> = corners.iter().map(|(dx, dy)| (x + dx, y + dy)).collect();
        area.draw(&Polygon::new(corners, filled))
    };
    match series.marker {
        Marker::Circle => area.draw(&Circle::new((x, y), r, filled)),
        Marker::Square => shape(&[(-r, -r), (r, -r), (r, r), (-r, r)]),
        Marker::Triangle => shape(&[(0, -r - 1), (r + 1, r), (-r - 1, r)]),
        Marker::Diamond => shape(&[(0, -r - 2), (r + 2, 0), (0, r + 2), (-r - 2, 0)]),
        Marker::Cross => area.draw(&Cross::new((x, y), r, series.color.stroke_width(3))),
    }
}

fn values<'a>(all: &'a [Points<'a>], y: bool) -> impl Iterator<Item = f64> + 'a {
    all.iter().flat_map(|points| &points.points).flat_map(move |p| {
        let (at, interval) = if y { (p.y, p.y_interval) } else { (p.x, None) };
        // The lower end of an interval of errors may be below 0, where a logarithmic axis has no place.
        let ends = interval.map(|(low, high)| [if low > 0.0 { low.max(0.2 * at) } else { at }, high]);
        [Some(at), ends.map(|e| e[0]), ends.map(|e| e[1])].into_iter().flatten()
    })
}

/// Curves over frames, each with the band of its intervals.
pub fn curves(
    all: &[Points<'_>],
    x_label: &str,
    y_label: &str,
    may_be_logarithmic: bool,
) -> Result<String, String> {
    let x = Axis::of(x_label, values(all, false), false, false).whole();
    let y = Axis::of(y_label, values(all, true), false, may_be_logarithmic);
    svg(PANEL, |area| {
        let mut chart = axes(area, &x, &y, y.text_width())?;
        for Points { series, points } in all {
            let band: Vec<_> = points
                .iter()
                .filter_map(|p| {
                    let (low, high) = p.y_interval?;
                    Some((p.x, y.position(low).unwrap_or(y.low).max(y.low), y.position(high)?.min(y.high)))
                })
                .collect();
            if band.len() > 1 {
                let edge = band.iter().map(|b| (b.0, b.2)).chain(band.iter().rev().map(|b| (b.0, b.1)));
                chart
                    .draw_series([Polygon::new(edge.collect::<Vec<_>>(), series.color.mix(0.16).filled())])?;
            }
        }
        for (number, Points { series, points }) in all.iter().enumerate() {
            let line: Vec<_> = points.iter().filter_map(|p| Some((p.x, y.position(p.y)?))).collect();
            chart.draw_series([PathElement::new(line.clone(), series.color.stroke_width(2))])?;
            // Markers of different curves at different frames, so that curves on top of each other are seen.
            let every = line.len().div_ceil(MARKERS).max(1);
            for at in line.iter().skip(number % every).step_by(every) {
                marker(area, series, chart.backend_coord(at))?;
            }
        }
        Ok(())
    })
}

/// Points with their intervals.
pub fn points(
    all: &[Points<'_>],
    x_label: &str,
    y_label: &str,
    may_be_logarithmic: bool,
) -> Result<String, String> {
    let x = Axis::of(x_label, values(all, false), false, true);
    let y = Axis::of(y_label, values(all, true), false, may_be_logarithmic);
    svg(PANEL, |area| {
        let chart = axes(area, &x, &y, y.text_width())?;
        for Points { series, points } in all {
            for p in points {
                let (Some(px), Some(py)) = (x.position(p.x), y.position(p.y)) else { continue };
                let end = |value: f64| y.position(value).unwrap_or(y.low).clamp(y.low, y.high);
                if let Some((low, high)) = p.y_interval {
                    let ends = [low, high].map(|at| chart.backend_coord(&(px, end(at))));
                    area.draw(&PathElement::new(ends, series.color.stroke_width(2)))?;
                }
                marker(area, series, chart.backend_coord(&(px, py)))?;
            }
        }
        Ok(())
    })
}

/// Parts of a sum, in their order, and the sum.
pub struct Stack {
    pub label: String,
    pub parts: Vec<f64>,
    pub total: f64,
}

impl Stack {
    /// From where to where each part reaches: positive parts to the right of 0, negative ones to the left.
    fn reaches(&self) -> Vec<(f64, f64)> {
        let (mut right, mut left) = (0.0, 0.0);
        let place = |part: &f64| {
            let end = if *part < 0.0 { &mut left } else { &mut right };
            let from = *end;
            *end += part;
            (from, *end)
        };
        self.parts.iter().map(place).collect()
    }

    fn extent<'a>(stacks: &'a [Self]) -> impl Iterator<Item = f64> + 'a {
        stacks.iter().flat_map(|stack| {
            stack
                .reaches()
                .into_iter()
                .flat_map(|(from, to)| [from, to])
                .chain([stack.total])
                .collect::<Vec<_>>()
        })
    }
}

/// Size of stacked bars, in units of the page.
pub fn bars_size(stacks: usize) -> (u32, u32) {
    (2 * PANEL.0, BAR * stacks as u32 + 60)
}

/// Stacked bars side by side below each other, one for each stack, with a mark at its total.
pub fn bars(stacks: &[Stack], series: &[Series], x_label: &str) -> Result<String, String> {
    let x = Axis::of(x_label, Stack::extent(stacks), true, false);
    let count = stacks.len();
    let y = Axis { label: String::new(), logarithmic: false, low: 0.0, high: count as f64, marks: vec![] };
    svg(bars_size(count), |area| {
        let mut chart = axes(area, &x, &y, BAR_LABELS as u32)?;
        for (row, stack) in stacks.iter().enumerate() {
            let bottom = (count - 1 - row) as f64;
            for ((from, to), series) in stack.reaches().into_iter().zip(series) {
                if from != to {
                    let corners = [(from, bottom + 0.18), (to, bottom + 0.82)];
                    chart.draw_series([Rectangle::new(corners, series.color.filled())])?;
                }
            }
            let total = vec![(stack.total, bottom + 0.04), (stack.total, bottom + 0.96)];
            chart.draw_series([PathElement::new(total, INK.stroke_width(3))])?;
            let (left, height) = chart.backend_coord(&(x.low, bottom + 0.5));
            let style = FONT.into_font().color(&INK).pos(Pos::new(HPos::Right, VPos::Center));
            area.draw(&Text::new(shortened(&stack.label), (left - 8, height), style))?;
        }
        Ok(())
    })
}

/// Stacked columns over frames, with a mark at each total.
pub fn columns(
    stacks: &[Stack],
    first_frame: u32,
    series: &[Series],
    y_label: &str,
) -> Result<String, String> {
    let first = f64::from(first_frame);
    let ends = [first - 0.5, first + stacks.len() as f64 - 0.5];
    let x = Axis::of("frame", ends.into_iter(), false, false).whole();
    let y = Axis::of(y_label, Stack::extent(stacks), true, false);
    svg(PANEL, |area| {
        let mut chart = axes(area, &x, &y, y.text_width())?;
        for (frame, stack) in (0..).map(|n| first + f64::from(n)).zip(stacks) {
            for ((from, to), series) in stack.reaches().into_iter().zip(series) {
                if from != to {
                    let corners = [(frame - 0.4, from), (frame + 0.4, to)];
                    chart.draw_series([Rectangle::new(corners, series.color.filled())])?;
                }
            }
            let total = vec![(frame - 0.45, stack.total), (frame + 0.45, stack.total)];
            chart.draw_series([PathElement::new(total, INK.stroke_width(2))])?;
        }
        Ok(())
    })
}

fn shortened(label: &str) -> String {
    if label.chars().count() <= BAR_LETTERS {
        return label.into();
    }
    label.chars().take(BAR_LETTERS - 1).chain(['…']).collect()
}

#[cfg(test)]
mod tests {
    use super::super::series::Series;
    use super::*;

    #[test]
    fn stacks_add_up_on_each_side_of_zero() {
        let stack = Stack { label: String::new(), parts: vec![2.0, -1.0, 3.0, -0.5], total: 3.5 };
        assert_eq!(stack.reaches(), [(0.0, 2.0), (0.0, -1.0), (2.0, 5.0), (-1.0, -1.5)]);
    }

    #[test]
    fn figures_draw_what_they_can_and_escape_labels() {
        let series = Series::numbered("a", 0);
        let point = |x: f64, y: f64| Point { x, y, y_interval: Some((y - 0.1, y + 0.1)) };
        let all =
            [Points { series: &series, points: vec![point(1.0, 0.05), point(2.0, 5.0), point(3.0, 0.0)] }];
        let svg = curves(&all, "frame", "relMSE", true).unwrap();
        assert!(svg.contains("<polyline") && svg.contains("#0072B2") && !svg.contains("NaN"), "{svg}");
        let none: [Points<'_>; 0] = [];
        assert!(points(&none, "ms", "error", true).unwrap().contains("</svg>"));
        let stack = Stack { label: "<b>".into(), parts: vec![1.0], total: 1.0 };
        let svg = bars(&[stack], &[series], "error").unwrap();
        assert!(svg.contains("&lt;b&gt;") && !svg.contains("<b>"), "{svg}");
    }
}
