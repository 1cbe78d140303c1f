//! GPU time of every light sampler on the same surfaces: nanoseconds a sample, with its shadow ray, and the bytes of its tables.
//! `cargo bench -p pt-lights --bench samplers [-- SCENE]`; without `--bench` (`cargo test --benches`) one small frame shows that it works.

use pt_core::frame::Uniforms;
use pt_core::harness::{WARM_UP, measure};
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, Device, DeviceOptions, FrameSizes, Result, StageInputs};
use pt_light_sampling::LightTables;
use pt_lights::records::LightRays;
use pt_lights::{DirectLighting, DirectParams, synthetic};
use pt_scene::Scene;
use pt_scene::gpu::GpuScene;
use pt_shaders::channels::{MOTION, SHADING_POSITION, VIEW_DEPTH};
use pt_shaders::named_enum::NamedEnum;
use pt_shaders::records::{CameraRecord, FrameRecord, LightSampler};

fn main() -> Result<()> {
    let names = pt_scene::BUILTIN.iter().map(|(name, _)| *name);
    let name = names.clone().find(|name| std::env::args().any(|a| a == *name)).unwrap_or("lamps");
    let Some(scene) = pt_scene::builtin(name) else { return Ok(()) };
    let (size, warm_up, frames) = match std::env::args().any(|a| a == "--bench") {
        true => ([640, 360], WARM_UP, 32),
        false => ([64, 36], 0, 1),
    };
    let device = Device::open(&DeviceOptions::default())?;
    println!("{}, {}", device.info().name, device.info().driver_line());
    println!("{name}, backend {}, {}x{}", TraceBackend::Compute, size[0], size[1]);
    println!("{:<14} {:>12} {:>12}", "sampler", "ns a sample", "KiB");
    for sampler in LightSampler::VALUES {
        let params = DirectParams { sampler: *sampler, rays: LightRays::Merged, ..DirectParams::default() };
        let (ns, bytes) = time(&device, &scene, &params, size, [warm_up, frames])?;
        println!("{:<14} {ns:>12.2} {:>12}", sampler.name(), bytes.div_ceil(1024));
    }
    Ok(())
}

/// Median time of a sample, nanoseconds, and the bytes of the sampler's tables.
fn time(
    device: &Device,
    scene: &Scene,
    params: &DirectParams,
    size: [u32; 2],
    [warm_up, frames]: [u32; 2],
) -> Result<(f64, u64)> {
    let mut gpu = GpuScene::new(device, scene, TraceBackend::Compute)?;
    let mut lights = LightTables::new(device, scene)?;
    lights.prepare(device, scene, &mut gpu, params.sampler_choice())?;
    let stage = DirectLighting::new(device, gpu.variant(), params)?;
    let io = DirectLighting::io(params);
    let mut images = ChannelImages::alone(device, FrameSizes::same(size), &io)?;
    // Images with a history exist twice.
    for _ in 0..2 {
        images.begin_frame();
        fill(&images, scene, &gpu)?;
    }
    let uniforms = Uniforms::<FrameRecord>::new(device, "frame_uniforms")?;
    let camera: CameraRecord = bytemuck::Zeroable::zeroed();
    let mut index = 0;
    let times = measure(device, size, warm_up, frames, |frame| {
        images.begin_frame();
        lights.update(frame, scene, &mut gpu)?;
        uniforms.upload(frame, &FrameRecord::new(camera, camera, size, index, 1))?;
        index += 1;
        let inputs = StageInputs { scene: Some(&gpu), uniforms: Some(&uniforms), images: &images };
        stage.record(frame, &inputs, params, 0.0)
    })?;
    let [width, height] = images.current(SHADING_POSITION).extent();
    let samples = f64::from(width) * f64::from(height) * f64::from(params.samples);
    let bytes = lights.sampler().map_or(0, |tables| tables.bytes());
    Ok((1e6 * times.frame.median_ms / samples, bytes))
}

/// Surfaces that stand still, all as far from the camera.
fn fill(images: &ChannelImages, scene: &Scene, gpu: &GpuScene) -> Result<()> {
    synthetic::fill_surfaces(images, scene, gpu.clusters())?;
    synthetic::fill_seeds(images, 0)?;
    let has = |id| images.ids().any(|known| known == id);
    let [width, height] = images.current(SHADING_POSITION).extent();
    let texels = (width * height) as usize;
    if has(VIEW_DEPTH) {
        images.current(VIEW_DEPTH).write(bytemuck::cast_slice(&vec![1f32; texels]))?;
    }
    if has(MOTION) {
        images.current(MOTION).write(bytemuck::cast_slice(&vec![0f32; 4 * texels]))?;
    }
    Ok(())
}
