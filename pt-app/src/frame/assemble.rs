//! Which stages a frame has, and the images between them.

use super::planes::MorePlanes;
use super::stages::TracedStages;
use super::{FullFrame, Stage};
use crate::params::FrameParams;
use crate::session::Session;
use pt_checkerboard::{AddPlane, Interleave};
use pt_core::frame::Uniforms;
use pt_core::{Device, FramePlan, Kept, Result, StageIo};
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
        Self::keeping(Kept::All, session, output_size, accumulate, params)
    }

    /// As [`FullFrame::new`]. With [`Kept::Outputs`] only the images of the stages from anti-aliasing on can be read after a frame, and the frame
    /// takes less memory.
    ///
    /// # Errors
    /// As [`FullFrame::new`].
    pub fn keeping(
        kept: Kept,
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
        let framed = device.with_formats(params.formats());
        let traced = Some(TracedStages::new(&framed, variant, scene, planes > 1, params)?);
        Self::assemble(device, kept, traced, planes, Stage::Denoise, output_size, accumulate, params)
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
        Self::assemble(device, Kept::All, None, 1, first, output_size, accumulate, params)
    }

    #[expect(clippy::too_many_arguments, reason = "what its two callers differ in")]
    fn assemble(
        device: &Device,
        kept: Kept,
        traced: Option<TracedStages>,
        planes: u32,
        first: Stage,
        output_size: [u32; 2],
        accumulate: bool,
        params: &FrameParams,
    ) -> Result<Self> {
        let device = &device.with_formats(params.formats());
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
            stages.push(denoise.handed_on());
        }
        stages.extend(Stage::Checkerboard.is_in(first).then_some(Interleave::IO));
        let has_effects = traced.as_ref().is_some_and(|traced| traced.effects.is_some());
        stages.extend(has_effects.then_some(Effects::MOTION));
        let sizes = params.post.sizes(output_size);
        let more_planes = planes as usize - 1;
        let mut plane = FramePlan::new(sizes);
        if more_planes > 0 {
            stages.iter().try_for_each(|io| plane.stage(io))?;
            stages.push(AddPlane::IO);
        }
        let mut plan = FramePlan::new(sizes);
        for io in post.io() {
            plan.keep([io.reads, io.writes, io.updates].into_iter().flatten().copied());
            stages.push(io);
        }
        // A replay loads the images that no stage writes. In a whole frame each image must have a writer.
        let given: Vec<_> =
            if traced.is_none() { plan.missing(&stages).into_iter().collect() } else { Vec::new() };
        plan.given(given.iter().copied());
        stages.iter().try_for_each(|io| plan.stage(io))?;
        if let Some(traced) = &traced {
            let tables = traced.tables(sizes.frame, params);
            plan.tables(tables.iter().copied());
            plane.tables(tables);
        }
        let mut images = plan.allocate_planes(device, &plane, more_planes, kept)?;
        let more_images = images.split_off(1);
        Ok(Self {
            uniforms: Uniforms::new(device, "frame_uniforms")?,
            images: images.remove(0),
            given,
            previous_camera: None,
            traced,
            denoise,
            composite: (Stage::Denoise.is_in(first))
                .then(|| Composite::for_light(device, indirect))
                .transpose()?,
            more_planes: (more_planes > 0).then(|| MorePlanes::new(device, more_images)).transpose()?,
            interleave: Stage::Checkerboard.is_in(first).then(|| Interleave::new(device)).transpose()?,
            post,
            made_for: params.clone(),
            moment: None,
            oracles: None,
            pass_stages: Default::default(),
        })
    }
}
