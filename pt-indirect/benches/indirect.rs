//! GPU time of the indirect lighting of the built-in gallery with one bounce, on the backend that auto takes, after the primary rays that it
//! starts from. `cargo bench -p pt-indirect [-- WIDTHxHEIGHT]`.
//!
//! One thread is one path: at most 2 rays. Bytes are those of the images.

use pt_core::frame::Uniforms;
use pt_core::harness::bench;
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, Frame, FrameSizes, StageInputs};
use pt_gbuffer::{GbufferParams, PrimaryRays};
use pt_indirect::{BounceLights, IndirectLighting, IndirectParams};
use pt_light_sampling::{LightTables, SamplerChoice};
use pt_scene::gpu::{GpuScene, camera_record};
use pt_shaders::records::{FrameRecord, LightSampler};
use std::process::ExitCode;

const SAMPLER: LightSampler = LightSampler::ClusterCdf;

fn main() -> ExitCode {
    bench([1280, 720], |device, size| {
        let scene = pt_import::open("gallery", &Default::default())?;
        let camera = camera_record(&scene.default_camera(), size);
        let mut gpu = GpuScene::new(device, &scene, TraceBackend::Auto)?;
        let mut lights = LightTables::new(device, &scene)?;
        lights.prepare(device, &scene, &mut gpu, Some(SamplerChoice::from(SAMPLER)))?;
        let primary = PrimaryRays::new(device, gpu.variant())?;
        let stage = IndirectLighting::new(
            device,
            gpu.variant(),
            BounceLights::all(SAMPLER),
            &IndirectParams::default(),
            GbufferParams::default().effect_layers,
        )?;
        let stages = [PrimaryRays::IO, IndirectLighting::IO];
        let images = ChannelImages::alone(device, FrameSizes::same(size), &stages)?;
        let uniforms = Uniforms::new(device, "frame_uniforms")?;
        Ok(move |frame: &mut Frame<'_>| {
            lights.update(frame, &scene, &mut gpu)?;
            uniforms.upload(frame, &FrameRecord::new(camera, camera, size, frame.index(), 0))?;
            let inputs = StageInputs { scene: Some(&gpu), uniforms: Some(&uniforms), images: &images };
            primary.record(frame, &inputs, &GbufferParams::default())?;
            stage.record(frame, &inputs, &IndirectParams::default(), 0.0)
        })
    })
}
