//! The table of a benchmark of the frame.

use super::file::{BenchFile, How, Part, PassRecord, Yardsticks};
use std::fmt;

impl fmt::Display for BenchFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size;
        writeln!(
            f,
            "{}: {width}x{height}, {} rounds of {} frames after {} to warm up, {} ({}), {}",
            self.scene,
            self.rounds.iter().sum::<u32>(),
            self.frames,
            self.warm_up,
            self.device,
            self.driver,
            self.backend
        )?;
        if let Some(Yardsticks { copy_gb_per_s, copy, mrays_per_s }) = &self.yardsticks {
            write!(f, "measured: copying {copy_gb_per_s:.1} GB/s ({copy})")?;
            for (kind, rate) in mrays_per_s {
                write!(f, ", {} rays {rate:.0} M/s", kind.name())?;
            }
            writeln!(f)?;
        }
        self.parts.iter().try_for_each(|part| write_part(f, part, self.yardsticks.as_ref()))
    }
}

fn write_part(f: &mut fmt::Formatter<'_>, part: &Part, yardsticks: Option<&Yardsticks>) -> fmt::Result {
    let how = match part.how {
        How::Frame if part.name == "frame" => "all passes",
        How::Frame => "its passes within the frame",
        How::Replay => "alone, on the images of one recorded frame, without rays",
    };
    writeln!(f, "\n{}: {how}", part.name)?;
    let width = part.passes.iter().map(|row| row.pass.chars().count()).max().unwrap_or(0).max(5);
    writeln!(
        f,
        "{:<width$}  {:<12}  {:>10}  {:>10}  {:>10}  {:>8}  {:>7}  {:>10}  {:>8}  {:>7}",
        "pass", "stage", "median ms", "p95 ms", "MiB", "GB/s", "of copy", "rays", "Mrays/s", "of rate"
    )?;
    let rate = |value: Option<f64>| value.map_or("-".into(), |v| format!("{v:.1}"));
    let share = |value: Option<f64>| value.map_or("-".into(), |v| format!("{:.0} %", 100.0 * v));
    for row in &part.passes {
        writeln!(
            f,
            "{:<width$}  {:<12}  {:>10.4}  {:>10.4}  {:>10}  {:>8}  {:>7}  {:>10}  {:>8}  {:>7}",
            row.pass,
            row.stage.name(),
            row.time.median_ms,
            row.time.p95_ms,
            bounded(row.bytes_are_upper_bound, format!("{:.2}", row.bytes as f64 / f64::from(1 << 20))),
            rate(row.gb_per_s()),
            share(yardsticks.and_then(|y| y.share_of_copy(row))),
            rays(row),
            rate(row.mrays_per_s()),
            share(yardsticks.and_then(|y| y.share_of_rays(row))),
        )?;
    }
    for row in &part.stages {
        let of_frame = if part.time.median_ms > 0.0 { row.median_ms / part.time.median_ms } else { 0.0 };
        writeln!(
            f,
            "{:<width$}  {:<12}  {:>10.4}  {:>10.4}  {:>8.1} % of the frame",
            "stage",
            row.stage.name(),
            row.median_ms,
            row.p95_ms,
            100.0 * of_frame
        )?;
    }
    writeln!(
        f,
        "{:<width$}  {:<12}  {:>10.4}  {:>10.4}",
        part.name, "", part.time.median_ms, part.time.p95_ms
    )
}

/// An upper bound is marked as one.
fn bounded(is_upper_bound: bool, text: String) -> String {
    if is_upper_bound { format!("<= {text}") } else { text }
}

fn rays(row: &PassRecord) -> String {
    row.rays.map_or("-".into(), |rays| bounded(rays.is_upper_bound, rays.count.to_string()))
}
