//! The whole frame, in the order in which light reaches the screen.

use crate::params::FrameParams;
use crate::session::join;
use pt_checkerboard::Interleave;
use pt_core::frame::Uniforms;
use pt_core::trace::TraceBackend;
use pt_core::{ChannelImages, Device, Frame, Image, Result};
use pt_denoise::Composite;
use pt_gbuffer::{GbufferParams, PrimaryRays, ReflectRefract, frame_jitter};
use pt_lights::{DirectLighting, LightTables};
use pt_post::{Accumulate, Bloom, BloomMode, Exposure, ExposureRecord, Fsr, Taa, ToneMap, Upscale, radiance};
use pt_scene::Camera;
use pt_scene::gpu::{GpuScene, camera_record};
use pt_shaders::channels::{ChannelId, FLAT_COLOR, FLAT_MOTION};
use pt_shaders::records::{CameraRecord, FrameRecord};
use std::thread;

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
    taa: Option<Taa>,
    bloom: Option<Bloom>,
    exposure: Exposure,
    tone_map: ToneMap,
    fsr: Option<Fsr>,
    time_step: Option<f32>,
    jitter: [f32; 2],
}

impl FullFrame {
    /// Compiles the kernels and allocates the images for a picture of `output_size` pixels. What `params` say about the post
    /// stages decides which of them there are, and the size of the frame. With `accumulate` the frames are averaged (the
    /// photo mode), instead of temporal anti-aliasing.
    ///
    /// # Errors
    /// When the device refuses.
    pub fn new(
        device: &Device,
        backend: TraceBackend,
        output_size: [u32; 2],
        accumulate: bool,
        params: &FrameParams,
    ) -> Result<Self> {
        let post = &params.post;
        let size = post.render_size(output_size);
        // What comes before FSR 1 has the size of the frame, what comes after temporal upscaling that of the picture.
        let resolved_size = if post.upscale == Upscale::Taau { output_size } else { size };
        let needed = [
            PrimaryRays::WRITES,
            DirectLighting::WRITES,
            Composite::WRITES,
            Interleave::WRITES,
            if accumulate { Accumulate::WRITES } else { &[] },
            &[post.encoding.channel()],
        ];
        let channels: Vec<ChannelId> = needed.into_iter().flatten().copied().collect();
        let codes = if post.uses_fsr() { Fsr::input_encoding(post.encoding) } else { post.encoding };
        let uses_taa = post.uses_taa() && !accumulate;
        thread::scope(|threads| {
            // Kernels that trace rays take the most time to compile.
            let reflect_refract = threads.spawn(|| ReflectRefract::new(device, backend));
            let direct = threads.spawn(|| DirectLighting::new(device, backend));
            Ok(Self {
                uniforms: Uniforms::new(device, "frame_uniforms")?,
                images: ChannelImages::with_output(device, size, output_size, channels)?,
                previous_camera: None,
                primary: PrimaryRays::new(device, backend)?,
                composite: Composite::new(device)?,
                interleave: Interleave::new(device)?,
                accumulate: accumulate.then(|| Accumulate::new(device, size)).transpose()?,
                taa: uses_taa.then(|| Taa::new(device, resolved_size)).transpose()?,
                bloom: (post.bloom.mode != BloomMode::Off)
                    .then(|| Bloom::new(device, resolved_size))
                    .transpose()?,
                exposure: Exposure::new(device)?,
                tone_map: ToneMap::new(device, post.tonemap, codes)?,
                fsr: post.uses_fsr().then(|| Fsr::new(device, resolved_size, output_size)).transpose()?,
                reflect_refract: join(reflect_refract)?,
                direct: join(direct)?,
                time_step: None,
                jitter: [0.0; 2],
            })
        })
    }

    /// Seconds between frames, for the eye's adaptation. Without, each frame is exposed by itself.
    pub fn set_time_step(&mut self, seconds: f32) {
        self.time_step = Some(seconds);
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
        let gbuffer = GbufferParams {
            texture_lod_bias: params.gbuffer.texture_lod_bias + params.post.mip_bias(),
            ..params.gbuffer.clone()
        };
        self.jitter = frame_jitter(gbuffer.jitter, frame.index());
        let camera = gbuffer.with_lens(camera_record(camera, images.size()));
        let previous = self.previous_camera.replace(camera).unwrap_or(camera);
        let uniforms = FrameRecord {
            random: gbuffer.random.code(),
            ..FrameRecord::new(camera, previous, images.size(), frame.index(), seed)
        };
        self.uniforms.upload(frame, &uniforms)?;

        self.primary.record(frame, scene, &self.uniforms, images, &gbuffer)?;
        for bounce in 0..gbuffer.reflect_refract {
            self.reflect_refract.record(frame, scene, &self.uniforms, images, &gbuffer, bounce)?;
        }
        self.direct.record(frame, scene, lights, &self.uniforms, images, &params.lights)?;
        self.composite.record(frame, images, &params.denoise)?;
        self.interleave.record(frame, images, &params.checkerboard)?;
        if let Some(accumulate) = &self.accumulate {
            accumulate.record(frame, images, frame.index() == 0)?;
        }
        if let Some(taa) = &mut self.taa {
            let (color, motion) = (images.current(FLAT_COLOR), images.current(FLAT_MOTION));
            taa.record(frame, color, motion, self.jitter, &params.post.taa)?;
        }
        let source = radiance(images, self.accumulate.as_ref(), self.taa.as_ref());
        let bloomed = match &self.bloom {
            Some(bloom) => bloom.record(frame, source, &params.post.bloom)?,
            None => source.into(),
        };
        self.exposure.record(frame, source, self.time_step, &params.post)?;
        let picture = images.current(params.post.encoding.channel());
        let Some(fsr) = &self.fsr else {
            return self.tone_map.record(frame, bloomed, &self.exposure, picture, &params.post);
        };
        self.tone_map.record(frame, bloomed, &self.exposure, fsr.codes(), &params.post)?;
        fsr.record(frame, picture, &params.post)
    }

    /// All channels, as the last frame left them.
    pub fn images(&self) -> &ChannelImages {
        &self.images
    }

    /// The picture as linear scene radiance, before bloom and exposure. With FSR 1 it has the size of the frame.
    pub fn radiance(&self) -> &Image {
        radiance(&self.images, self.accumulate.as_ref(), self.taa.as_ref())
    }

    /// Where in its pixels the last frame was sampled, from the centre, pixels.
    pub fn jitter(&self) -> [f32; 2] {
        self.jitter
    }

    /// The exposure that the last frame was shown with; waits for it.
    ///
    /// # Errors
    /// When the device fails.
    pub fn exposure(&self) -> Result<ExposureRecord> {
        self.exposure.read()
    }
}
