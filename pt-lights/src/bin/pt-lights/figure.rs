//! Error against GPU time as an SVG file.

use super::measure::Measured;
use anyhow::{Context, Result, anyhow};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

const SIZE: (u32, u32) = (860, 520);
/// Room for the names on the right.
const NAMES: i32 = 210;
/// Distance of two names.
const LINE: i32 = 17;
const FONT: (&str, i32) = ("sans-serif", 14);
/// Text and axes: as far from white as from black, for pages of either kind.
const INK: RGBColor = RGBColor(118, 118, 118);
/// Colours of the curves, all of a middle lightness.
const COLORS: [RGBColor; 9] = [
    RGBColor(138, 138, 138),
    RGBColor(214, 96, 77),
    RGBColor(67, 127, 196),
    RGBColor(58, 152, 88),
    RGBColor(196, 128, 32),
    RGBColor(148, 103, 189),
    RGBColor(30, 156, 160),
    RGBColor(208, 92, 150),
    RGBColor(140, 110, 80),
];

/// A curve: name, and for each number of frames the time, the error, and the ends of its interval.
pub struct Curve {
    pub name: String,
    pub points: Vec<[f64; 4]>,
}

/// The curves of a comparison. Errors that are not above 0, because they are below those of the reference, have no place on the scale.
pub fn curves(results: &[Measured]) -> Vec<Curve> {
    let curve = |m: &Measured| Curve {
        name: m.choice.name.clone(),
        points: m
            .curve
            .iter()
            .filter(|point| point.relmse.mean > 0.0)
            .map(|p| [f64::from(p.frames) * m.gpu_ms, p.relmse.mean, p.relmse.low, p.relmse.high])
            .collect(),
    };
    results.iter().map(curve).collect()
}

/// Draws the curves on logarithmic axes, with their intervals and their names at the ends.
pub fn draw(curves: &[Curve], title: &str) -> Result<String> {
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        chart(&area, curves, title)?;
        area.present().map_err(|error| anyhow!("{error}"))?;
    }
    Ok(svg)
}

fn span(values: impl Iterator<Item = f64> + Clone) -> Option<(f64, f64)> {
    let least = values.clone().fold(f64::MAX, f64::min);
    let most = values.fold(0.0, f64::max);
    (most > 0.0 && most.is_finite()).then_some((least, most))
}

fn chart(area: &DrawingArea<SVGBackend<'_>, Shift>, curves: &[Curve], title: &str) -> Result<()> {
    let points = || curves.iter().flat_map(|curve| curve.points.iter());
    let nothing =
        "--figure: no error is above that of the reference; take more samples for it, with --reference-spp";
    let (x0, x1) = span(points().map(|p| p[0])).context(nothing)?;
    let (y0, y1) = span(points().map(|p| p[1])).context(nothing)?;
    let failed = |error: DrawingAreaErrorKind<std::io::Error>| anyhow!("{error}");
    let text = FONT.into_font().color(&INK);
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 16).into_font().color(&INK))
        .margin(12)
        .margin_right(NAMES)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .build_cartesian_2d((x0 * 0.8..x1 * 1.2).log_scale(), (y0 * 0.6..y1 * 1.6).log_scale())
        .map_err(failed)?;
    chart
        .configure_mesh()
        .axis_style(INK)
        .bold_line_style(INK.mix(0.25))
        .light_line_style(TRANSPARENT)
        .label_style(text.clone())
        .axis_desc_style(text.clone())
        .x_desc("GPU time, ms (1, 2, 4, ... frames)")
        .y_desc("relMSE of the mean of the frames")
        .x_label_formatter(&|x| tick(*x))
        .y_label_formatter(&|y| format!("{y:.0e}"))
        .draw()
        .map_err(failed)?;
    let mut ends = Vec::new();
    for (curve, color) in curves.iter().zip(COLORS.iter().cycle()) {
        let line = curve.points.iter().map(|p| (p[0], p[1]));
        chart.draw_series(LineSeries::new(line.clone(), color.stroke_width(2))).map_err(failed)?;
        chart.draw_series(line.map(|at| Circle::new(at, 3, color.filled()))).map_err(failed)?;
        let bars = curve.points.iter().map(|p| {
            let ends = vec![(p[0], p[2].max(0.6 * y0)), (p[0], p[3].min(1.6 * y1))];
            PathElement::new(ends, color.stroke_width(1))
        });
        chart.draw_series(bars).map_err(failed)?;
        if let Some(last) = curve.points.last() {
            ends.push((chart.backend_coord(&(last[0], last[1])), &curve.name, color));
        }
    }
    let right = chart.plotting_area().get_pixel_range().0.end;
    ends.sort_by_key(|((_, y), ..)| *y);
    let heights = apart(&ends.iter().map(|((_, y), ..)| *y).collect::<Vec<_>>(), (24, SIZE.1 as i32 - 24));
    for (((x, y), name, color), height) in ends.into_iter().zip(heights) {
        let leader = vec![(x + 5, y), (right + 4, height), (right + 12, height)];
        area.draw(&PathElement::new(leader, color.mix(0.5).stroke_width(1))).map_err(failed)?;
        let style = FONT.into_font().color(color).pos(Pos::new(HPos::Left, VPos::Center));
        area.draw(&Text::new(name.clone(), (right + 16, height), style)).map_err(failed)?;
    }
    Ok(())
}

/// A label of the axis of times: 1, 2 and 5 of each decade, which have room beside each other; nothing for the other lines.
fn tick(x: f64) -> String {
    let mantissa = x / 10f64.powf((x * 1.001).log10().floor());
    let has_room = [1.0, 2.0, 5.0].iter().any(|m| (mantissa - m).abs() < 0.01);
    match (has_room, x < 0.99) {
        (false, _) => String::new(),
        (true, true) => format!("{x:.2}"),
        (true, false) => format!("{x:.0}"),
    }
}

/// Heights near the given ones, which ascend, at least a line apart and within the limits where there is room.
fn apart(wanted: &[i32], (top, bottom): (i32, i32)) -> Vec<i32> {
    let mut heights: Vec<i32> = Vec::new();
    for &y in wanted {
        let free = heights.last().map_or(top, |last| last + LINE);
        heights.push(y.max(free));
    }
    let mut limit = bottom;
    for height in heights.iter_mut().rev() {
        *height = (*height).min(limit);
        limit = *height - LINE;
    }
    heights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_do_not_overlap() {
        let heights = apart(&[10, 200, 201, 202, 590, 600], (24, 500));
        assert!(heights.windows(2).all(|pair| pair[1] - pair[0] >= LINE), "{heights:?}");
        assert!(heights[0] == 24 && heights[1] == 200 && heights[5] == 500, "{heights:?}");
    }

    #[test]
    fn labels_of_times_have_room() {
        let labels = |values: &[f64]| values.iter().map(|x| tick(*x)).collect::<Vec<_>>();
        let decade: Vec<f64> = (1..=10).map(|k| 0.1 * f64::from(k)).collect();
        assert_eq!(labels(&decade), ["0.10", "0.20", "", "", "0.50", "", "", "", "", "1"]);
        assert_eq!(labels(&[0.999_999_9, 2.0, 5.0, 9.0, 10.0, 20.0]), ["1", "2", "5", "", "10", "20"]);
    }

    #[test]
    fn every_curve_has_its_name_and_intervals() {
        let curve = |name: &str, error: f64| Curve {
            name: name.into(),
            points: (0..4)
                .map(|k| f64::from(1 << k))
                .map(|n| [n, error / n, 0.8 * error / n, 1.2 * error / n])
                .collect(),
        };
        let svg = draw(&[curve("power", 1.0), curve("restir-di", 0.1)], "lamps").unwrap();
        for text in ["power", "restir-di", "lamps", "GPU time", "relMSE"] {
            assert!(svg.contains(text), "{text}");
        }
        assert_eq!(svg.matches("<circle").count(), 8);
        assert!(draw(&[curve("dark", 0.0)], "dark").unwrap_err().to_string().contains("--reference-spp"));
    }
}
