//! The direct lighting pass (GPU time) on a built-in scene. `cargo bench -p pt-lights [-- SCENE]`.

use pt_core::frame::Uniforms;
use pt_core::harness::{WARM_UP, measure};
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, Device, DeviceOptions, Result};
use pt_core::{FrameSizes, StageInputs};
use pt_light_sampling::LightTables;
use pt_lights::{DirectLighting, DirectParams, synthetic};
use pt_scene::gpu::GpuScene;
use pt_shaders::records::FrameRecord;

const SIZE: [u32; 2] = [640, 360];
const FRAMES: u32 = 32;

fn main() -> Result<()> {
    let names = pt_scene::BUILTIN.iter().map(|(name, _)| *name);
    let name = names.clone().find(|name| std::env::args().any(|a| a == *name)).unwrap_or("lamps");
    let Some(scene) = pt_scene::builtin(name) else { return Ok(()) };
    let device = Device::open(&DeviceOptions::default())?;
    for backend in TraceBackend::available(&device) {
        gpu(&device, name, &scene, backend)?;
    }
    Ok(())
}

/// Time by the GPU's own clock, one shadow ray per pixel and kind of light that the scene has.
fn gpu(device: &Device, name: &str, scene: &pt_scene::Scene, backend: TraceBackend) -> Result<()> {
    let mut lights = LightTables::new(device, scene)?;
    let mut gpu = GpuScene::new(device, scene, backend)?;
    lights.prepare(device, scene, &mut gpu, DirectParams::default().sampler_choice())?;
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
