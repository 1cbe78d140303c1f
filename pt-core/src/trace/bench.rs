//! Rays per second of every backend on one scene, and the choice that `auto` makes from them.

use super::bench_rays::{ALL, NativeRays, RayKind, RayList};
use super::ray_list::{Coverage, Query, RayScene, Visibility};
use super::{InstancePlacement, MeshGeometry, TraceBackend};
use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::Result;
use crate::frame::Recorder;
use crate::rng::random4;
use glam::Vec3;
use pt_shaders::records::{CameraRecord, Hit, NONE, Ray};
use std::time::Instant;

const VISIBILITY: Visibility = Visibility { mask: ALL, seed: 0 };

/// One row of the bench.
#[derive(Clone, Debug, serde::Serialize)]
pub struct BenchRow {
    /// `compute`, `ray-query`, `rt-pipeline`, or `native` for the CPU's traversal on all cores.
    pub backend: &'static str,
    /// Kind of rays.
    pub kind: RayKind,
    /// Best window, million rays a second.
    pub mrays_per_s: f64,
    /// Median window, million rays a second.
    pub median_mrays_per_s: f64,
    /// Rays of a window.
    pub rays: usize,
    /// Rays that hit something.
    pub hits: usize,
    /// Share of the rays whose result is that of the native traversal: same triangle (or the same t to 1e-4), same occlusion.
    pub agreement: f64,
    /// Device name; for `native` the number of threads.
    pub device: String,
    /// Driver name and version; for `native` the library.
    pub driver: String,
}

/// Options of [`bench()`].
#[derive(Clone, Copy, Debug)]
pub struct BenchOptions {
    /// Width and height of the primary rays' image; every kind has as many rays.
    pub size: [u32; 2],
    /// Timed windows of each backend and kind.
    pub windows: u32,
    /// Seed of the random directions.
    pub seed: u32,
}

/// Size with as many rays as it takes to fill the device: a CPU, and a large GPU, which is not full for the last of its waves.
pub fn default_size(device: &Device) -> [u32; 2] {
    if device.info().is_cpu() { [640, 360] } else { [3840, 2160] }
}

/// A device is warm when this many batches in a row were no faster than the best before by more than a share of it.
const STEADY_BATCHES: u32 = 3;
const STEADY_SHARE: f64 = 0.02;
const BATCH_MS: f64 = 50.0;
/// Least seconds of load until a GPU is taken for warm: at first the rate is steady too, at the idle clock.
const LEAST_WARM_UP_S: f64 = 1.0;
/// Most seconds until a device is taken for warm.
const WARM_UP_S: f64 = 5.0;

/// Times the same rays on every available backend and on the CPU. Alpha is left out on all sides. The device is measured in one go, each
/// backend once its rate is steady and its windows back to back, so that its clock does not fall while the CPU traces; the CPU after it.
///
/// # Errors
/// When a backend can't be set up.
pub fn bench(
    device: &Device,
    meshes: &[MeshGeometry],
    instances: &[InstancePlacement],
    camera: &CameraRecord,
    options: BenchOptions,
) -> Result<Vec<BenchRow>> {
    let native = NativeRays::new(meshes, instances, camera, options.size, options.seed)?;
    let windows = options.windows.max(1);
    let info = device.info();
    let mut rows = Vec::new();
    for backend in TraceBackend::available(device) {
        let mut run = Run::new(device, meshes, instances, backend)?;
        for list in &native.lists {
            let mut timed = run.add(list)?;
            run.warm_up(&mut timed)?;
            run.time(&mut timed, windows)?;
            rows.push(BenchRow {
                backend: backend.name(),
                kind: list.kind,
                mrays_per_s: best(&timed.rates),
                median_mrays_per_s: median(&timed.rates),
                rays: list.rays.len(),
                hits: timed.hits.iter().filter(|h| h.instance != NONE).count(),
                agreement: agreement(list, &timed.hits),
                device: info.name.clone(),
                driver: format!("{} {}", info.driver, info.driver_version),
            });
        }
    }
    for list in &native.lists {
        let rates: Vec<_> = (0..windows).map(|_| native.mrays_per_s(list.kind, list.rays.len())).collect();
        rows.push(BenchRow {
            backend: "native",
            kind: list.kind,
            mrays_per_s: best(&rates),
            median_mrays_per_s: median(&rates),
            rays: list.rays.len(),
            hits: list.hits.iter().filter(|h| h.instance != NONE).count(),
            agreement: 1.0,
            device: format!("CPU, {} threads", rayon::current_num_threads()),
            driver: "obvhs 0.4".into(),
        });
    }
    Ok(rows)
}

/// Million rays of one kind a second by one backend, in the best window: what [`bench()`] says, without the other rows. 0: there are no such rays.
///
/// # Errors
/// When the backend can't be set up.
pub fn rate(
    device: &Device,
    (meshes, instances): (&[MeshGeometry], &[InstancePlacement]),
    camera: &CameraRecord,
    (backend, kind): (TraceBackend, RayKind),
    options: BenchOptions,
) -> Result<f64> {
    let rates = rates(device, (meshes, instances), camera, (backend, &[kind]), options)?;
    Ok(rates.first().map_or(0.0, |(_, rate)| *rate))
}

/// As [`rate`], of several kinds of rays; those that the scene has not are left out.
///
/// # Errors
/// When the backend can't be set up.
pub fn rates(
    device: &Device,
    (meshes, instances): (&[MeshGeometry], &[InstancePlacement]),
    camera: &CameraRecord,
    (backend, kinds): (TraceBackend, &[RayKind]),
    options: BenchOptions,
) -> Result<Vec<(RayKind, f64)>> {
    let rays = NativeRays::new(meshes, instances, camera, options.size, options.seed)?;
    let lists: Vec<_> =
        rays.lists.iter().filter(|list| kinds.contains(&list.kind) && !list.rays.is_empty()).collect();
    let mut rates = Vec::new();
    if lists.is_empty() {
        return Ok(rates);
    }
    let mut run = Run::new(device, meshes, instances, backend)?;
    for list in lists {
        let mut timed = run.add(list)?;
        run.warm_up(&mut timed)?;
        run.time(&mut timed, options.windows.max(1))?;
        rates.push((list.kind, best(&timed.rates)));
    }
    Ok(rates)
}

/// The measurements of `auto`.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Choice {
    /// The compute backend, or the fastest other one that is faster by [`CLEARLY_FASTER`].
    pub backend: TraceBackend,
    /// Million rays a second of each candidate, closest hits; empty when nothing was measured.
    pub mrays_per_s: Vec<(TraceBackend, f64)>,
    /// Backends that the device lacks, with the reason.
    pub missing: Vec<(TraceBackend, String)>,
}

/// Width of the launches, rays.
const LAUNCH_WIDTH: u32 = 1024;

/// Rays that `auto` times: enough to fill a GPU for a fraction of a millisecond.
const CHOICE_RAYS: u32 = 1 << 18;

/// The backends take turns: a GPU raises its clock from one run to the next, which must not affect the choice.
const CHOICE_ROUNDS: u32 = 6;

/// Speed relative to compute that another backend must reach. Measurements of milliseconds vary by tens of per cent, and a choice that
/// changes from run to run changes the last bits of pictures. Ray tracing hardware is several times as fast.
pub const CLEARLY_FASTER: f64 = 1.5;

/// The backend for this scene, see [`Choice`]. A CPU device takes compute. On others each is timed for a few milliseconds on rays from random points of its bounds,
/// except for rt-reorder: what sorting gains shows in shading and not in rays.
///
/// # Errors
/// When a backend can't be set up.
pub fn choose(device: &Device, meshes: &[MeshGeometry], instances: &[InstancePlacement]) -> Result<Choice> {
    let reason = |b: TraceBackend| b.missing(device).map(|why| (b, why));
    let missing: Vec<_> = TraceBackend::CONCRETE.into_iter().filter_map(reason).collect();
    let mut available = TraceBackend::available(device);
    available.retain(|&b| b != TraceBackend::RtReorder);
    let bounds = scene_bounds(meshes, instances);
    // Backends of a CPU device run the same instructions on the same cores, and a loaded machine would choose for them.
    let differ = available.len() > 1 && device.info().kind != "cpu";
    let (Some((low, high)), true) = (bounds, differ) else {
        return Ok(Choice { backend: TraceBackend::Compute, mrays_per_s: Vec::new(), missing });
    };
    let ray = |i: u32| choice_ray(i, low, high);
    let list = RayList { kind: RayKind::Bounce, rays: (0..CHOICE_RAYS).map(ray).collect(), hits: Vec::new() };
    let mut runs = Vec::new();
    for backend in available {
        let mut run = Run::new(device, meshes, instances, backend)?;
        let timed = run.add(&list)?;
        runs.push((backend, run, timed));
    }
    for _ in 0..CHOICE_ROUNDS {
        for (_, run, timed) in &mut runs {
            run.time(timed, 1)?;
        }
    }
    let rates: Vec<_> = runs.iter().map(|(backend, _, timed)| (*backend, best(&timed.rates))).collect();
    Ok(Choice { backend: preferred(&rates), mrays_per_s: rates, missing })
}

fn preferred(rates: &[(TraceBackend, f64)]) -> TraceBackend {
    let weighted = |&(backend, rate): &(TraceBackend, f64)| {
        if backend == TraceBackend::Compute { CLEARLY_FASTER * rate } else { rate }
    };
    let best = rates.iter().max_by(|a, b| weighted(a).total_cmp(&weighted(b)));
    best.map_or(TraceBackend::Compute, |&(backend, _)| backend)
}

/// Rays as a frame shoots them, a workgroup's tile of the launch from one point: neighbouring directions (primary rays) in
/// every other tile, directions of their own (bounces) in the rest. Rays without any coherence would favour the wrong backend.
fn choice_ray(i: u32, low: Vec3, high: Vec3) -> Ray {
    let (x, y) = (i % LAUNCH_WIDTH, i / LAUNCH_WIDTH);
    let tile = x / 8 + y / 4 * (LAUNCH_WIDTH / 8);
    let unit = |key: [u32; 2], dimension| Vec3::from_slice(&random4(key, 0, dimension, 0));
    let origin = low + (high - low) * unit([tile, 0], 0);
    let shared = unit([tile, 0], 1) - 0.5;
    let own = unit([x, y], 2) - 0.5;
    let direction = if tile.is_multiple_of(2) { shared.normalize_or(Vec3::Y) + 0.05 * own } else { own };
    Ray { origin, t_min: 0.0, direction: direction.normalize_or(Vec3::Y), t_max: f32::MAX }
}

/// One backend.
struct Run {
    scene: RayScene,
    recorder: Recorder,
}

/// Rays that it traces, and how fast it was.
struct Timed {
    query: Query,
    rays: Buffer,
    results: Buffer,
    launch: [u32; 2],
    /// Million rays a second.
    rates: Vec<f64>,
    hits: Vec<Hit>,
}

impl Run {
    fn new(
        device: &Device,
        meshes: &[MeshGeometry],
        instances: &[InstancePlacement],
        backend: TraceBackend,
    ) -> Result<Self> {
        let mut scene = RayScene::new(device, meshes, instances.len(), backend, Coverage::Opaque)?;
        let mut recorder = Recorder::new(device)?;
        let mut frame = recorder.begin()?;
        scene.place(&mut frame, instances)?;
        frame.submit()?;
        recorder.finish()?;
        Ok(Self { scene, recorder })
    }

    /// Uploads the rays and traces them once: drivers compile at the first dispatch.
    fn add(&mut self, list: &RayList) -> Result<Timed> {
        let device = self.recorder.device().clone();
        let count = list.rays.len() as u32;
        let size = u64::from(count) * size_of::<Hit>() as u64;
        let mut timed = Timed {
            query: list.kind.query(),
            rays: Buffer::from_slice(&device, "rays", &list.rays)?,
            results: Buffer::new(&device, "hits", size, Location::Device)?,
            launch: [count, LAUNCH_WIDTH.min(count)],
            rates: Vec::new(),
            hits: Vec::new(),
        };
        self.time(&mut timed, 1)?;
        timed.hits = timed.results.read()?;
        timed.rates.clear();
        Ok(timed)
    }

    /// Traces until the rate does not rise any more.
    fn warm_up(&mut self, timed: &mut Timed) -> Result<()> {
        let started = Instant::now();
        let least = if self.recorder.device().info().is_cpu() { 0.0 } else { LEAST_WARM_UP_S };
        let (mut fastest, mut steady, mut launches) = (0.0f64, 0, 1);
        loop {
            let elapsed = started.elapsed().as_secs_f64();
            if elapsed >= WARM_UP_S || steady >= STEADY_BATCHES && elapsed >= least {
                break;
            }
            timed.rates.clear();
            self.time(timed, launches)?;
            let rate = median(&timed.rates);
            steady = if rate > fastest * (1.0 + STEADY_SHARE) { 0 } else { steady + 1 };
            fastest = fastest.max(rate);
            let ms = f64::from(timed.launch[0]) / (rate * 1e3);
            launches = (BATCH_MS / ms).clamp(1.0, 1000.0) as u32;
        }
        timed.rates.clear();
        Ok(())
    }

    /// Traces the rays `launches` times, without a pause of the device.
    fn time(&mut self, timed: &mut Timed, launches: u32) -> Result<()> {
        for _ in 0..launches {
            let mut frame = self.recorder.begin()?;
            let Timed { query, rays, results, launch, .. } = &*timed;
            self.scene.trace(&mut frame, *query, rays, results, *launch, VISIBILITY)?;
            frame.submit()?;
        }
        let frames = self.recorder.finish()?;
        let ms = frames.iter().map(|frame| frame.passes.iter().map(|pass| pass.ms).sum::<f64>());
        timed.rates.extend(ms.map(|ms| f64::from(timed.launch[0]) / (ms * 1e3)));
        Ok(())
    }
}

fn scene_bounds(meshes: &[MeshGeometry], instances: &[InstancePlacement]) -> Option<(Vec3, Vec3)> {
    let points = instances.iter().flat_map(|i| {
        let positions = meshes.get(i.mesh as usize).map_or(&[][..], |m| m.positions);
        positions.iter().map(|&p| i.world_from_object.transform_point3(p)).filter(|p| p.is_finite())
    });
    points.fold(None, |bounds, p| {
        Some(bounds.map_or((p, p), |(low, high): (Vec3, Vec3)| (low.min(p), high.max(p))))
    })
}

fn agreement(list: &RayList, hits: &[Hit]) -> f64 {
    let same = |(a, b): &(&Hit, &Hit)| {
        let both = (a.instance == NONE) == (b.instance == NONE);
        let named = a.instance == b.instance && a.triangle == b.triangle;
        both && (a.instance == NONE
            || list.kind.query() == Query::Occluded
            || named
            || (a.t - b.t).abs() <= 1e-4 * a.t.abs())
    };
    list.hits.iter().zip(hits).filter(same).count() as f64 / hits.len().max(1) as f64
}

fn best(rates: &[f64]) -> f64 {
    rates.iter().copied().fold(0.0, f64::max)
}

fn median(rates: &[f64]) -> f64 {
    let mut sorted = rates.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use TraceBackend::{Compute, RayQuery, RtPipeline};

    #[test]
    fn only_what_is_clearly_faster_replaces_compute() {
        assert_eq!(preferred(&[(Compute, 10.0), (RayQuery, 14.0), (RtPipeline, 14.9)]), Compute);
        assert_eq!(preferred(&[(Compute, 10.0), (RayQuery, 16.0), (RtPipeline, 40.0)]), RtPipeline);
        assert_eq!(preferred(&[(Compute, 10.0), (RayQuery, 41.0), (RtPipeline, 40.0)]), RayQuery);
    }
}
