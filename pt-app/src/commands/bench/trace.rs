//! `pt bench trace` measures rays per second of every backend and of the CPU.

use crate::inputs::Inputs;
use crate::session::{check_host_memory, open_scene};
use anyhow::Result;
use clap::Args;
use pt_core::trace::RayKind;
use pt_core::trace::bench::{BenchOptions, bench, default_size};
use pt_core::{Device, DeviceOptions};
use pt_image::atomic_file::{check_writable, write_atomic};
use pt_image::image_file::ImageSize;
use pt_import::LoadOptions;
use pt_scene::gpu::{camera_record, mesh_geometry, placements};
use serde_json::json;
use std::io::Write;
use std::path::PathBuf;

/// `pt bench trace`
#[derive(Clone, Debug, Args)]
pub struct BenchTraceArgs {
    /// glTF or GLB file, or the name of a built-in scene.
    pub scene: String,
    /// Read buffers and images that are not beside or below the scene file, too.
    #[arg(long)]
    pub allow_outside: bool,
    /// Also write the rows to this JSON file.
    #[arg(long, value_name = "F")]
    pub json: Option<PathBuf>,
    /// Image size of the primary rays; the other kinds have the same number of rays [default: 3840x2160, on a CPU 640x360]
    #[arg(long, value_name = "WxH")]
    pub size: Option<ImageSize>,
    /// Number of timed windows, one after the other; the best is reported.
    #[arg(long, value_name = "N", default_value_t = 7, value_parser = clap::value_parser!(u32).range(1..))]
    pub windows: u32,
    /// Seed of the random directions.
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u32,
    /// Vulkan device, by index or part of its name [default: a discrete GPU before the CPU]
    #[arg(long, value_name = "D")]
    pub device: Option<String>,
}

/// Memory of the host that a pixel takes: a ray of each of four kinds and its hits, and the copies on their way to and from the device.
const BYTES_PER_PIXEL: u64 = 400;

/// Runs the command.
///
/// # Errors
/// Unknown scene or device, a file that can't be written.
pub fn run(args: &BenchTraceArgs, out: &mut impl Write) -> Result<bool> {
    if let Some(path) = &args.json {
        Inputs::default().with("the scene", [&args.scene]).check([path])?;
        check_writable(path)?;
    }
    let options = LoadOptions { allow_outside: args.allow_outside, ..LoadOptions::default() };
    let scene = open_scene(&args.scene, &options)?;
    let device = Device::open(&DeviceOptions { device: args.device.clone(), validation: false })?;
    let size = args.size.map_or_else(|| default_size(&device), <[u32; 2]>::from);
    check_host_memory("a list of rays", size, BYTES_PER_PIXEL)?;
    let options = BenchOptions { size, windows: args.windows, seed: args.seed };
    let camera = camera_record(&scene.default_camera(), size);
    let rows = bench(&device, &mesh_geometry(&scene), &placements(&scene), &camera, options)?;

    let triangles = scene.statistics().instanced_triangles;
    writeln!(
        out,
        "{}: {triangles} triangles, {} rays of each kind, best of {} windows",
        scene.name,
        size[0] * size[1],
        options.windows
    )?;
    writeln!(out, "{}, {}", device.info().name, device.info().driver_line())?;
    writeln!(
        out,
        "{:<12}{:>10}{:>10}{:>10}{:>10}   Mrays/s (agreement with native)",
        "", "primary", "bounce", "shadow", "shadow 2"
    )?;
    let mut backends: Vec<_> = rows.iter().map(|row| row.backend).collect();
    backends.dedup();
    for backend in backends {
        write!(out, "{backend:<12}")?;
        let of = |kind: RayKind| rows.iter().find(|row| row.backend == backend && row.kind == kind);
        for kind in RayKind::ALL {
            write!(out, "{:>10.2}", of(kind).map_or(0.0, |row| row.mrays_per_s))?;
        }
        let agreements = RayKind::ALL.map(|kind| of(kind).map_or(0.0, |row| row.agreement));
        writeln!(out, "   {}", agreements.map(|a| format!("{a:.5}")).join(" "))?;
    }
    if let Some(path) = &args.json {
        let document = json!({ "scene": scene.name, "triangles": triangles, "rows": rows });
        write_atomic(path, serde_json::to_string_pretty(&document)?.as_bytes())?;
    }
    Ok(true)
}
