//! `pt compare` measures an image against its reference and checks limits.

mod args;

pub use args::{CompareArgs, Limit, MetricName, Region};

use std::io::Write;
use std::path::Path;

use crate::inputs::Inputs;
use crate::origin::differences;
use anyhow::{Context, Result, bail};
use pt_core::console::print_warning;
use pt_image::image_file::{
    ImageState, LayeredImage, LinearImage, OutputFormat, PixelLayout, check_output, write_png,
};
use pt_image::metrics::{
    DISPLAY_TRANSFORM, Measurement, Metric, VARIANCE_LAYER, Variances, compare_estimates, heatmap,
    read_variance,
};
use serde_json::{Value, json};

/// Part of the pixels that a heat map shows without clipping, where the metric has no fixed upper end.
const HEATMAP_QUANTILE: f64 = 0.99;

/// A limit and what became of it.
struct Check {
    limit: Limit,
    /// `<=` or `>=`
    relation: &'static str,
    passed: bool,
}

/// Runs the command; true when every limit is kept.
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
    let metrics = requested(args);
    let (a, b) = (read_region(args, &args.a)?, read_region(args, &args.b)?);
    let variances = match metrics.iter().any(|metric| metric.uses_variances()) {
        true => Some((variance(args, &args.a)?, variance(args, &args.b)?)),
        false => None,
    };
    warn_about_states(args, &a, &b);
    warn_about_origins(args);
    if variances.is_some() && a.pixels == b.pixels {
        print_warning("the images are equal, as estimates of one seed are: z-test tests nothing");
    }
    let variances = variances.as_ref().map(|(a, b)| Variances { a, b });
    let measured = compare_estimates(&a, &b, variances, &metrics)
        .with_context(|| format!("cannot compare {} with {}", args.a.display(), args.b.display()))?;
    let checks = check(args, &measured);
    let (width, height) = (a.width, a.height);
    let heatmap_top = match &args.heatmap {
        None => None,
        Some(path) => {
            let first = &measured[0];
            let top = heatmap_top(first);
            write_png(path, width, height, PixelLayout::Rgb, &heatmap(&first.map, top))?;
            Some((path.as_path(), first.metric, top))
        }
    };
    let passed = checks.iter().all(|check| check.passed);
    if args.json {
        let document = report(args, (width, height), &measured, &checks, heatmap_top);
        writeln!(out, "{}", serde_json::to_string_pretty(&document)?)?;
    } else {
        print(args, (width, height), &measured, &checks, heatmap_top, out)?;
    }
    Ok(passed)
}

/// A scene against a display has no common scale; FLIP, PSNR and SSIM bring both to display values, which may be wanted.
fn warn_about_states(args: &CompareArgs, a: &LinearImage, b: &LinearImage) {
    if a.state != b.state {
        let name = |state| match state {
            ImageState::SceneReferred => "scene-referred",
            ImageState::DisplayReferred => "display-referred",
        };
        print_warning(&format!(
            "{} is {} and {} is {}: relmse, mse, hdr-flip, energy, detail and z-test compare values of different meaning",
            args.a.display(),
            name(a.state),
            args.b.display(),
            name(b.state)
        ));
    }
}

/// Images of different cameras, environments or light differ by more than their noise.
fn warn_about_origins(args: &CompareArgs) {
    let [a, b] =
        [&args.a, &args.b].map(|path| (path.display().to_string(), LayeredImage::read_metadata(path)));
    for difference in differences((&a.0, &a.1), (&b.0, &b.1)) {
        print_warning(&difference);
    }
}

/// The metrics asked for, then those that only a limit names, each once.
fn requested(args: &CompareArgs) -> Vec<Metric> {
    let mut metrics = Vec::new();
    let named = args.metric.iter().map(|&MetricName(metric)| metric);
    for metric in named.chain(args.max.iter().chain(&args.min).map(|limit| limit.metric)) {
        if !metrics.contains(&metric) {
            metrics.push(metric);
        }
    }
    metrics
}

fn read_region(args: &CompareArgs, path: &Path) -> Result<LinearImage> {
    let (image, notices) = LinearImage::read_with_notices(path)?;
    for notice in notices {
        print_warning(&format!("{}: {notice}", path.display()));
    }
    cut(image, args.region, path)
}

/// The variances of a Monte Carlo estimate, in the same rectangle.
fn variance(args: &CompareArgs, path: &Path) -> Result<LinearImage> {
    let image = read_variance(path)?.with_context(|| {
        format!(
            "z-test needs the variances of both images: {} is no EXR with channels R, G, B in a layer {VARIANCE_LAYER:?}",
            path.display()
        )
    })?;
    cut(image, args.region, path)
}

fn cut(image: LinearImage, region: Option<Region>, path: &Path) -> Result<LinearImage> {
    let Some(Region { x, y, width, height }) = region else {
        return Ok(image);
    };
    image.crop(x, y, width, height).with_context(|| {
        format!(
            "region {x},{y},{width},{height} reaches outside {} ({}x{} pixels)",
            path.display(),
            image.width,
            image.height
        )
    })
}

fn check(args: &CompareArgs, measured: &[Measurement]) -> Vec<Check> {
    let value = |metric| {
        let found = measured.iter().find(|measurement| measurement.metric == metric);
        found.map_or(f64::NAN, |measurement| measurement.value)
    };
    let upper = args.max.iter().map(|&limit| Check {
        limit,
        relation: "<=",
        passed: value(limit.metric) <= limit.value,
    });
    let lower = args.min.iter().map(|&limit| Check {
        limit,
        relation: ">=",
        passed: value(limit.metric) >= limit.value,
    });
    upper.chain(lower).collect()
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
    (width, height): (u32, u32),
    measured: &[Measurement],
    checks: &[Check],
    heatmap: Option<(&Path, Metric, f32)>,
    out: &mut impl Write,
) -> Result<()> {
    writeln!(out, "a (image)     {}", args.a.display())?;
    writeln!(out, "b (reference) {}", args.b.display())?;
    match args.region {
        None => writeln!(out, "{width}x{height} pixels")?,
        Some(region) => writeln!(out, "{width}x{height} pixels from {},{}", region.x, region.y)?,
    }
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
    for Check { limit, relation, passed } in checks {
        let outcome = if *passed { "ok" } else { "FAILED" };
        writeln!(out, "check {} {relation} {}: {outcome}", limit.metric.name(), limit.value)?;
    }
    Ok(())
}

fn digits(value: f64) -> String {
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) {
        format!("{value:.6}")
    } else {
        format!("{value:.6e}")
    }
}

/// Counts without decimals.
fn detail(value: f64) -> String {
    if value.fract() == 0.0 { value.to_string() } else { digits(value) }
}

fn report(
    args: &CompareArgs,
    (width, height): (u32, u32),
    measured: &[Measurement],
    checks: &[Check],
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
    let checks: Vec<_> = checks
        .iter()
        .map(|Check { limit, relation, passed }| {
            json!({
                "metric": limit.metric.name(),
                "relation": relation,
                "limit": number(limit.value),
                "passed": passed,
            })
        })
        .collect();
    json!({
        "a": args.a.display().to_string(),
        "b": args.b.display().to_string(),
        "width": width,
        "height": height,
        "region": args.region.map(|region| [region.x, region.y, region.width, region.height]),
        "display_values": DISPLAY_TRANSFORM,
        "metrics": metrics,
        "heatmap": heatmap.map(|(path, metric, top)| {
            json!({ "file": path.display().to_string(), "metric": metric.name(), "top": top })
        }),
        "passed": checks.iter().all(|check| check["passed"] == true),
        "checks": checks,
    })
}

/// JSON has no infinity (PSNR of equal images): it is written as the string `inf`.
fn number(value: f64) -> Value {
    if value.is_finite() { value.into() } else { value.to_string().into() }
}
