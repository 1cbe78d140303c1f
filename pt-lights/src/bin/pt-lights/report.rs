//! The results as tables and as JSON.

use super::measure::{Measured, Plan};
use super::statistics::{BLOCK, BLOCK_BAR, Interval};
use super::view::View;
use anyhow::{Context, Result};
use pt_image::atomic_file;
use serde_json::{Value, json};
use std::io::Write;
use std::path::Path;

/// Column of the names, wide enough for all.
fn name_width<'a>(names: impl Iterator<Item = &'a str>) -> usize {
    names.map(str::len).max().unwrap_or(0).max(14)
}

fn error(i: Interval) -> String {
    format!("{:.3e} ({:.2e}..{:.2e})", i.mean, i.low.max(0.0), i.high)
}

fn plus_minus(i: Interval) -> String {
    format!("{:.4} +- {:.4}", i.mean, 0.5 * (i.high - i.low))
}

/// Prints a line for each sampler: errors, then costs.
pub fn tables(results: &[Measured], plan: &Plan, out: &mut impl Write) -> Result<()> {
    let width = name_width(results.iter().map(|m| m.choice.name.as_str()));
    writeln!(
        out,
        "{} runs of {} frames after {} to warm up samplers with a history; relMSE with 95 % intervals over the runs",
        plan.runs, plan.frames, plan.warm_up
    )?;
    writeln!(
        out,
        "{:<width$} {:>18} {:>28} {:>13} {:>28} {:>28} {:>7} {:>7} {:>10}",
        "sampler",
        "mean / reference",
        "one frame",
        "at equal time",
        format!("mean of {} frames", plan.frames),
        "mean at equal time",
        "frames",
        "worth",
        "variance",
    )?;
    for m in results {
        writeln!(
            out,
            "{:<width$} {:>18} {:>28} {:>13.3e} {:>28} {:>28} {:>7} {:>7.1} {:>10.3e}",
            m.choice.name,
            plus_minus(m.mean_ratio),
            error(m.one_frame),
            m.one_frame_equal_time.mean,
            error(m.equal_samples),
            error(m.equal_time),
            m.frames_equal_time,
            m.effective_frames(),
            m.variance,
        )?;
    }
    writeln!(
        out,
        "\n{:<width$} {:>9} {:>9} {:>9} {:>8} {:>9} {:>9} {:>6} {:>8} {:>6} {:>4}  history",
        "sampler",
        "GPU ms",
        "choose ms",
        "Mrays/s",
        "of rate",
        "build ms",
        "KiB",
        "rays",
        "arrived",
        "alike",
        "M"
    )?;
    for m in results {
        writeln!(
            out,
            "{:<width$} {:>9.3} {:>9.3} {:>9.2} {:>8} {:>9.1} {:>9} {:>6.2} {:>7.1}% {:>6.2} {:>4}  {}",
            m.choice.name,
            m.gpu_ms,
            m.choose_gpu_ms,
            m.mrays_per_s,
            rate_share(m, plan).map_or("-".into(), |share| format!("{:.1}%", 100.0 * share)),
            m.build_ms,
            m.bytes.div_ceil(1024),
            m.rays_per_pixel,
            100.0 * m.arrived,
            m.duplicates,
            m.choice.candidates(),
            m.choice.history(),
        )?;
    }
    Ok(())
}

/// Rays a second of the sampler over what the device traces.
fn rate_share(m: &Measured, plan: &Plan) -> Option<f64> {
    (plan.ray_rate > 0.0).then(|| m.mrays_per_s / plan.ray_rate)
}

/// Prints how far the means of blocks are from the reference.
pub fn blocks(results: &[Measured], out: &mut impl Write) -> Result<()> {
    let width = name_width(results.iter().map(|m| m.choice.name.as_str()));
    writeln!(
        out,
        "\n{:<width$} {:>8} {:>10} {:>8}  of the means of {BLOCK}x{BLOCK} blocks and channels; standard errors over the runs",
        "sampler",
        "blocks",
        format!("within {BLOCK_BAR}"),
        "largest"
    )?;
    for m in results {
        let test = m.blocks;
        writeln!(
            out,
            "{:<width$} {:>8} {:>9.2}% {:>8.2}",
            m.choice.name,
            test.count,
            100.0 * test.within,
            test.largest
        )?;
    }
    Ok(())
}

/// The ranking as a table in Markdown: by the error of one frame at equal time. `blocks`: with two columns about blocks.
pub fn markdown(results: &[Measured], plan: &Plan, blocks: bool) -> String {
    let mut order: Vec<&Measured> = results.iter().collect();
    order.sort_by(|a, b| a.one_frame_equal_time.mean.total_cmp(&b.one_frame_equal_time.mean));
    let reach = |i: Interval| format!("{:.2e} ± {:.0} %", i.mean, 50.0 * (i.high - i.low) / i.mean);
    let mean = format!("mean of {} frames", plan.frames);
    let mut columns = vec![
        "sampler",
        "one frame at equal time",
        "one frame",
        &mean,
        "mean at equal time",
        "frames",
        "mean / reference",
        "GPU ms",
        "of the ray rate",
        "KiB",
        "alike",
    ];
    let within = format!("blocks within {BLOCK_BAR} s.e.");
    if blocks {
        columns.extend([within.as_str(), "largest"]);
    }
    let mut text = format!("| {} |\n|{}\n", columns.join(" | "), " --- |".repeat(columns.len()));
    for m in order {
        let mut row = vec![
            format!("`{}`", m.choice.name),
            reach(m.one_frame_equal_time),
            format!("{:.2e}", m.one_frame.mean),
            reach(m.equal_samples),
            reach(m.equal_time),
            m.frames_equal_time.to_string(),
            plus_minus(m.mean_ratio).replace("+-", "±"),
            format!("{:.3}", m.gpu_ms),
            rate_share(m, plan).map_or("-".into(), |share| format!("{:.0} %", 100.0 * share)),
            m.bytes.div_ceil(1024).to_string(),
            format!("{:.2}", m.duplicates),
        ];
        if blocks {
            let test = m.blocks;
            row.push(format!("{:.1} % of {}", 100.0 * test.within, test.count));
            row.push(format!("{:.2}", test.largest));
        }
        text += &format!("| {} |\n", row.join(" | "));
    }
    text
}

/// What all rows say about the view.
pub fn scene_fields(view: &View) -> Value {
    let info = view.device.info();
    json!({
        "scene": view.scene.name,
        "size": view.size(),
        "device": info.name,
        "driver": info.driver_line(),
        "backend": view.gpu.backend().name(),
    })
}

pub fn pair(i: Interval) -> Value {
    json!([i.low, i.high])
}

/// `fields` with those of the view.
pub fn with_scene(view: &View, mut fields: Value) -> Value {
    if let (Some(row), Value::Object(scene)) = (fields.as_object_mut(), scene_fields(view)) {
        row.extend(scene);
    }
    fields
}

/// The rows of the comparison. `ci`: of `relmse_equal_samples`.
pub fn rows(results: &[Measured], plan: &Plan, view: &View) -> Vec<Value> {
    let row = |m: &Measured| {
        let curve = m.curve.iter().map(|point| {
            let gpu_ms = f64::from(point.frames) * m.gpu_ms;
            json!({ "frames": point.frames, "gpu_ms": gpu_ms, "relmse": point.relmse.mean, "ci": pair(point.relmse) })
        });
        let fields = json!({
            "sampler": m.choice.name,
            "mean_ratio": m.mean_ratio.mean,
            "mean_ratio_ci": pair(m.mean_ratio),
            "relmse_one_frame": m.one_frame.mean,
            "relmse_one_frame_ci": pair(m.one_frame),
            "relmse_one_frame_equal_time": m.one_frame_equal_time.mean,
            "relmse_one_frame_equal_time_ci": pair(m.one_frame_equal_time),
            "relmse_equal_samples": m.equal_samples.mean,
            "ci": pair(m.equal_samples),
            "relmse_equal_time": m.equal_time.mean,
            "relmse_equal_time_ci": pair(m.equal_time),
            "frames_equal_time": m.frames_equal_time,
            "effective_frames": m.effective_frames(),
            "curve": curve.collect::<Vec<_>>(),
            "variance": m.variance,
            "gpu_ms": m.gpu_ms,
            "choose_gpu_ms": m.choose_gpu_ms,
            "build_ms": m.build_ms,
            "bytes": m.bytes,
            "rays_per_pixel": m.rays_per_pixel,
            "arrived": m.arrived,
            "mrays_per_s": m.mrays_per_s,
            "ray_rate_share": rate_share(m, plan),
            "duplicates": m.duplicates,
            "candidates": m.choice.candidates(),
            "history": m.choice.history(),
            "runs": plan.runs,
            "frames": plan.frames,
            "warm_up": plan.warm_up,
            "blocks": m.blocks.count,
            "blocks_within": m.blocks.within,
            "blocks_within_3se": m.blocks.within,
            "blocks_largest": m.blocks.largest,
        });
        with_scene(view, fields)
    };
    results.iter().map(row).collect()
}

/// Writes an array of rows.
pub fn write_json(rows: &[Value], path: &Path) -> Result<()> {
    write_text(&serde_json::to_string_pretty(rows)?, path)
}

/// Writes a text file.
pub fn write_text(text: &str, path: &Path) -> Result<()> {
    atomic_file::write_atomic(path, text.as_bytes()).with_context(|| format!("{}", path.display()))
}
