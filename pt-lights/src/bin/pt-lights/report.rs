//! The results as a table and as JSON.

use super::bench::{Interval, Measured, Plan};
use super::view::View;
use anyhow::{Context, Result};
use pt_image::atomic_file;
use serde_json::json;
use std::io::Write;
use std::path::Path;

/// Prints a line for each sampler.
pub fn table(results: &[Measured], plan: &Plan<'_>, out: &mut impl Write) -> Result<()> {
    writeln!(
        out,
        "{} runs; errors are relMSE of {} frames, 95 % intervals over the runs",
        plan.runs, plan.frames
    )?;
    writeln!(
        out,
        "{:<14} {:>18} {:>28} {:>28} {:>7} {:>10} {:>9} {:>9} {:>9} {:>6} {:>8} {:>6}",
        "sampler",
        "mean / reference",
        "relMSE, equal samples",
        "relMSE, equal time",
        "frames",
        "variance",
        "GPU ms",
        "build ms",
        "KiB",
        "rays",
        "arrived",
        "alike"
    )?;
    let error = |i: Interval| format!("{:.3e} ({:.2e}..{:.2e})", i.mean, i.low.max(0.0), i.high);
    for m in results {
        let half = 0.5 * (m.mean_ratio.high - m.mean_ratio.low);
        writeln!(
            out,
            "{:<14} {:>18} {:>28} {:>28} {:>7} {:>10.3e} {:>9.3} {:>9.1} {:>9} {:>6.2} {:>7.1}% {:>6.2}",
            m.sampler.name(),
            format!("{:.4} +- {half:.4}", m.mean_ratio.mean),
            error(m.relmse_equal_samples),
            error(m.relmse_equal_time),
            m.frames_equal_time,
            m.variance,
            m.gpu_ms,
            m.build_ms,
            m.bytes.div_ceil(1024),
            m.rays_per_pixel,
            100.0 * m.arrived,
            m.duplicates,
        )?;
    }
    Ok(())
}

/// Writes an array of rows. `ci`: of `relmse_equal_samples`.
pub fn write_json(results: &[Measured], view: &View, path: &Path) -> Result<()> {
    let info = view.device.info();
    let pair = |i: Interval| json!([i.low, i.high]);
    let row = |m: &Measured| {
        json!({
            "sampler": m.sampler.name(),
            "mean_ratio": m.mean_ratio.mean,
            "mean_ratio_ci": pair(m.mean_ratio),
            "relmse_equal_samples": m.relmse_equal_samples.mean,
            "relmse_equal_time": m.relmse_equal_time.mean,
            "relmse_equal_time_ci": pair(m.relmse_equal_time),
            "frames_equal_time": m.frames_equal_time,
            "ci": pair(m.relmse_equal_samples),
            "variance": m.variance,
            "gpu_ms": m.gpu_ms,
            "build_ms": m.build_ms,
            "bytes": m.bytes,
            "rays_per_pixel": m.rays_per_pixel,
            "arrived": m.arrived,
            "duplicates": m.duplicates,
            "scene": view.scene.name,
            "size": view.size(),
            "device": info.name,
            "driver": info.driver_line(),
            "backend": view.gpu.backend().name(),
        })
    };
    let text = serde_json::to_string_pretty(&results.iter().map(row).collect::<Vec<_>>())?;
    atomic_file::write_atomic(path, text.as_bytes()).with_context(|| format!("{}", path.display()))
}
