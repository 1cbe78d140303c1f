//! Brute-force direct light of the Cornell box. `cargo bench -p pt-reference`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use pt_reference::direct::{DirectLight, Quality};

fn cornell(criterion: &mut Criterion) {
    let Some(scene) = pt_scene::builtin("cornell") else { return };
    let Ok(light) = DirectLight::new(&scene, Quality::default()) else { return };
    let camera = scene.default_camera();
    let mut group = criterion.benchmark_group("direct light");
    group.sample_size(10).throughput(Throughput::Elements(16 * 16));
    group.bench_function("cornell 16x16", |b| b.iter(|| light.image(&camera, [16, 16])));
    group.finish();
}

criterion_group!(benches, cornell);
criterion_main!(benches);
