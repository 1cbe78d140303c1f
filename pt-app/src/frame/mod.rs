//! The whole frame: its stages in order, and the images that pass between them.

mod access;
mod assemble;
mod fed;
mod memory;
mod oracle;
mod planes;
mod shown;
mod stages;

pub use fed::FrameTime;
pub use memory::{FrameMemory, StageMemory};
pub use oracle::{Oracle, Oracles};
pub use shown::ShownTruth;
pub use stages::{FrameStage, Stage, bounce_lights};

use crate::params::FrameParams;
use planes::{MorePlanes, Plane, are_told_apart};
use pt_checkerboard::Interleave;
use pt_core::frame::Uniforms;
use pt_core::settings::Knobs;
use pt_core::{ChannelImages, Frame, SceneResources, StageInputs};
use pt_denoise::{Composite, DenoiseChain};
use pt_gbuffer::{GbufferParams, frame_jitter};
use pt_post::PostChain;
use pt_scene::Camera;
use pt_scene::gpu::{GpuScene, camera_record};
use pt_shaders::channels::ChannelId;
use pt_shaders::records::{CameraRecord, FrameRecord};
use stages::TracedStages;
use std::cell::RefCell;

/// Parameters of one frame besides its images and knobs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Cameras, size, frame index and seed.
    pub record: FrameRecord,
    /// Where in its pixels the frame is sampled, from the centre, pixels.
    pub jitter: [f32; 2],
    /// Seconds since the last frame, for eye adaptation; `None`: no adaptation.
    pub time_step: Option<f32>,
}

/// The stages and the images that pass between them. A replay starts at a later stage, with recorded images.
pub struct FullFrame {
    uniforms: Uniforms<FrameRecord>,
    images: ChannelImages,
    given: Vec<ChannelId>,
    previous_camera: Option<CameraRecord>,
    traced: Option<TracedStages>,
    denoise: Option<DenoiseChain>,
    composite: Option<Composite>,
    interleave: Option<Interleave>,
    /// With `gbuffer.decomposition=planes` in a scene with glass: the planes after the first one.
    more_planes: Option<MorePlanes>,
    post: PostChain,
    made_for: FrameParams,
    moment: Option<Moment>,
    oracles: Option<Oracles>,
    pass_stages: RefCell<Vec<FrameStage>>,
}

impl FullFrame {
    /// What a picture of `size` pixels from `camera` shows: the view of its ground truth.
    pub fn view(camera: &Camera, size: [u32; 2], params: &FrameParams) -> FrameRecord {
        let camera = params.gbuffer.with_lens(camera_record(camera, size));
        FrameRecord::new(camera, camera, size, 0, 0)
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
    ) -> pt_core::Result<()> {
        let moment = self.next_moment(camera, frame.index(), seed, time_step, params);
        self.begin_images(params);
        self.stages(frame, Some(scene), moment, params)
    }

    /// Records a frame of a replay. `load` fills the images that a replay is given, after last frame's have been put aside.
    ///
    /// # Errors
    /// Those of `load`, else as [`FullFrame::record`].
    pub fn replay<E: From<pt_core::Error>>(
        &mut self,
        frame: &mut Frame<'_>,
        moment: Moment,
        params: &FrameParams,
        load: impl FnOnce(&ChannelImages, &[ChannelId]) -> Result<(), E>,
    ) -> Result<(), E> {
        self.begin_images(params);
        load(&self.images, &self.given)?;
        Ok(self.stages(frame, None, moment, params)?)
    }

    /// The images of the last frame become those before.
    fn begin_images(&mut self, params: &FrameParams) {
        self.images.begin_frame();
        if let Some(more) = &mut self.more_planes {
            more.begin_frame();
            // Planes that are not rendered in this frame have no history in the next one.
            if !are_told_apart(params) {
                more.reset_history();
            }
        }
    }

    /// Parameters of frame `index`, from which `camera` looks.
    fn next_moment(
        &mut self,
        camera: &Camera,
        index: u32,
        seed: u32,
        time_step: Option<f32>,
        params: &FrameParams,
    ) -> Moment {
        let size = self.images.size();
        let camera = params.gbuffer.with_lens(camera_record(camera, size));
        let previous = self.previous_camera.replace(camera).unwrap_or(camera);
        let record = FrameRecord::new(camera, previous, size, index, seed);
        Moment { record, jitter: frame_jitter(params.gbuffer.jitter, index), time_step }
    }

    fn stages(
        &mut self,
        frame: &mut Frame<'_>,
        scene: Option<&dyn SceneResources>,
        moment: Moment,
        params: &FrameParams,
    ) -> pt_core::Result<()> {
        self.begin_stages(frame, moment, params)?;
        let plane = self.first_plane(scene);
        self.plane(frame, &plane, params)?;
        self.add_planes(frame, &plane, params)?;
        self.show(frame, &plane.inputs, moment, params)
    }

    /// The stages up to the interleave.
    fn plane(&self, frame: &mut Frame<'_>, plane: &Plane<'_>, params: &FrameParams) -> pt_core::Result<()> {
        self.surfaces(frame, plane, params)?;
        if let Some(traced) = &self.traced {
            let lod_bias = params.gbuffer.texture_lod_bias + params.post.mip_bias();
            traced.direct.record(frame, &plane.inputs, &params.lights, lod_bias)?;
            self.passes_are_of(frame, FrameStage::Lights);
            if let Some(indirect) = &traced.indirect {
                indirect.record(frame, &plane.inputs, &params.indirect, lod_bias)?;
            }
            self.passes_are_of(frame, FrameStage::Indirect);
        }
        self.flat_frame(frame, &plane.inputs, params)
    }

    fn begin_stages(
        &mut self,
        frame: &mut Frame<'_>,
        moment: Moment,
        params: &FrameParams,
    ) -> pt_core::Result<()> {
        if let Some(key) = self.made_for.structural_difference(params) {
            return Err(pt_core::Error::StructuralKnob { key });
        }
        self.moment = Some(moment);
        self.uniforms.upload(frame, &moment.record)?;
        if let Some(more) = &self.more_planes {
            more.upload(frame, &moment.record)?;
        }
        self.pass_stages.borrow_mut().clear();
        self.passes_are_of(frame, FrameStage::Scene);
        Ok(())
    }

    /// The passes since the last call belong to `stage`.
    fn passes_are_of(&self, frame: &Frame<'_>, stage: FrameStage) {
        self.pass_stages.borrow_mut().resize(frame.pass_count(), stage);
    }

    /// The stages before the light.
    fn surfaces(
        &self,
        frame: &mut Frame<'_>,
        plane: &Plane<'_>,
        params: &FrameParams,
    ) -> pt_core::Result<()> {
        let Plane { number, inputs, camera_rays } = plane;
        let Some(traced) = &self.traced else { return Ok(()) };
        let lod_bias = params.gbuffer.texture_lod_bias + params.post.mip_bias();
        let gbuffer = GbufferParams { texture_lod_bias: lod_bias, ..params.gbuffer.clone() };
        let light_kinds = params.lights.push(0.0).kinds;
        traced.primary.record(frame, camera_rays, &gbuffer)?;
        if let Some(effects) = &traced.effects {
            effects.record(frame, camera_rays, &gbuffer)?;
        }
        if let Some(godrays) = &traced.godrays {
            godrays.record(frame, camera_rays, &gbuffer.godrays, params.lights.glass_shadows)?;
        }
        for bounce in 0..gbuffer.reflect_refract {
            traced.reflect_refract.record(frame, inputs, &gbuffer, light_kinds, bounce, *number)?;
        }
        if let Some(replaced_motion) = &traced.replaced_motion {
            replaced_motion.record(frame, camera_rays, &gbuffer)?;
        }
        self.passes_are_of(frame, FrameStage::Gbuffer);
        if let Some(gradient_pixels) = &traced.gradient_pixels {
            gradient_pixels.record(frame, inputs, &params.denoise, params.direct().replays())?;
        }
        self.passes_are_of(frame, FrameStage::Denoise);
        Ok(())
    }

    /// The stages from the light to the interleave.
    fn flat_frame(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        params: &FrameParams,
    ) -> pt_core::Result<()> {
        if let (Some(denoise), Some(composite)) = (&self.denoise, &self.composite) {
            let light = denoise.record(frame, inputs, &params.denoise)?;
            composite.record(frame, inputs, light, &params.denoise)?;
            self.oracles.as_ref().map_or(Ok(()), |oracles| oracles.after_composite(frame, self))?;
        }
        self.passes_are_of(frame, FrameStage::Denoise);
        if let Some(interleave) = &self.interleave {
            interleave.record(frame, inputs, &params.checkerboard)?;
            if let Some(effects) = self.traced.as_ref().and_then(|traced| traced.effects.as_ref()) {
                effects.record_motion(frame, inputs)?;
            }
            self.oracles.as_ref().map_or(Ok(()), |oracles| oracles.after_interleave(frame, self))?;
        }
        self.passes_are_of(frame, FrameStage::Checkerboard);
        Ok(())
    }

    /// The stages after the interleave.
    fn show(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        moment: Moment,
        params: &FrameParams,
    ) -> pt_core::Result<()> {
        let fed = self.oracles.as_ref().is_some_and(Oracles::feeds_taa);
        let jitter = if fed { [0.0; 2] } else { moment.jitter };
        self.post.record_with(frame, inputs, moment.time_step, jitter, &params.post, |frame, written| {
            self.oracles.as_ref().map_or(Ok(()), |oracles| oracles.after_post(frame, written))
        })?;
        self.passes_are_of(frame, FrameStage::Post);
        Ok(())
    }

    /// Replaces the output of stages by ground truth, which [`Oracles::set_truth`] sets for each frame; `None`: no more.
    pub fn feed(&mut self, oracles: Option<Oracles>) {
        self.oracles = oracles;
    }

    /// The replaced stages, to set their ground truth.
    pub fn oracles(&mut self) -> Option<&mut Oracles> {
        self.oracles.as_mut()
    }

    /// Forgets the frames so far, after a cut or a teleport of the camera: the next one starts over.
    pub fn reset_history(&mut self) {
        self.images.reset_history();
        self.more_planes.iter_mut().for_each(MorePlanes::reset_history);
        self.previous_camera = None;
    }
}
