//! Two images: values, a heat map.

use super::args::CompareArgs;
use super::checks::{Checks, digits, number};
use super::pair::{Pair, Warned, measure, read};
use super::report::{document, print_heading};
use crate::inputs::Inputs;
use anyhow::{Context, Result, bail};
use pt_image::image_file::{OutputFormat, PixelLayout, check_output, write_png};
use pt_image::metrics::{DISPLAY_TRANSFORM, Measurement, Metric, SequenceMetric, heatmap};
use serde_json::{Value, json};
use std::io::Write;
use std::path::Path;

/// Part of the pixels that a heat map shows without clipping, where the metric has no fixed upper end.
const HEATMAP_QUANTILE: f64 = 0.99;

/// Compares an image with its reference; true when every limit is kept.
///
/// # Errors
/// Images that cannot be read or compared, a region outside, a heat map that cannot be written.
pub fn run(args: &CompareArgs, out: &mut impl Write) -> Result<bool> {
    if let Some(path) = &args.heatmap
        && check_output(path)? != OutputFormat::Png
    {
        bail!("the heat map is a PNG, {} has another extension", path.display());
    }
    Inputs::default().with("one of the images", [&args.a, &args.b]).check(&args.heatmap)?;
    let metrics = args
        .metrics(&Metric::OF_IMAGES.map(SequenceMetric::Image))
        .into_iter()
        .map(|metric| {
            let name = metric.name();
            metric.image().with_context(|| {
                format!(
                    "{name} is of the change from frame to frame; give two sequences instead of two images"
                )
            })
        })
        .collect::<Result<Vec<_>>>()?;
    let (paths, mut warned) = ([args.a.as_path(), &args.b], Warned::default());
    let files = read(paths, &mut warned)?;
    let Pair { a, measured, .. } = measure(paths, files, &metrics, args, &mut warned)?;
    let checks = Checks::new(args, |metric| {
        measured.iter().find(|found| Some(found.metric) == metric.image()).map(|found| found.value)
    });
    let size = [a.width, a.height];
    let heatmap_top = match &args.heatmap {
        None => None,
        Some(path) => {
            let first = &measured[0];
            let top = heatmap_top(first);
            write_png(path, size[0], size[1], PixelLayout::Rgb, &heatmap(&first.map, top))?;
            Some((path.as_path(), first.metric, top))
        }
    };
    if args.json {
        let document = report(args, size, &measured, &checks, heatmap_top);
        writeln!(out, "{}", serde_json::to_string_pretty(&document)?)?;
    } else {
        print(args, size, &measured, &checks, heatmap_top, out)?;
    }
    Ok(checks.passed())
}

/// The error that is shown brightest: 1 for both kinds of FLIP; otherwise the quantile, or the maximum if nearly all pixels are
/// equal.
fn heatmap_top(measurement: &Measurement) -> f32 {
    if matches!(measurement.metric, Metric::Flip | Metric::HdrFlip) {
        return 1.0;
    }
    let mut sorted = measurement.map.clone();
    sorted.sort_by(f32::total_cmp);
    let last = sorted.len() - 1;
    let quantile = sorted[(HEATMAP_QUANTILE * last as f64).round() as usize];
    if quantile > 0.0 { quantile } else { sorted[last] }
}

fn print(
    args: &CompareArgs,
    size: [u32; 2],
    measured: &[Measurement],
    checks: &Checks,
    heatmap: Option<(&Path, Metric, f32)>,
    out: &mut impl Write,
) -> Result<()> {
    print_heading(args, None, size, out)?;
    writeln!(out, "\n{:<10}{:>14}{:>14}  formula", "metric", "value", "spread")?;
    for found in measured {
        let (name, formula) = (found.metric.name(), found.metric.formula());
        writeln!(out, "{name:<10}{:>14}{:>14}  {formula}", digits(found.value), digits(found.spread))?;
    }
    for found in measured.iter().filter(|found| !found.details.is_empty()) {
        let details: Vec<_> =
            found.details.iter().map(|(name, value)| format!("{name} {}", detail(*value))).collect();
        writeln!(out, "{}: {}", found.metric.name(), details.join(", "))?;
    }
    writeln!(out, "\na, b: linear values; spread: standard deviation over pixels")?;
    if measured.iter().any(|found| found.metric.uses_display_values()) {
        writeln!(out, "A, B: {DISPLAY_TRANSFORM}")?;
    }
    if let Some((path, metric, top)) = heatmap {
        writeln!(out, "heat map {}: {} per pixel, 0 to {top:.6e}", path.display(), metric.name())?;
    }
    checks.print(out)
}

/// Counts without decimals.
fn detail(value: f64) -> String {
    if value.fract() == 0.0 { value.to_string() } else { digits(value) }
}

fn report(
    args: &CompareArgs,
    size: [u32; 2],
    measured: &[Measurement],
    checks: &Checks,
    heatmap: Option<(&Path, Metric, f32)>,
) -> Value {
    let metrics: serde_json::Map<_, _> = measured
        .iter()
        .map(|found| {
            let mut entry = json!({
                "value": number(found.value),
                "spread": number(found.spread),
                "formula": found.metric.formula(),
                "epsilon": found.metric.epsilon(),
            });
            for &(name, value) in &found.details {
                entry[name] = if value.fract() == 0.0 { (value as i64).into() } else { number(value) };
            }
            (found.metric.name().to_owned(), entry)
        })
        .collect();
    let heatmap = heatmap.map(|(path, metric, top)| {
        json!({ "file": path.display().to_string(), "metric": metric.name(), "top": top })
    });
    document(args, size, checks, [("metrics", metrics.into()), ("heatmap", heatmap.into())])
}
