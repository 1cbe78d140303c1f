//! Light tables (host) and the direct lighting pass (GPU time) on a built-in scene. `cargo bench -p pt-lights [-- SCENE]`.

use criterion::{Criterion, Throughput};
use pt_core::frame::Uniforms;
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, Device, DeviceOptions, Recorder, Result};
use pt_lights::{AliasTable, DirectLighting, DirectParams, LightLists, LightTables, synthetic};
use pt_scene::gpu::GpuScene;
use pt_shaders::records::FrameRecord;
use std::time::Duration;

const SIZE: [u32; 2] = [640, 360];

fn main() -> Result<()> {
    let mut criterion = Criterion::default().sample_size(10).measurement_time(Duration::from_secs(2));
    let names = pt_scene::BUILTIN.iter().map(|(name, _)| *name);
    let name = names.clone().find(|name| std::env::args().any(|a| a == *name)).unwrap_or("lamps");
    let Some(scene) = pt_scene::builtin(name) else { return Ok(()) };
    host(&mut criterion, name, &scene);
    let device = Device::open(&DeviceOptions::default())?;
    for backend in TraceBackend::available(&device) {
        gpu(&mut criterion, &device, name, &scene, backend)?;
    }
    criterion.final_summary();
    Ok(())
}

fn host(criterion: &mut Criterion, name: &str, scene: &pt_scene::Scene) {
    let weights: Vec<f64> = (0..1 << 17).map(|i| f64::from(i % 1000) + 0.5).collect();
    let mut group = criterion.benchmark_group("host");
    group.throughput(Throughput::Elements(weights.len() as u64));
    group.bench_function("alias table of 512x256 texels", |b| b.iter(|| AliasTable::new(&weights)));
    group.finish();
    criterion.bench_function(&format!("host/light lists of {name}"), |b| b.iter(|| LightLists::new(scene)));
}

/// Time by the GPU's own clock, one shadow ray per pixel and kind of light that the scene has.
fn gpu(
    criterion: &mut Criterion,
    device: &Device,
    name: &str,
    scene: &pt_scene::Scene,
    backend: TraceBackend,
) -> Result<()> {
    let lights = LightTables::new(device, scene)?;
    let mut gpu = GpuScene::new(device, scene, backend)?;
    lights.fill(gpu.record_mut());
    let stage = DirectLighting::new(device, backend)?;
    let channels = DirectLighting::READS.iter().chain(DirectLighting::WRITES).copied();
    let images = ChannelImages::new(device, SIZE, channels)?;
    synthetic::fill_surfaces(&images, scene)?;
    synthetic::fill_seeds(&images, 0)?;
    let uniforms = Uniforms::<FrameRecord>::new(device, "frame_uniforms")?;
    let mut recorder = Recorder::new(device)?;
    let mut pass = || -> Result<f64> {
        let mut frame = recorder.begin()?;
        gpu.update(&mut frame, scene)?;
        uniforms.upload(&mut frame, &bytemuck::Zeroable::zeroed())?;
        stage.record(&mut frame, &gpu, &lights, &uniforms, &images, &DirectParams::default())?;
        frame.submit()?;
        Ok(recorder.finish()?.iter().filter_map(|t| t.passes.last()).map(|p| p.ms).sum())
    };
    // Structures are built in the first frame.
    pass()?;
    let mut group = criterion.benchmark_group(format!("direct lighting of {name}"));
    group.throughput(Throughput::Elements(u64::from(SIZE[0] * SIZE[1])));
    group.bench_function(backend.name(), |b| {
        b.iter_custom(|n| {
            Duration::from_secs_f64(1e-3 * (0..n).map(|_| pass().expect("a pass")).sum::<f64>())
        });
    });
    group.finish();
    Ok(())
}
