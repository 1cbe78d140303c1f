//! Which stages a frame has, and the images between them.

use super::planes::MorePlanes;
use super::stages::TracedStages;
use super::{FullFrame, Stage};
use crate::params::FrameParams;
use crate::session::Session;
use pt_checkerboard::{AddPlane, Interleave};
use pt_core::frame::Uniforms;
use pt_core::{Device, FramePlan, Result, StageIo};
use pt_denoise::{Composite, DenoiseChain, GradientPixels};
use pt_gbuffer::{Effects, Godrays, PrimaryRays, ReplacedMotion, plane_count};
use pt_indirect::IndirectLighting;
use pt_lights::DirectLighting;
use pt_post::{ChainParts, PostChain};
use pt_shaders::records::Background;

impl FullFrame {
    /// Prepares the session's lights for the light sampler, compiles the kernels and allocates the images for a picture of `output_size`
    /// pixels. Structural knobs of `params` decide which stages and kernels there are, and the size of the frame. With `accumulate` the frames are averaged (the photo mode).
    ///
    /// # Errors
    /// When the device refuses.
    pub fn new(
        session: &mut Session,
        output_size: [u32; 2],
        accumulate: bool,
        params: &FrameParams,
    ) -> Result<Self> {
        let Session { device, scene, gpu, lights, .. } = session;
        lights.keep_last_frame(params.direct().replays());
        lights.prepare(device, scene, gpu, params.lights.sampler_choice())?;
        let planes = plane_count(scene, &params.gbuffer);
        let variant = params.gbuffer.variant(gpu.variant());
        let framed = device.with_gbuffer_format(params.gbuffer.format);
        let traced = Some(TracedStages::new(&framed, variant, scene, planes > 1, params)?);
        Self::assemble(device, traced, planes, Stage::Denoise, output_size, accumulate, params)
    }

    /// The frame from stage `first` on, which reads recorded images; see [`FullFrame::replay`].
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
        Self::assemble(device, None, 1, first, output_size, accumulate, params)
    }

    fn assemble(
        device: &Device,
        traced: Option<TracedStages>,
        planes: u32,
        first: Stage,
        output_size: [u32; 2],
        accumulate: bool,
        params: &FrameParams,
    ) -> Result<Self> {
        let device = &device.with_gbuffer_format(params.gbuffer.format);
        let alpha = params.denoise.background == Background::Transparent;
        let parts = ChainParts { accumulate, picture: true, alpha };
        let post = PostChain::new(device, parts, &params.post)?;
        let indirect = params.indirect.is_on();
        let denoise = Stage::Denoise
            .is_in(first)
            .then(|| DenoiseChain::new(device, &params.denoise, indirect))
            .transpose()?;
        let mut stages: Vec<StageIo> = Vec::new();
        if let Some(traced) = &traced {
            stages.push(PrimaryRays::IO);
            stages.extend(traced.effects.is_some().then_some(Effects::BLEND));
            stages.extend(
                params
                    .gbuffer
                    .godrays
                    .is_on()
                    .then_some([Godrays::MARCH, Godrays::FILTER])
                    .into_iter()
                    .flatten(),
            );
            stages.extend((params.gbuffer.reflect_refract > 0).then_some(traced.reflect_refract.io()));
            stages.extend(params.gbuffer.searches_motion().then_some(ReplacedMotion::IO));
            stages.extend(params.has_gradient_pixels().then_some(GradientPixels::IO));
            stages.extend(DirectLighting::io(&params.lights));
            stages.extend(traced.direct.caustics_io());
            if indirect {
                stages.extend(IndirectLighting::io(&params.indirect));
            }
        }
        if let Some(denoise) = &denoise {
            stages.extend(denoise.io());
            stages.push(Composite::io_for(indirect));
        }
        stages.extend(Stage::Checkerboard.is_in(first).then_some(Interleave::IO));
        let has_effects = traced.as_ref().is_some_and(|traced| traced.effects.is_some());
        stages.extend(has_effects.then_some(Effects::MOTION));
        let sizes = params.post.sizes(output_size);
        let mut more_planes = None;
        let mut more_bytes = 0;
        if planes > 1 {
            let mut plan = FramePlan::new(sizes);
            stages.iter().try_for_each(|io| plan.stage(io))?;
            more_bytes = plan.bytes(params.gbuffer.format) * u64::from(planes - 1);
            more_planes = Some(plan);
            stages.push(AddPlane::IO);
        }
        stages.extend(post.io());
        let mut plan = FramePlan::new(sizes);
        // A replay loads the images that no stage writes. In a whole frame each image must have a writer.
        let given: Vec<_> =
            if traced.is_none() { plan.missing(&stages).into_iter().collect() } else { Vec::new() };
        plan.given(given.iter().copied());
        stages.iter().try_for_each(|io| plan.stage(io))?;
        Ok(Self {
            uniforms: Uniforms::new(device, "frame_uniforms")?,
            images: plan.allocate_beside(device, more_bytes)?,
            given,
            previous_camera: None,
            traced,
            denoise,
            composite: (Stage::Denoise.is_in(first))
                .then(|| Composite::for_light(device, indirect))
                .transpose()?,
            more_planes: more_planes.map(|plan| MorePlanes::new(device, &plan, planes - 1)).transpose()?,
            interleave: Stage::Checkerboard.is_in(first).then(|| Interleave::new(device)).transpose()?,
            post,
            made_for: params.clone(),
            moment: None,
            oracles: None,
            pass_stages: Default::default(),
        })
    }
}
