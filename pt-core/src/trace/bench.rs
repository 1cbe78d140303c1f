//! Rays per second of every backend on one scene, and the choice that `auto` makes from them.

use super::ray_list::{Coverage, Query, RayScene, Visibility};
use super::{BvhQuality, InstancePlacement, MeshGeometry, NativeScene, TraceBackend};
use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::Result;
use crate::frame::Recorder;
use crate::rng::random4;
use glam::{Vec2, Vec3};
use pt_shaders::records::{CameraRecord, Hit, NONE, Ray};
use std::time::Instant;

/// All instances.
const ALL: u32 = 0xff;
const VISIBILITY: Visibility = Visibility { mask: ALL, seed: 0 };
/// Secondary rays start this far from their surface, relative to the scene's diagonal.
const OFFSET: f32 = 1e-5;

/// Rays a renderer shoots.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RayKind {
    /// From the camera through the pixel centres.
    Primary,
    /// Cosine-distributed from the primary hits.
    Bounce,
    /// From the primary hits to random points of the scene's bounds, any hit.
    Shadow,
    /// The same from where the bounce rays hit.
    BounceShadow,
}

impl RayKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Primary, Self::Bounce, Self::Shadow, Self::BounceShadow];

    fn query(self) -> Query {
        match self {
            Self::Primary | Self::Bounce => Query::Closest,
            Self::Shadow | Self::BounceShadow => Query::Occluded,
        }
    }
}

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
    /// Timed windows; all backends take turns within one.
    pub windows: u32,
    /// Seed of the random directions.
    pub seed: u32,
}

impl Default for BenchOptions {
    fn default() -> Self {
        Self { size: [640, 360], windows: 7, seed: 0 }
    }
}

struct RayList {
    kind: RayKind,
    rays: Vec<Ray>,
    /// Of the native traversal.
    hits: Vec<Hit>,
}

/// Million rays per second of the CPU's traversal alone, on all cores, for every kind of [`RayKind::ALL`]; best window.
///
/// # Errors
/// When the geometry makes no tree.
pub fn native_rates(
    meshes: &[MeshGeometry],
    instances: &[InstancePlacement],
    camera: &CameraRecord,
    options: BenchOptions,
) -> Result<[f64; 4]> {
    let native = NativeScene::new(meshes, instances, BvhQuality::default())?;
    let lists = ray_lists(&native, meshes, instances, camera, options);
    let rate = |list: &RayList| {
        let windows: Vec<_> = (0..options.windows.max(1)).map(|_| time_native(&native, list)).collect();
        best(&windows)
    };
    Ok(RayKind::ALL.map(|kind| lists.iter().find(|list| list.kind == kind).map_or(0.0, rate)))
}

/// Times the same rays on every available backend and on the CPU. Alpha is left out on all sides.
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
    let native = NativeScene::new(meshes, instances, BvhQuality::default())?;
    let lists = ray_lists(&native, meshes, instances, camera, options);
    let mut runs: Vec<Run> = Vec::new();
    for backend in TraceBackend::available(device) {
        let mut run = Run::new(device, meshes, instances, backend)?;
        for list in &lists {
            run.add(list)?;
        }
        runs.push(run);
    }
    let mut native_rates = vec![Vec::new(); lists.len()];
    for _ in 0..options.windows.max(1) {
        for (list, rates) in lists.iter().zip(&mut native_rates) {
            rates.push(time_native(&native, list));
            for run in &mut runs {
                run.time(list.kind)?;
            }
        }
    }
    let info = device.info();
    let mut rows = Vec::new();
    for run in runs {
        for (timed, list) in run.lists.iter().zip(&lists) {
            rows.push(BenchRow {
                backend: run.backend.name(),
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
    for (list, rates) in lists.iter().zip(native_rates) {
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

/// What `auto` measured.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Choice {
    /// The fastest.
    pub backend: TraceBackend,
    /// Million rays a second of each candidate, closest hits; empty when there was only one.
    pub mrays_per_s: Vec<(TraceBackend, f64)>,
    /// Backends that the device lacks, with the reason.
    pub missing: Vec<(TraceBackend, String)>,
}

/// Width of the launches, rays.
const LAUNCH_WIDTH: u32 = 1024;

/// Rays that `auto` times: few enough for a CPU, enough to fill a GPU for a fraction of a millisecond.
const CHOICE_RAYS: [u32; 2] = [1 << 13, 1 << 18];

/// The backends take turns: a GPU that wakes up gets faster from one run to the next, which must not decide.
const CHOICE_ROUNDS: u32 = 6;

/// The fastest backend for this scene: each is timed for a few milliseconds on rays from random points of its bounds.
///
/// # Errors
/// When a backend can't be set up.
pub fn choose(device: &Device, meshes: &[MeshGeometry], instances: &[InstancePlacement]) -> Result<Choice> {
    let reason = |b: TraceBackend| b.missing(device).map(|why| (b, why));
    let missing: Vec<_> = TraceBackend::CONCRETE.into_iter().filter_map(reason).collect();
    let available = TraceBackend::available(device);
    let bounds = scene_bounds(meshes, instances);
    let (Some((low, high)), true) = (bounds, available.len() > 1) else {
        return Ok(Choice { backend: TraceBackend::Compute, mrays_per_s: Vec::new(), missing });
    };
    let count = CHOICE_RAYS[usize::from(device.info().kind != "cpu")];
    let ray = |i: u32| choice_ray(i, low, high);
    let list = RayList { kind: RayKind::Bounce, rays: (0..count).map(ray).collect(), hits: Vec::new() };
    let mut runs = Vec::new();
    for backend in available {
        let mut run = Run::new(device, meshes, instances, backend)?;
        run.add(&list)?;
        runs.push(run);
    }
    for _ in 0..CHOICE_ROUNDS {
        for run in &mut runs {
            run.time(list.kind)?;
        }
    }
    let rates: Vec<_> = runs.iter().map(|run| (run.backend, best(&run.lists[0].rates))).collect();
    let fastest = rates.iter().copied().reduce(|a, b| if b.1 > a.1 { b } else { a });
    let backend = fastest.map_or(TraceBackend::Compute, |(backend, _)| backend);
    Ok(Choice { backend, mrays_per_s: rates, missing })
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

/// One backend with the rays that it has to trace.
struct Run {
    backend: TraceBackend,
    scene: RayScene,
    recorder: Recorder,
    lists: Vec<Timed>,
}

struct Timed {
    kind: RayKind,
    rays: Buffer,
    results: Buffer,
    launch: [u32; 2],
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
        Ok(Self { backend, scene, recorder, lists: Vec::new() })
    }

    /// Uploads the rays and traces them once: drivers compile at the first dispatch.
    fn add(&mut self, list: &RayList) -> Result<()> {
        let device = self.recorder.device().clone();
        let count = list.rays.len() as u32;
        let rays = Buffer::from_slice(&device, "rays", &list.rays)?;
        let size = u64::from(count) * size_of::<Hit>() as u64;
        let results = Buffer::new(&device, "hits", size, Location::Device)?;
        let launch = [count, LAUNCH_WIDTH.min(count)];
        self.lists.push(Timed {
            kind: list.kind,
            rays,
            results,
            launch,
            rates: Vec::new(),
            hits: Vec::new(),
        });
        self.time(list.kind)?;
        if let Some(timed) = self.lists.last_mut() {
            timed.hits = timed.results.read()?;
            timed.rates.clear();
        }
        Ok(())
    }

    fn time(&mut self, kind: RayKind) -> Result<()> {
        let Some(timed) = self.lists.iter_mut().find(|l| l.kind == kind) else { return Ok(()) };
        self.recorder.finish()?;
        let mut frame = self.recorder.begin()?;
        self.scene.trace(&mut frame, kind.query(), &timed.rays, &timed.results, timed.launch, VISIBILITY)?;
        frame.submit()?;
        let ms: f64 = self.recorder.finish()?.iter().flat_map(|f| &f.passes).map(|p| p.ms).sum();
        timed.rates.push(f64::from(timed.launch[0]) / (ms * 1e3));
        Ok(())
    }
}

fn time_native(native: &NativeScene, list: &RayList) -> f64 {
    let start = Instant::now();
    match list.kind.query() {
        Query::Closest => {
            let mut hits = list.hits.clone();
            native.closest_all(&list.rays, ALL, None, &mut hits);
            std::hint::black_box(&hits);
        }
        Query::Occluded => {
            std::hint::black_box(native.occluded_all(&list.rays, ALL, None));
        }
    }
    list.rays.len() as f64 / start.elapsed().as_secs_f64() * 1e-6
}

fn ray_lists(
    native: &NativeScene,
    meshes: &[MeshGeometry],
    instances: &[InstancePlacement],
    camera: &CameraRecord,
    options: BenchOptions,
) -> Vec<RayList> {
    let [width, height] = options.size;
    let primary: Vec<_> = (0..width * height)
        .map(|i| {
            let uv = Vec2::new((i % width) as f32 + 0.5, (i / width) as f32 + 0.5)
                / Vec2::new(width as f32, height as f32);
            camera_ray(camera, uv)
        })
        .collect();
    let missed = Hit { instance: NONE, triangle: NONE, barycentrics: Vec2::ZERO, t: 0.0 };
    let mut hits = vec![missed; primary.len()];
    native.closest_all(&primary, ALL, None, &mut hits);
    let (low, high) = native.bounds().unwrap_or_default();
    let offset = OFFSET * (high - low).length();
    // Origins on the surfaces that rays have hit, with the normals there, as many as there are pixels.
    let surfaces = |rays: &[Ray], hits: &[Hit]| -> Vec<(Vec3, Vec3)> {
        let seen: Vec<_> = (0..hits.len()).filter(|&i| hits[i].instance != NONE).collect();
        let surface = |&i: &usize| {
            let (ray, hit) = (&rays[i], &hits[i]);
            let normal = face_normal(meshes, instances, hit);
            let normal = if normal.dot(ray.direction) > 0.0 { -normal } else { normal };
            (ray.origin + ray.direction * hit.t + normal * offset, normal)
        };
        seen.iter().cycle().take(primary.len()).map(surface).collect()
    };
    let random = |number: usize, dimension| random4([number as u32, 0], 0, dimension, options.seed);
    let shadow_ray = |(number, (origin, _)): (usize, (Vec3, Vec3)), dimension| {
        let target = low + (high - low) * Vec3::from_slice(&random(number, dimension));
        let distance = (target - origin).length().max(f32::MIN_POSITIVE);
        Ray { origin, t_min: 0.0, direction: (target - origin) / distance, t_max: distance }
    };
    let bounce_ray = |(number, (origin, normal)): (usize, (Vec3, Vec3))| {
        let [r0, r1, ..] = random(number, 0);
        let (tangent, bitangent) = normal.any_orthonormal_pair();
        let (sin, cos) = (r0 * std::f32::consts::TAU).sin_cos();
        let direction = (tangent * cos + bitangent * sin) * r1.sqrt() + normal * (1.0 - r1).sqrt();
        Ray { origin, t_min: 0.0, direction: direction.normalize(), t_max: f32::MAX }
    };
    let first = surfaces(&primary, &hits);
    let bounce: Vec<_> = first.iter().copied().enumerate().map(bounce_ray).collect();
    let shadow: Vec<_> = first.iter().copied().enumerate().map(|s| shadow_ray(s, 1)).collect();
    let mut bounce_hits = vec![missed; bounce.len()];
    native.closest_all(&bounce, ALL, None, &mut bounce_hits);
    let second = surfaces(&bounce, &bounce_hits);
    let bounce_shadow: Vec<_> = second.into_iter().enumerate().map(|s| shadow_ray(s, 2)).collect();
    let trace = |kind: RayKind, rays: Vec<Ray>| {
        let mut hits = vec![missed; rays.len()];
        native.closest_all(&rays, ALL, None, &mut hits);
        RayList { kind, rays, hits }
    };
    let lists = [
        (RayKind::Primary, primary),
        (RayKind::Bounce, bounce),
        (RayKind::Shadow, shadow),
        (RayKind::BounceShadow, bounce_shadow),
    ];
    lists.into_iter().filter(|(_, rays)| !rays.is_empty()).map(|(kind, rays)| trace(kind, rays)).collect()
}

/// As camera_ray() of camera.glsl, through the lens's centre.
fn camera_ray(camera: &CameraRecord, uv: Vec2) -> Ray {
    let plane = Vec2::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y) * camera.half_extent;
    let perspective = camera.projection == 0;
    let origin = if perspective { Vec3::ZERO } else { plane.extend(0.0) };
    let direction = if perspective { plane.extend(-1.0) } else { Vec3::NEG_Z };
    Ray {
        origin: camera.world_from_view.transform_point3(origin),
        t_min: 0.0,
        direction: camera.world_from_view.transform_vector3(direction).normalize(),
        t_max: f32::MAX,
    }
}

fn face_normal(meshes: &[MeshGeometry], instances: &[InstancePlacement], hit: &Hit) -> Vec3 {
    let instance = &instances[hit.instance as usize];
    let mesh = &meshes[instance.mesh as usize];
    let index = mesh.indices[hit.triangle as usize];
    let corner = |i: u32| instance.world_from_object.transform_point3(mesh.positions[i as usize]);
    let (a, b, c) = (corner(index.x), corner(index.y), corner(index.z));
    (b - a).cross(c - a).normalize_or(Vec3::Y)
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
