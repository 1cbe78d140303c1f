//! GPU time of the primary rays of the built-in gallery, on the backend that auto takes. `cargo bench -p pt-gbuffer [-- WIDTHxHEIGHT]`.
//!
//! One thread is one ray: Mthreads/s are Mrays/s. Bytes are those of the images; what the traversal reads is not counted.

use pt_core::frame::Uniforms;
use pt_core::harness::bench;
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, Frame};
use pt_core::{FrameSizes, StageInputs};
use pt_gbuffer::{GbufferParams, PrimaryRays};
use pt_scene::gpu::{GpuScene, camera_record};
use pt_shaders::records::FrameRecord;
use std::process::ExitCode;

fn main() -> ExitCode {
    bench([1280, 720], |device, size| {
        let scene = pt_import::open("gallery", &Default::default())?;
        let camera = camera_record(&scene.default_camera(), size);
        let mut gpu = GpuScene::new(device, &scene, TraceBackend::Auto)?;
        let stage = PrimaryRays::new(device, gpu.variant())?;
        let images = ChannelImages::alone(device, FrameSizes::same(size), &[PrimaryRays::IO])?;
        let uniforms = Uniforms::new(device, "frame_uniforms")?;
        Ok(move |frame: &mut Frame<'_>| {
            gpu.update(frame, &scene)?;
            let record = FrameRecord::new(camera, camera, size, frame.index(), 0);
            uniforms.upload(frame, &record)?;
            stage.record(
                frame,
                &StageInputs { scene: Some(&gpu), uniforms: Some(&uniforms), images: &images },
                &GbufferParams::default(),
            )
        })
    })
}
