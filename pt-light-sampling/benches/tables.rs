//! Light tables on the host. `cargo bench -p pt-light-sampling --bench tables [-- SCENE]`.

use criterion::{Criterion, Throughput};
use pt_light_sampling::{AliasTable, LightBvh, LightLists};
use std::time::Duration;

fn main() {
    let mut criterion = Criterion::default().sample_size(10).measurement_time(Duration::from_secs(2));
    let names = pt_scene::BUILTIN.iter().map(|(name, _)| *name);
    let name = names.clone().find(|name| std::env::args().any(|a| a == *name)).unwrap_or("lamps");
    let Some(scene) = pt_scene::builtin(name) else { return };
    host(&mut criterion, name, &scene);
    criterion.final_summary();
}

fn host(criterion: &mut Criterion, name: &str, scene: &pt_scene::Scene) {
    let weights: Vec<f64> = (0..1 << 17).map(|i| f64::from(i % 1000) + 0.5).collect();
    let mut group = criterion.benchmark_group("host");
    group.throughput(Throughput::Elements(weights.len() as u64));
    group.bench_function("alias table of 512x256 texels", |b| b.iter(|| AliasTable::new(&weights)));
    group.finish();
    criterion.bench_function(&format!("host/light lists of {name}"), |b| b.iter(|| LightLists::new(scene)));
    let lights = LightLists::new(scene).local;
    criterion.bench_function(&format!("host/light tree of {name}"), |b| b.iter(|| LightBvh::new(&lights)));
    let Some(mut tree) = LightBvh::new(&lights) else { return };
    criterion
        .bench_function(&format!("host/light tree of {name}, refit"), |b| b.iter(|| tree.refit(&lights)));
}
