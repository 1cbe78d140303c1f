//! Light tables (host) and the direct lighting pass (GPU time) on a built-in scene. `cargo bench -p pt-lights [-- SCENE]`.

use criterion::{Criterion, Throughput};
use pt_core::frame::Uniforms;
use pt_core::harness::{WARM_UP, measure};
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, Device, DeviceOptions, Result};
use pt_core::{FrameSizes, StageInputs};
use pt_lights::{AliasTable, DirectLighting, DirectParams, LightLists, LightTables, synthetic};
use pt_scene::gpu::GpuScene;
use pt_shaders::records::FrameRecord;
use std::time::Duration;

const SIZE: [u32; 2] = [640, 360];
const FRAMES: u32 = 32;

fn main() -> Result<()> {
    let mut criterion = Criterion::default().sample_size(10).measurement_time(Duration::from_secs(2));
    let names = pt_scene::BUILTIN.iter().map(|(name, _)| *name);
    let name = names.clone().find(|name| std::env::args().any(|a| a == *name)).unwrap_or("lamps");
    let Some(scene) = pt_scene::builtin(name) else { return Ok(()) };
    host(&mut criterion, name, &scene);
    let device = Device::open(&DeviceOptions::default())?;
    for backend in TraceBackend::available(&device) {
        gpu(&device, name, &scene, backend)?;
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
fn gpu(device: &Device, name: &str, scene: &pt_scene::Scene, backend: TraceBackend) -> Result<()> {
    let mut lights = LightTables::new(device, scene)?;
    let mut gpu = GpuScene::new(device, scene, backend)?;
    lights.attach(&mut gpu);
    let stage = DirectLighting::new(device, gpu.variant(), &DirectParams::default())?;
    let images = ChannelImages::alone(device, FrameSizes::same(SIZE), &[DirectLighting::IO])?;
    synthetic::fill_surfaces(&images, scene, gpu.clusters())?;
    synthetic::fill_seeds(&images, 0)?;
    let uniforms = Uniforms::<FrameRecord>::new(device, "frame_uniforms")?;
    let times = measure(device, SIZE, WARM_UP, FRAMES, |frame| {
        lights.update(frame, scene, &mut gpu)?;
        uniforms.upload(frame, &bytemuck::Zeroable::zeroed())?;
        stage.record(
            frame,
            &StageInputs { scene: Some(&gpu), uniforms: Some(&uniforms), images: &images },
            &DirectParams::default(),
            0.0,
        )
    })?;
    print!("direct lighting of {name}, backend {backend}\n{times}");
    Ok(())
}
