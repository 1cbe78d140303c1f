//! What a study would run, without a device.

use super::plan::Plan;
use anyhow::Result;
use pt_study::file::Against;
use pt_study::folder::read_timings;
use std::collections::BTreeSet;
use std::io::Write;
use std::path::Path;

/// Speed of a kind of device, measured with `gallery` and `cornell`; only the order of magnitude is right for other scenes.
struct Speed {
    name: &'static str,
    /// Pixels of frames, and samples of references, each second.
    pixels_per_s: f64,
    /// Opening the scene and making kernels, for each cell, seconds.
    start_s: f64,
}

const SPEEDS: [Speed; 2] = [
    Speed { name: "a GPU", pixels_per_s: 2e8, start_s: 1.0 },
    Speed { name: "a CPU device", pixels_per_s: 3e5, start_s: 3.0 },
];

/// The metrics of a measured pixel on the host, seconds: mostly FLIP.
const METRICS_S: f64 = 2e-6;

/// Images of a frame on the device, with a denoiser and temporal anti-aliasing, bytes a pixel.
const DEVICE_BYTES: f64 = 900.0;

/// A frame, its truth and the frame before on the host, bytes a pixel.
const HOST_BYTES: f64 = 150.0;

/// Lists the cells, and what they will take. `folder`: if it has results of the study, their times are the better estimate.
///
/// # Errors
/// When the output is closed.
pub fn print(plan: &Plan, folder: Option<&Path>, out: &mut impl Write) -> Result<()> {
    let study = &plan.study;
    let cells = plan.shard();
    for cell in cells {
        let variant = &plan.variants[cell.variant];
        let camera = if cell.camera.is_empty() { String::new() } else { format!(" camera {}", cell.camera) };
        writeln!(
            out,
            "{}  {}{camera} {}x{} {} seed {}: {}",
            cell.name, cell.scene, cell.size[0], cell.size[1], cell.backend, cell.seed, variant.name
        )?;
    }
    let pixels = |size: [u32; 2]| f64::from(size[0]) * f64::from(size[1]);
    let rendered: f64 = cells.iter().map(|cell| pixels(cell.size) * f64::from(study.frames)).sum();
    let measured: f64 = cells.iter().map(|cell| pixels(cell.size) * study.measure.len() as f64).sum();
    let views: BTreeSet<_> = cells.iter().map(|cell| (&cell.scene, &cell.camera, cell.size)).collect();
    let spp = match study.against {
        Against::Reference { spp } => f64::from(spp),
        Against::Capture(_) => 0.0,
    };
    let samples: f64 = views.iter().map(|(.., size)| pixels(*size) * spp).sum();
    let largest = cells.iter().map(|cell| pixels(cell.size)).fold(0.0, f64::max);
    writeln!(
        out,
        "{} cells: {} variants, {} views, {} seeds, {} frames each, of which {} are measured",
        cells.len(),
        plan.variants.len(),
        views.len(),
        study.seeds.len(),
        study.frames,
        study.measure.len()
    )?;
    for Speed { name, pixels_per_s, start_s } in SPEEDS {
        let seconds =
            cells.len() as f64 * start_s + (rendered + samples) / pixels_per_s + measured * METRICS_S;
        writeln!(out, "estimated time on {name}: {}", duration(seconds))?;
    }
    if let Some(timings) =
        folder.and_then(|folder| read_timings(folder).ok()).filter(|timings| !timings.is_empty())
    {
        let mean = timings.iter().map(|timing| timing.wall_s).sum::<f64>() / timings.len() as f64;
        writeln!(out, "by the times of the results there: {}", duration(mean * cells.len() as f64))?;
    }
    let mib = |bytes: f64| bytes / f64::from(1 << 20);
    writeln!(
        out,
        "estimated memory: {:.0} MiB on the device and {:.0} MiB on the host, and those of the scene",
        mib(largest * DEVICE_BYTES),
        mib(largest * HOST_BYTES)
    )?;
    writeln!(
        out,
        "estimate: {:.3e} pixels of frames and {:.3e} samples of references (those of views that move: one for each measured frame) at the speed of \
         gallery, and a start for each cell; a tenth to ten times of it for other scenes",
        rendered, samples
    )?;
    Ok(())
}

fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s if s < 172_800.0 => format!("{:.1} h", s / 3600.0),
        s => format!("{:.1} days", s / 86_400.0),
    }
}
