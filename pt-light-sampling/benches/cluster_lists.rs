//! Lists of lights per cluster: built for 20,000 emissive triangles and 4,096 clusters, and updated when 100 lights have moved.
//! `cargo bench -p pt-light-sampling --bench cluster_lists`; with `-- huge` also 2 million lights.

use criterion::Criterion;
use pt_core::rng::pcg4d;
use pt_light_sampling::LightBounds;
use pt_light_sampling::cluster_lists::{ClusterBox, ClusterLists, ListLimits};
use pt_scene::Bounds;
use pt_scene::glam::Vec3;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// A hall, metres.
const HALL: Vec3 = Vec3::new(200.0, 20.0, 200.0);
/// Clusters along each axis.
const SIDE: u32 = 16;

fn random(i: u32, seed: u32) -> Vec3 {
    let [x, y, z, _] = pcg4d([i, 0, 0, seed]).map(|x| x as f32 / u32::MAX as f32);
    Vec3::new(x, y, z)
}

fn triangles(count: u32, at: f32) -> Vec<LightBounds> {
    let triangle = |i| {
        let corner = random(i, 1) * HALL + at * Vec3::Z;
        LightBounds {
            bounds: Bounds { min: corner, max: corner + 0.3 * random(i, 2) },
            axis: (random(i, 3) - 0.5).normalize_or(Vec3::Y),
            cos_spread: 1.0,
            cos_emission: 0.0,
            power: 0.1 + 10.0 * random(i, 4).x,
            irradiance: 0.0,
        }
    };
    (0..count).map(triangle).collect()
}

fn boxes() -> Vec<ClusterBox> {
    let cell = HALL / SIDE as f32;
    let of = |i: u32| {
        let at = Vec3::from([i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE].map(|k| k as f32));
        ClusterBox { bounds: Bounds { min: at * cell, max: (at + 1.0) * cell }, open: false }
    };
    (0..SIDE * SIDE * SIDE).map(of).collect()
}

fn main() {
    let mut criterion = Criterion::default().sample_size(10).measurement_time(Duration::from_secs(5));
    let lights = triangles(20_000, 0.0);
    let build = |lights: &[LightBounds], may_change: &[bool], limits| {
        ClusterLists::new(boxes(), lights, may_change, limits, None)
    };
    let all = ListLimits { min_share: 0.0, max_entries: 1 << 22, ..ListLimits::default() };
    for (name, limits) in [("default limits", ListLimits::default()), ("4096 x 1024 entries", all)] {
        let lists = build(&lights, &[], limits);
        println!("{name}: {} entries", lists.fixed.entries.len());
        criterion.bench_function(&format!("20,000 triangles x 4,096 clusters, {name}"), |b| {
            b.iter(|| build(&lights, &[], limits))
        });
    }

    let mut lights = lights;
    let may_change: Vec<bool> = (0..lights.len()).map(|i| i < 100).collect();
    let mut lists = build(&lights, &may_change, ListLimits::default());
    let places = [triangles(100, 0.5), triangles(100, 1.0)];
    let mut frame = 0;
    let mut update = || {
        frame += 1;
        lights[..100].copy_from_slice(&places[frame % 2]);
        black_box(lists.update(&lights, &may_change, None));
    };
    criterion.bench_function("100 of 20,000 lights moved", |b| b.iter(&mut update));
    // The time of one thread is the CPU time.
    match rayon::ThreadPoolBuilder::new().num_threads(1).build() {
        Ok(pool) => {
            criterion.bench_function("100 of 20,000 lights moved, one thread", |b| {
                b.iter(|| pool.install(&mut update))
            });
        }
        Err(error) => eprintln!("no measurement with one thread: {error}"),
    }

    if std::env::args().any(|a| a == "huge") {
        let lights = triangles(2_000_000, 0.0);
        let start = Instant::now();
        let lists = build(&lights, &[], ListLimits::default());
        println!("2,000,000 triangles: {:.1?}, {} entries", start.elapsed(), lists.fixed.entries.len());
    }
    criterion.final_summary();
}
