//! `pt bench path` measures the whole path loop of the reference path tracer, and the CPU tracing the same number of rays.

use crate::args::values::assignment;
use crate::args::{CameraArgs, DeviceArgs, SceneArgs};
use crate::commands::bench::least_warm_up_s;
use crate::commands::reference::BYTES_PER_PIXEL;
use crate::inputs::Inputs;
use crate::params::{ReferenceSettings, resolve_reference};
use crate::session::{Session, check_host_memory, open_scene};
use anyhow::Result;
use clap::Args;
use pt_core::trace::{NativeRays, RayKind};
use pt_image::atomic_file::{check_writable, write_atomic};
use pt_image::image_file::ImageSize;
use pt_reference::{Progressive, ReferenceParams};
use pt_scene::gpu::{camera_record, mesh_geometry, placements};
use pt_shaders::records::FrameRecord;
use serde_json::json;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

/// `pt bench path`
#[derive(Clone, Debug, Args)]
pub struct BenchPathArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The camera.
    #[command(flatten)]
    pub camera: CameraArgs,
    /// Also write the result to this JSON file.
    #[arg(long, value_name = "F")]
    pub json: Option<PathBuf>,
    /// Image size.
    #[arg(long, value_name = "WxH", default_value = "320x180")]
    pub size: ImageSize,
    /// Samples of each pixel in a timed window.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: u32,
    /// Maximum number of scattering events after the first hit.
    #[arg(long, value_name = "B", default_value_t = 8)]
    pub max_bounces: u32,
    /// Scattering events before Russian roulette begins.
    #[arg(long, value_name = "K", default_value_t = ReferenceParams::default().roulette_start)]
    pub roulette_start: u32,
    /// Number of timed windows; the median is reported.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    pub windows: u32,
    /// Set one knob of the path tracer, such as reference.lights=per-kind; may be repeated.
    #[arg(long = "set", value_name = "reference.key=value", value_parser = assignment)]
    pub set: Vec<String>,
    /// Device and trace backend.
    #[command(flatten)]
    pub device: DeviceArgs,
}

/// Most rays of a kind that the CPU traces in a window, where a GPU has traced many more.
const MOST_NATIVE_RAYS: f64 = 2e6;

/// Times of a number of samples on the device, and of the CPU tracing the same number of rays after it.
struct Window {
    seconds: f64,
    pass_ms: BTreeMap<String, f64>,
    /// Nearest hits, shadow rays.
    rays: [f64; 2],
    native: NativeTimes,
}

/// The CPU's traversal of as many rays.
struct NativeTimes {
    /// For each of [`RayKind::ALL`].
    mrays_per_s: [f64; 4],
    seconds: f64,
}

impl NativeTimes {
    /// `counts`: rays of each of [`RayKind::ALL`].
    fn of(native: &NativeRays, counts: [f64; 4]) -> Self {
        // A rate needs a ray, though a mean of few rays may be less than one.
        let traced = counts.map(|count| count.clamp(1.0, MOST_NATIVE_RAYS) as usize);
        let mrays_per_s = [0, 1, 2, 3].map(|i| native.mrays_per_s(RayKind::ALL[i], traced[i]));
        // A scene that no ray hits has no further rays.
        let kinds = counts.iter().zip(mrays_per_s).filter(|(_, rate)| *rate > 0.0);
        let seconds = kinds.map(|(count, rate)| count / rate * 1e-6).sum();
        Self { mrays_per_s, seconds }
    }
}

impl Window {
    fn ratio(&self) -> f64 {
        self.native.seconds / self.seconds
    }
}

/// Runs the command.
///
/// # Errors
/// Unknown scene or device, a file that can't be written.
pub fn run(args: &BenchPathArgs, out: &mut impl Write) -> Result<bool> {
    if let Some(path) = &args.json {
        Inputs::of_scene(&args.scene, &args.camera, None).check([path])?;
        check_writable(path)?;
    }
    let reference = resolve_reference(ReferenceSettings::default(), None, &args.set)?.reference;
    let size = [args.size.width, args.size.height];
    check_host_memory("a reference image", size, BYTES_PER_PIXEL)?;
    let scene = open_scene(&args.scene.file, &args.scene.load_options())?;
    let mut session = Session::open(&args.device, &args.camera, scene)?;
    let record = camera_record(&session.camera.at(args.scene.time), size);
    let native =
        NativeRays::new(&mesh_geometry(&session.scene), &placements(&session.scene), &record, size, 0)?;
    let triangles = session.scene.statistics().instanced_triangles;

    let frame = FrameRecord::new(record, record, size, 0, 0);
    let params = ReferenceParams {
        max_bounces: Some(args.max_bounces),
        roulette_start: args.roulette_start,
        ..reference
    };
    let Session { device, scene, gpu, lights, .. } = &mut session;
    params.prepare_lights(device, scene, gpu, lights)?;
    let mut render = Progressive::new(device, gpu, lights, frame, params, None, 0)?;
    let least_warm_up_s = least_warm_up_s(&session.device);
    // Milliseconds of each pass until so many samples are done.
    let mut render_to = |render: &mut Progressive, end| -> Result<BTreeMap<String, f64>> {
        let mut pass_ms = BTreeMap::new();
        while render.next_sample() < end {
            let frame = render.step(&session.scene, &mut session.gpu, &mut session.lights, end)?;
            for pass in frame.into_iter().flat_map(|frame| frame.passes) {
                *pass_ms.entry(pass.pass).or_default() += pass.ms;
            }
        }
        Ok(pass_ms)
    };
    // Compiles the kernels, and finds out how many samples fit into a step.
    render_to(&mut render, args.spp)?;
    let mut before = render.state()?;
    let paths = f64::from(size[0]) * f64::from(size[1]) * f64::from(args.spp);
    let trace_native = |rays| NativeTimes::of(&native, native_rays(paths, rays));
    // A processor that is also the device takes turns, so that both meet the same machine; a GPU would lower its clock meanwhile.
    let in_turns = session.device.info().is_cpu();
    let mut measured = Vec::new();
    for _ in 0..args.windows {
        let first = render.next_sample();
        // Reading the sums takes time in which a GPU lowers its clock, so that each window has a warm-up of its own.
        let started = Instant::now();
        while started.elapsed().as_secs_f64() < least_warm_up_s {
            let end = render.next_sample() + args.spp;
            render_to(&mut render, end)?;
        }
        let end = render.next_sample() + args.spp;
        let started = Instant::now();
        let pass_ms = render_to(&mut render, end)?;
        let seconds = started.elapsed().as_secs_f64();
        let after = render.state()?;
        // The window's share of those since the last sums.
        let share = f64::from(args.spp) / f64::from(end - first);
        let rays = [0, 1].map(|kind| (after.rays()[kind] - before.rays()[kind]) as f64 * share);
        before = after;
        measured.push((seconds, pass_ms, rays, in_turns.then(|| trace_native(rays))));
    }
    session.check_validation()?;
    let mut windows: Vec<_> = measured
        .into_iter()
        .map(|(seconds, pass_ms, rays, native)| {
            let native = native.unwrap_or_else(|| trace_native(rays));
            Window { seconds, pass_ms, rays, native }
        })
        .collect();

    let mut ratios: Vec<_> = windows.iter().map(Window::ratio).collect();
    ratios.sort_by(f64::total_cmp);
    let ratio = ratios[ratios.len() / 2];
    windows.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    let window = &windows[windows.len() / 2];
    let [nearest, shadow] = window.rays;
    let mrays = (nearest + shadow) * 1e-6;
    let native = window.native.mrays_per_s;
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
    writeln!(out, "{:>12.2} Mpaths/s (median of {} windows)", paths / window.seconds * 1e-6, windows.len())?;
    writeln!(
        out,
        "{:>12.2} Mrays/s ({:.2} nearest and {:.2} shadow rays a path)",
        mrays / window.seconds,
        nearest / paths,
        shadow / paths
    )?;
    writeln!(
        out,
        "{:>12.2} Mrays/s native traversal of as many rays (primary {:.2}, bounce {:.2}, shadow {:.2}, from bounces {:.2})",
        mrays / window.native.seconds,
        native[0],
        native[1],
        native[2],
        native[3]
    )?;
    writeln!(out, "{ratio:>12.2} x native (median; {:.2} to {:.2})", ratios[0], ratios[ratios.len() - 1])?;
    for (pass, ms) in &window.pass_ms {
        writeln!(out, "{ms:>12.2} ms {pass}")?;
    }
    writeln!(out, "{:>12.2} ms in all, by the wall clock", window.seconds * 1e3)?;
    if let Some(path) = &args.json {
        let document = json!({
            "scene": session.scene.name,
            "triangles": triangles,
            "size": size,
            "samples": args.spp,
            "max_bounces": args.max_bounces,
            "set": args.set,
            "device": session.device.info().name,
            "driver": session.device.info().driver_line(),
            "backend": session.gpu.backend().to_string(),
            "seconds": window.seconds,
            "pass_ms": window.pass_ms,
            "mpaths_per_s": paths / window.seconds * 1e-6,
            "mrays_per_s": mrays / window.seconds,
            "nearest_rays": nearest as u64,
            "shadow_rays": shadow as u64,
            "native_mrays_per_s": mrays / window.native.seconds,
            "ratio_to_native": ratio,
            "ratios_to_native": ratios,
        });
        write_atomic(path, serde_json::to_string_pretty(&document)?.as_bytes())?;
    }
    Ok(true)
}

/// Rays of each kind of [`RayKind::ALL`]: those of paths are bounce rays but for the first, and so are the shadow rays, in the same proportion.
fn native_rays(paths: f64, [nearest, shadow]: [f64; 2]) -> [f64; 4] {
    let first = (paths / nearest).min(1.0);
    [first * nearest, (1.0 - first) * nearest, first * shadow, (1.0 - first) * shadow]
}

#[cfg(test)]
mod tests {
    use super::*;
    use pt_scene::Camera;
    use pt_shaders::glam::Vec3;

    /// A kind with less than one ray has a rate, one that the scene has not takes no time: no ratio is infinite.
    #[test]
    fn few_rays_or_none_make_finite_times() {
        let scene = pt_import::open("cornell", &Default::default()).unwrap();
        let times = |camera: Camera, counts| {
            let camera = camera_record(&camera, [8, 8]);
            let native =
                NativeRays::new(&mesh_geometry(&scene), &placements(&scene), &camera, [8, 8], 0).unwrap();
            NativeTimes::of(&native, counts)
        };
        let seen = times(scene.default_camera(), [64.0, 20.0, 0.25, 0.0]);
        assert!(seen.seconds.is_finite() && seen.seconds > 0.0, "{}", seen.seconds);
        assert!(
            seen.mrays_per_s.iter().all(|rate| rate.is_finite() && *rate > 0.0),
            "{:?}",
            seen.mrays_per_s
        );
        let away = Camera::look_at("away", Vec3::splat(1e3), Vec3::splat(2e3), 0.8);
        let empty = times(away, [64.0, 20.0, 0.25, 0.0]);
        assert!(empty.seconds.is_finite() && empty.seconds > 0.0, "{}", empty.seconds);
        assert_eq!(empty.mrays_per_s[1..], [0.0; 3]);
    }
}
