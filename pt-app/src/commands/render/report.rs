//! Times of a render, for the summary and for `--timings`.

use super::RenderArgs;
use crate::session::Session;
use crate::timings::{pass_spreads, warm};
use anyhow::{Context, Result};
use pt_core::frame::FrameTiming;
use pt_core::harness::Spread;
use pt_image::atomic_file::write_atomic;
use serde_json::json;
use std::io::Write;
use std::path::Path;

/// Writes the times of `frames` frames; of a long run `timings` are a sample.
pub(super) fn write_timings(
    path: &Path,
    frames: u32,
    timings: &[FrameTiming],
    args: &RenderArgs,
    session: &Session,
) -> Result<()> {
    let counted = warm(timings);
    let passes: Vec<_> = pass_spreads(counted)
        .into_iter()
        .map(|(name, Spread { median_ms, p95_ms })| json!({ "pass": name, "median_ms": median_ms, "p95_ms": p95_ms }))
        .collect();
    let frame = Spread::of(counted.iter().map(|f| f.gpu_ms).collect());
    let info = session.device.info();
    let document = json!({
        "scene": session.scene.name,
        "size": args.frame.output_size(),
        "device": info.name,
        "driver": info.driver_line(),
        "backend": session.gpu.backend().to_string(),
        "load": {
            "phases": session.load.list(),
            "total_ms": session.load.total_ms(),
            "texture_bytes": session.gpu.texture_bytes(),
            "texture_bytes_uncompressed": session.uncompressed_texture_bytes(),
            "peak_memory_bytes": peak_memory(),
        },
        "warm_up_frames": timings.len() - counted.len(),
        "frame": frame,
        "passes": passes,
        "frames_rendered": frames,
        "frames": timings,
    });
    let text = serde_json::to_string_pretty(&document)?;
    write_atomic(path, text.as_bytes()).with_context(|| "cannot write the timings".to_owned())
}

/// Where the time before the first picture went.
pub(super) fn load_line(session: &Session) -> String {
    let load = &session.load;
    let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    let phases: Vec<_> = load.list().iter().map(|p| format!("{} {:.0} ms", p.name, p.ms)).collect();
    let peak = peak_memory().map_or(String::new(), |bytes| format!("; peak memory {:.0} MiB", mib(bytes)));
    format!(
        "loaded in {:.2} s: {}; textures {:.1} MiB ({:.1} MiB without compression){peak}",
        load.total_ms() * 1e-3,
        phases.join(", "),
        mib(session.gpu.texture_bytes()),
        mib(session.uncompressed_texture_bytes()),
    )
}

/// Peak memory of this process, if the system reports it.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix(" kB")?.parse::<u64>().ok()? << 10)
}

/// Size, speed, device: one line.
pub(super) fn summary(
    frames: u32,
    timings: &[FrameTiming],
    session: &Session,
    size: [u32; 2],
    frame_size: [u32; 2],
    out: &mut impl Write,
) -> Result<bool> {
    let counted = warm(timings);
    let frame_ms = Spread::of(counted.iter().map(|f| f.gpu_ms).collect()).median_ms;
    let primary =
        counted.iter().flat_map(|f| &f.passes).filter(|p| p.pass == "primary rays").map(|p| p.ms).collect();
    let rays = f64::from(2 * pt_core::channels::field_width(frame_size[0])) * f64::from(frame_size[1]);
    // Frames that are fed with ground truth are not timed: without a time there is no rate.
    let speed = if frame_ms > 0.0 { format!(" {frame_ms:.3} ms/frame,") } else { String::new() };
    let primary_ms = Spread::of(primary).median_ms;
    let rate = match primary_ms > 0.0 {
        true => format!(" {:.1} Mrays/s (primary),", rays / primary_ms * 1e-3),
        false => String::new(),
    };
    writeln!(
        out,
        "{}x{}, {} frame{}:{speed}{rate} {}, {}",
        size[0],
        size[1],
        frames,
        if frames == 1 { "" } else { "s" },
        session.device_line(),
        session.gpu.backend(),
    )?;
    Ok(true)
}
