//! Two sequences: values of each frame and their means.

use super::args::{CompareArgs, Region};
use super::checks::{Checks, digits, number};
use super::frames::{self, pairs};
use super::motion::{Motion, MotionSource};
use super::pair::{Pair, Warned, measure, read};
use super::report::{document, print_heading};
use crate::progress::Progress;
use anyhow::{Context, Result, ensure};
use pt_image::metrics::{
    Correspondence, DISPLAY_TRANSFORM, FramePair, Metric, SequenceMetric, temporal_error,
};
use serde_json::{Map, Value, json};
use std::io::Write;

/// What is measured unless `--metric` says it.
const DEFAULTS: [SequenceMetric; 6] = [
    SequenceMetric::Image(Metric::RelMse),
    SequenceMetric::Image(Metric::Flip),
    SequenceMetric::Image(Metric::Energy),
    SequenceMetric::Image(Metric::Detail),
    SequenceMetric::TemporalPixel,
    SequenceMetric::TemporalBlock,
];

/// The values of a frame.
struct Row {
    files: frames::Pair,
    /// In the order of the metrics; a temporal one needs the frame with the number before.
    values: Vec<Option<f64>>,
}

/// All that is printed.
struct Found {
    metrics: Vec<SequenceMetric>,
    /// Size of what is compared, pixels.
    size: [u32; 2],
    /// `None` without temporal metrics.
    motion: Option<MotionSource>,
    rows: Vec<Row>,
}

/// A frame that the next one is compared with.
struct Before {
    frame: u32,
    pair: Pair,
    motion: Motion,
}

/// Compares the frames of a sequence with those of its reference; true when every limit is kept.
///
/// # Errors
/// Sequences that do not match, images that cannot be read or compared, a region outside.
pub fn run(args: &CompareArgs, out: &mut impl Write) -> Result<bool> {
    ensure!(
        args.heatmap.is_none(),
        "--heatmap is of two images, {} is a sequence; give one frame of each",
        args.a.display()
    );
    let found = measure_all(args, pairs(&args.a, &args.b)?)?;
    let checks = Checks::new(args, |metric| found.mean(metric));
    if args.json {
        writeln!(out, "{}", serde_json::to_string_pretty(&found.report(args, &checks))?)?;
    } else {
        found.print(args, out)?;
        checks.print(out)?;
    }
    Ok(checks.passed())
}

fn measure_all(args: &CompareArgs, files: Vec<frames::Pair>) -> Result<Found> {
    let metrics = args.metrics(&DEFAULTS);
    let of_images: Vec<Metric> = metrics.iter().filter_map(|metric| metric.image()).collect();
    let is_temporal = metrics.iter().any(|metric| metric.is_temporal());
    let mut source: Option<MotionSource> = None;
    let mut progress = Progress::new(files.len() as u32);
    let mut warned = Warned::default();
    let mut first: Option<([u32; 2], String)> = None;
    let mut before: Option<Before> = None;
    let mut rows = Vec::new();
    for files in files {
        let frame = files.frame;
        let paths = [files.a.as_path(), &files.b];
        let decoded = read(paths, &mut warned)?;
        let motion = match is_temporal {
            true => source.get_or_insert_with(|| MotionSource::of(&decoded)).read(paths, &decoded)?,
            false => Motion::Still,
        };
        let pair = measure(paths, decoded, &of_images, args, &mut warned)?;
        let name = files.a.display();
        let (whole, of_first) = first.get_or_insert_with(|| (pair.whole, name.to_string()));
        ensure!(
            pair.whole == *whole,
            "{name} has {}x{} pixels and {of_first} {}x{}; the frames of a sequence have one size",
            pair.whole[0],
            pair.whole[1],
            whole[0],
            whole[1]
        );
        let now = Before { frame, motion, pair };
        let temporal = match &before {
            Some(before) if is_temporal && before.frame + 1 == frame => {
                Some(change(&now, before, args.region).with_context(|| name.to_string())?)
            }
            _ => None,
        };
        let value = |metric: &SequenceMetric| match metric {
            SequenceMetric::Image(metric) => {
                now.pair.measured.iter().find(|found| found.metric == *metric).map(|found| found.value)
            }
            SequenceMetric::TemporalPixel => temporal.map(|[pixel, _]| pixel),
            SequenceMetric::TemporalBlock => temporal.map(|[_, block]| block),
        };
        rows.push(Row { values: metrics.iter().map(value).collect(), files });
        before = Some(now);
        progress.step();
    }
    progress.finish();
    let size = before.map_or([0; 2], |last| [last.pair.a.width, last.pair.a.height]);
    Ok(Found { metrics, size, motion: source, rows })
}

/// Errors of the change since the frame before, by pixels and by blocks.
fn change(now: &Before, before: &Before, region: Option<Region>) -> Result<[f64; 2]> {
    let motion = cut(now.motion.since(&before.motion, now.pair.whole), now.pair.whole, region);
    let pair = |now, before| FramePair { now, before };
    let (a, b) = (pair(&now.pair.a, &before.pair.a), pair(&now.pair.b, &before.pair.b));
    let error = temporal_error(a, b, &motion)?;
    Ok([error.pixel, error.block])
}

/// The part of the region, which lies in the image.
fn cut(whole: Correspondence, size: [u32; 2], region: Option<Region>) -> Correspondence {
    let Some(Region { x, y, width, height }) = region else { return whole };
    let row = |y: u32| {
        let start = (y * size[0] + x) as usize;
        &whole.offsets[start..start + width as usize]
    };
    Correspondence { offsets: (y..y + height).flat_map(row).copied().collect() }
}

impl Found {
    /// Over the frames that have a value; `None` without any.
    fn mean(&self, metric: SequenceMetric) -> Option<f64> {
        let column = self.metrics.iter().position(|m| *m == metric)?;
        let values: Vec<f64> = self.rows.iter().filter_map(|row| row.values[column]).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    }

    fn print(&self, args: &CompareArgs, out: &mut impl Write) -> Result<()> {
        let Self { metrics, size, motion, rows } = self;
        print_heading(args, Some(rows.len()), *size, out)?;
        let mut line = |first: &str, cells: &mut dyn Iterator<Item = String>| -> Result<()> {
            write!(out, "{first:>6}")?;
            for cell in cells {
                write!(out, "{cell:>16}")?;
            }
            Ok(writeln!(out)?)
        };
        let cell = |value: Option<f64>| value.map_or("-".to_owned(), digits);
        line("\n frame", &mut metrics.iter().map(|metric| metric.name().to_owned()))?;
        for row in rows {
            line(&row.files.frame.to_string(), &mut row.values.iter().copied().map(cell))?;
        }
        line("mean", &mut metrics.iter().map(|metric| cell(self.mean(*metric))))?;
        writeln!(out)?;
        for metric in metrics {
            writeln!(out, "{}: {}", metric.name(), metric.formula())?;
        }
        writeln!(out, "a, b: linear values")?;
        if metrics.iter().filter_map(|metric| metric.image()).any(Metric::uses_display_values) {
            writeln!(out, "A, B: {DISPLAY_TRANSFORM}")?;
        }
        if let Some(motion) = motion {
            writeln!(out, "motion: {}", motion.text())?;
        }
        Ok(())
    }

    fn report(&self, args: &CompareArgs, checks: &Checks) -> Value {
        let optional = |value: Option<f64>| value.map_or(Value::Null, number);
        let metrics: Map<_, _> = (self.metrics.iter())
            .map(|metric| {
                let entry = json!({
                    "mean": optional(self.mean(*metric)),
                    "formula": metric.formula(),
                    "epsilon": metric.epsilon(),
                });
                (metric.name().to_owned(), entry)
            })
            .collect();
        let row = |Row { files, values }: &Row| {
            let mut row = json!({
                "frame": files.frame,
                "a": files.a.display().to_string(),
                "b": files.b.display().to_string(),
            });
            for (metric, value) in self.metrics.iter().zip(values) {
                row[metric.name()] = optional(*value);
            }
            row
        };
        let frames: Value = self.rows.iter().map(row).collect();
        let motion = self.motion.map(MotionSource::text).into();
        document(
            args,
            self.size,
            checks,
            [("motion", motion), ("metrics", metrics.into()), ("frames", frames)],
        )
    }
}
