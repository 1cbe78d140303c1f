//! `pt bench`: rays of every backend and of the CPU; paths of the reference path tracer.

use crate::bench_post;
use crate::cli::{BenchArgs, BenchCommand, BenchPathArgs, BenchTraceArgs};
use crate::session::{Session, choose_camera};
use anyhow::Result;
use pt_core::atomic_file::{check_writable, write_atomic};
use pt_core::trace::bench::{BenchOptions, RayKind, bench, native_rates};
use pt_core::{Device, DeviceOptions};
use pt_reference::{FilmState, Progressive, ReferenceParams};
use pt_scene::gpu::{camera_record, mesh_geometry, placements};
use pt_shaders::records::FrameRecord;
use serde_json::json;
use std::collections::BTreeMap;
use std::io::Write;
use std::time::Instant;

/// Runs the command.
///
/// # Errors
/// Unknown scene or device, a file that can't be written.
pub fn run(args: &BenchArgs, out: &mut impl Write) -> Result<bool> {
    match &args.command {
        BenchCommand::Trace(args) => trace(args, out),
        BenchCommand::Path(args) => path(args, out),
        BenchCommand::Post(args) => bench_post::run(args, out),
    }
}

fn trace(args: &BenchTraceArgs, out: &mut impl Write) -> Result<bool> {
    if let Some(path) = &args.json {
        check_writable(path)?;
    }
    let scene = pt_scene::open(&args.scene, &Default::default())?;
    let device = Device::open(&DeviceOptions { device: args.device.clone(), validation: false })?;
    let size = [args.size.width, args.size.height];
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

fn path(args: &BenchPathArgs, out: &mut impl Write) -> Result<bool> {
    if let Some(path) = &args.json {
        check_writable(path)?;
    }
    let scene = pt_scene::open(&args.scene.file, &args.scene.load_options())?;
    let camera = choose_camera(&scene, &args.camera)?.at(args.scene.time);
    let size = [args.size.width, args.size.height];
    let record = camera_record(&camera, size);
    let options = BenchOptions { size, windows: args.windows, seed: 0 };
    let native = native_rates(&mesh_geometry(&scene), &placements(&scene), &record, options)?;
    let triangles = scene.statistics().instanced_triangles;

    let mut session = Session::open(&args.device, scene)?;
    let frame = FrameRecord::new(record, record, size, 0, 0);
    let params = ReferenceParams { max_bounces: args.max_bounces, ..ReferenceParams::default() };
    let mut render =
        Progressive::new(&session.device, &session.gpu, &session.lights, frame, params, None, 0)?;
    // Sums, seconds and milliseconds of the passes; reading the sums takes time of its own.
    let mut advance = |end: u32| -> Result<(FilmState, f64, BTreeMap<String, f64>)> {
        let mut passes = BTreeMap::new();
        let started = Instant::now();
        while render.next_sample() < end {
            let timings = render.step(&session.scene, &mut session.gpu, &session.lights, end)?;
            for pass in timings.into_iter().flat_map(|frame| frame.passes) {
                *passes.entry(pass.pass).or_default() += pass.ms;
            }
        }
        let seconds = started.elapsed().as_secs_f64();
        Ok((render.state()?, seconds, passes))
    };
    // Compiles the kernels, and finds out how many samples fit into a step.
    let (mut before, ..) = advance(args.spp)?;
    let mut best = f64::INFINITY;
    let mut rays = [0; 2];
    let mut best_passes = BTreeMap::new();
    for window in 1..=args.windows {
        let (after, seconds, passes) = advance(args.spp * (window + 1))?;
        if seconds < best {
            best = seconds;
            best_passes = passes;
            rays = [0, 1].map(|kind| after.rays()[kind] - before.rays()[kind]);
        }
        before = after;
    }
    session.check_validation()?;

    let paths = f64::from(size[0]) * f64::from(size[1]) * f64::from(args.spp);
    let [nearest, shadow] = rays.map(|n| n as f64);
    // Rays of paths are bounce rays but for the first, and so are the shadow rays, in the same proportion.
    let first = (paths / nearest).min(1.0);
    let native_s = 1e-6
        * (nearest * (first / native[0] + (1.0 - first) / native[1])
            + shadow * (first / native[2] + (1.0 - first) / native[3]));
    let mrays_per_s = (nearest + shadow) / best * 1e-6;
    let native_mrays_per_s = (nearest + shadow) / native_s * 1e-6;
    writeln!(
        out,
        "{}: {triangles} triangles, {}x{}, {} samples a pixel, {} bounces, {}, {}",
        session.scene.name,
        size[0],
        size[1],
        args.spp,
        args.max_bounces,
        session.device_line(),
        session.gpu.backend()
    )?;
    writeln!(out, "{:>12.2} Mpaths/s", paths / best * 1e-6)?;
    writeln!(
        out,
        "{mrays_per_s:>12.2} Mrays/s ({:.2} nearest and {:.2} shadow rays a path)",
        nearest / paths,
        shadow / paths
    )?;
    writeln!(
        out,
        "{native_mrays_per_s:>12.2} Mrays/s native traversal of as many rays (primary {:.2}, bounce {:.2}, shadow {:.2}, from bounces {:.2})",
        native[0], native[1], native[2], native[3]
    )?;
    writeln!(out, "{:>12.2} x native", mrays_per_s / native_mrays_per_s)?;
    for (pass, ms) in &best_passes {
        writeln!(out, "{ms:>12.2} ms {pass}")?;
    }
    writeln!(out, "{:>12.2} ms in all, by the wall clock", best * 1e3)?;
    if let Some(path) = &args.json {
        let document = json!({
            "scene": session.scene.name,
            "triangles": triangles,
            "size": size,
            "samples": args.spp,
            "max_bounces": args.max_bounces,
            "device": session.device.info().name,
            "driver": session.device.info().driver_line(),
            "backend": session.gpu.backend().to_string(),
            "seconds": best,
            "pass_ms": best_passes,
            "mpaths_per_s": paths / best * 1e-6,
            "mrays_per_s": mrays_per_s,
            "nearest_rays": rays[0],
            "shadow_rays": rays[1],
            "native_mrays_per_s": native_mrays_per_s,
            "ratio_to_native": mrays_per_s / native_mrays_per_s,
        });
        write_atomic(path, serde_json::to_string_pretty(&document)?.as_bytes())?;
    }
    Ok(true)
}
