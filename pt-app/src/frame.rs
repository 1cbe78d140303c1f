//! The whole frame, in the order in which light reaches the screen.

use crate::params::FrameParams;
use pt_checkerboard::Interleave;
use pt_core::channels::field_width;
use pt_core::frame::Uniforms;
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, Device, Frame, Result};
use pt_denoise::Composite;
use pt_gbuffer::{PrimaryRays, ReflectRefract};
use pt_lights::{DirectLighting, LightTables};
use pt_post::{Accumulate, Radiance, ToneMap};
use pt_scene::Camera;
use pt_scene::gpu::{GpuScene, camera_record};
use pt_shaders::glam::UVec2;
use pt_shaders::records::{CameraRecord, FrameRecord};

/// The stages with the images that pass between them.
pub struct FullFrame {
    uniforms: Uniforms<FrameRecord>,
    images: ChannelImages,
    previous_camera: Option<CameraRecord>,
    primary: PrimaryRays,
    reflect_refract: ReflectRefract,
    direct: DirectLighting,
    composite: Composite,
    interleave: Interleave,
    accumulate: Option<Accumulate>,
    tone_map: ToneMap,
}

impl FullFrame {
    /// Compiles the kernels and allocates the images for a frame of `size` pixels.
    pub fn new(device: &Device, backend: TraceBackend, size: [u32; 2], accumulate: bool) -> Result<Self> {
        let accumulate = if accumulate { Some(Accumulate::new(device, size)?) } else { None };
        let needed = [
            PrimaryRays::WRITES,
            DirectLighting::WRITES,
            Composite::WRITES,
            Interleave::WRITES,
            ToneMap::WRITES,
            if accumulate.is_some() { Accumulate::WRITES } else { &[] },
        ];
        Ok(Self {
            uniforms: Uniforms::new(device, "frame_uniforms")?,
            images: ChannelImages::new(device, size, needed.into_iter().flatten().copied())?,
            previous_camera: None,
            primary: PrimaryRays::new(device, backend)?,
            reflect_refract: ReflectRefract::new(device, backend)?,
            direct: DirectLighting::new(device, backend)?,
            composite: Composite::new(device)?,
            interleave: Interleave::new(device)?,
            accumulate,
            tone_map: ToneMap::new(device)?,
        })
    }

    /// Records one frame.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        scene: &GpuScene,
        lights: &LightTables,
        camera: &Camera,
        seed: u32,
        params: &FrameParams,
    ) -> Result<()> {
        if self.previous_camera.is_some() {
            self.images.swap();
        }
        let images = &self.images;
        let camera = params.gbuffer.with_lens(camera_record(camera, images.size()));
        let uniforms = FrameRecord {
            camera,
            camera_prev: self.previous_camera.replace(camera).unwrap_or(camera),
            size: UVec2::from_array(images.size()),
            field_width: field_width(images.size()[0]),
            frame_index: frame.index(),
            seed,
            pad: [0; 3],
        };
        self.uniforms.upload(frame, &uniforms)?;

        self.primary.record(frame, scene, &self.uniforms, images, &params.gbuffer)?;
        for bounce in 0..params.gbuffer.reflect_refract {
            self.reflect_refract.record(frame, scene, &self.uniforms, images, &params.gbuffer, bounce)?;
        }
        self.direct.record(frame, scene, lights, &self.uniforms, images, &params.lights)?;
        self.composite.record(frame, images, &params.denoise)?;
        self.interleave.record(frame, images, &params.checkerboard)?;
        if let Some(accumulate) = &self.accumulate {
            accumulate.record(frame, images, frame.index() == 0)?;
        }
        self.tone_map.record(frame, images, self.radiance(), &params.post)
    }

    /// All channels, as the last frame left them.
    pub fn images(&self) -> &ChannelImages {
        &self.images
    }

    /// Where the picture is as linear scene radiance.
    pub fn radiance(&self) -> Radiance {
        if self.accumulate.is_some() { Radiance::Accumulated } else { Radiance::Frame }
    }

    /// Exposure value that the last frame was shown with; waits for it.
    ///
    /// # Errors
    /// When the device fails.
    pub fn ev100(&self) -> Result<f32> {
        Ok(self.tone_map.exposure()?.ev100)
    }
}
