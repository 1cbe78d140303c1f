//! The whole frame, in the order in which light reaches the screen.

use crate::params::FrameParams;
use crate::session::join;
use pt_checkerboard::Interleave;
use pt_core::frame::Uniforms;
use pt_core::settings::Knobs;
use pt_core::trace::TraceBackend;
use pt_core::{
    Buffer, ChannelImages, Device, Frame, FramePlan, Image, Result, SceneResources, SplitLight, StageInputs,
    StageIo,
};
use pt_denoise::Composite;
use pt_gbuffer::{GbufferParams, PrimaryRays, ReflectRefract, frame_jitter};
use pt_lights::DirectLighting;
use pt_post::{ChainParts, ExposureRecord, PostChain};
use pt_scene::Camera;
use pt_scene::gpu::{GpuScene, camera_record};
use pt_shaders::channels::ChannelId;
use pt_shaders::records::{CameraRecord, FrameRecord};
use std::thread;

/// The stages of the frame that have a crate of their own, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, clap::ValueEnum)]
pub enum Stage {
    /// Composite of the light channels.
    Denoise,
    /// Interleave of the checkerboard fields.
    Checkerboard,
    /// Temporal anti-aliasing, bloom, exposure, tone map, FSR 1.
    Post,
}

/// What a frame is recorded with besides its images and knobs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Cameras, size, frame index and seed.
    pub record: FrameRecord,
    /// Where in its pixels the frame is sampled, from the centre, pixels.
    pub jitter: [f32; 2],
    /// Seconds since the last frame, for the eye's adaptation; `None`: the frame is exposed by itself.
    pub time_step: Option<f32>,
}

/// The stages that trace rays: they need a scene.
struct TracedStages {
    primary: PrimaryRays,
    reflect_refract: ReflectRefract,
    direct: DirectLighting,
}

/// The stages with the images that pass between them. A replay begins at a later stage, with recorded images.
pub struct FullFrame {
    uniforms: Uniforms<FrameRecord>,
    images: ChannelImages,
    given: Vec<ChannelId>,
    previous_camera: Option<CameraRecord>,
    traced: Option<TracedStages>,
    composite: Option<Composite>,
    interleave: Option<Interleave>,
    post: PostChain,
    made_for: FrameParams,
    moment: Option<Moment>,
}

impl FullFrame {
    /// Compiles the kernels and allocates the images for a picture of `output_size` pixels. Structural knobs of `params` decide
    /// which stages there are, and the size of the frame. With `accumulate` the frames are averaged (the photo mode).
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
        let traced = Some(TracedStages::new(device, backend)?);
        Self::assemble(device, traced, Stage::Denoise, output_size, accumulate, params)
    }

    /// The frame from stage `first` on, which reads recorded images: see [`FullFrame::given`].
    ///
    /// # Errors
    /// When the device refuses.
    pub fn starting_at(
        device: &Device,
        first: Stage,
        output_size: [u32; 2],
        accumulate: bool,
        params: &FrameParams,
    ) -> Result<Self> {
        Self::assemble(device, None, first, output_size, accumulate, params)
    }

    fn assemble(
        device: &Device,
        traced: Option<TracedStages>,
        first: Stage,
        output_size: [u32; 2],
        accumulate: bool,
        params: &FrameParams,
    ) -> Result<Self> {
        let parts = ChainParts { accumulate, picture: true };
        let post = PostChain::new(device, parts, &params.post)?;
        let mut stages: Vec<StageIo> = Vec::new();
        if traced.is_some() {
            stages.push(PrimaryRays::IO);
            stages.extend((params.gbuffer.reflect_refract > 0).then_some(ReflectRefract::IO));
            stages.push(DirectLighting::IO);
        }
        if first <= Stage::Denoise {
            stages.extend([SplitLight::UNFILTERED, Composite::IO]);
        }
        stages.extend((first <= Stage::Checkerboard).then_some(Interleave::IO));
        stages.extend(post.io());
        let mut plan = FramePlan::new(params.post.sizes(output_size));
        // Whatever the stages of a replay read is loaded; a frame from its beginning must write everything by itself.
        let given: Vec<_> =
            if traced.is_none() { plan.missing(&stages).into_iter().collect() } else { Vec::new() };
        plan.given(given.iter().copied());
        stages.iter().try_for_each(|io| plan.stage(io))?;
        Ok(Self {
            uniforms: Uniforms::new(device, "frame_uniforms")?,
            images: plan.allocate(device)?,
            given,
            previous_camera: None,
            traced,
            composite: (first <= Stage::Denoise).then(|| Composite::new(device)).transpose()?,
            interleave: (first <= Stage::Checkerboard).then(|| Interleave::new(device)).transpose()?,
            post,
            made_for: params.clone(),
            moment: None,
        })
    }

    /// Records one frame of a scene. `time_step`: see [`Moment::time_step`].
    ///
    /// # Errors
    /// When the frame can't take it, or a structural knob is not the one that the frame was made with.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        scene: &GpuScene,
        camera: &Camera,
        seed: u32,
        time_step: Option<f32>,
        params: &FrameParams,
    ) -> Result<()> {
        let (size, index) = (self.images.size(), frame.index());
        let camera = params.gbuffer.with_lens(camera_record(camera, size));
        let previous = self.previous_camera.replace(camera).unwrap_or(camera);
        let record = FrameRecord {
            random: params.gbuffer.random.code(),
            ..FrameRecord::new(camera, previous, size, index, seed)
        };
        let moment = Moment { record, jitter: frame_jitter(params.gbuffer.jitter, index), time_step };
        self.stages(frame, Some(scene), moment, params)
    }

    /// Records the stages of a replay, whose images were loaded.
    ///
    /// # Errors
    /// As [`FullFrame::record`].
    pub fn replay(&mut self, frame: &mut Frame<'_>, moment: Moment, params: &FrameParams) -> Result<()> {
        self.stages(frame, None, moment, params)
    }

    fn stages(
        &mut self,
        frame: &mut Frame<'_>,
        scene: Option<&dyn SceneResources>,
        moment: Moment,
        params: &FrameParams,
    ) -> Result<()> {
        if let Some(key) = self.made_for.structural_difference(params) {
            return Err(pt_core::Error::StructuralKnob { key });
        }
        self.moment = Some(moment);
        self.images.begin_frame();
        self.uniforms.upload(frame, &moment.record)?;
        let inputs = StageInputs { scene, uniforms: Some(&self.uniforms), images: &self.images };
        if let Some(traced) = &self.traced {
            let lod_bias = params.gbuffer.texture_lod_bias + params.post.mip_bias();
            let gbuffer = GbufferParams { texture_lod_bias: lod_bias, ..params.gbuffer.clone() };
            traced.primary.record(frame, &inputs, &gbuffer)?;
            for bounce in 0..gbuffer.reflect_refract {
                traced.reflect_refract.record(frame, &inputs, &gbuffer, bounce)?;
            }
            traced.direct.record(frame, &inputs, &params.lights)?;
        }
        if let Some(composite) = &self.composite {
            composite.record(frame, &inputs, SplitLight::unfiltered(&self.images), &params.denoise)?;
        }
        if let Some(interleave) = &self.interleave {
            interleave.record(frame, &inputs, &params.checkerboard)?;
        }
        self.post.record(frame, &inputs, moment.time_step, moment.jitter, &params.post)
    }

    /// Forgets the frames so far, after a cut or a teleport of the camera: the next one starts over.
    pub fn reset_history(&mut self) {
        self.images.reset_history();
        self.previous_camera = None;
    }

    /// All images, as the last frame left them.
    pub fn images(&self) -> &ChannelImages {
        &self.images
    }

    /// All images, to load histories into.
    pub fn images_mut(&mut self) -> &mut ChannelImages {
        &mut self.images
    }

    /// Channels that a replay has to load for every frame.
    pub fn given(&self) -> &[ChannelId] {
        &self.given
    }

    /// Buffers that the next frame goes on with, besides the images.
    pub fn state(&self) -> Vec<&Buffer> {
        self.post.state()
    }

    /// The picture as linear scene radiance, before bloom and exposure. With FSR 1 it has the size of the frame.
    pub fn radiance(&self) -> &Image {
        self.post.resolved(&self.images)
    }

    /// What the last frame was recorded with; `None` before the first.
    pub fn moment(&self) -> Option<&Moment> {
        self.moment.as_ref()
    }

    /// The exposure that the last frame was shown with; waits for it.
    ///
    /// # Errors
    /// When the device fails.
    pub fn exposure(&self) -> Result<ExposureRecord> {
        self.post.exposure().read()
    }
}

impl TracedStages {
    fn new(device: &Device, backend: TraceBackend) -> Result<Self> {
        thread::scope(|threads| {
            // Kernels that trace rays take the most time to compile.
            let reflect_refract = threads.spawn(|| ReflectRefract::new(device, backend));
            let direct = threads.spawn(|| DirectLighting::new(device, backend));
            Ok(Self {
                primary: PrimaryRays::new(device, backend)?,
                reflect_refract: join(reflect_refract)?,
                direct: join(direct)?,
            })
        })
    }
}
