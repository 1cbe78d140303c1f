//! `gbuffer.decomposition=planes`: the frames of the lobes of glass, which are added to one. In each of them no pixel is split over the fields.

use super::{FrameStage, FullFrame};
use crate::params::FrameParams;
use pt_checkerboard::AddPlane;
use pt_core::frame::Uniforms;
use pt_core::rng::pcg4d;
use pt_core::{ChannelImages, Device, Frame, Result, SceneResources, StageInputs};
use pt_shaders::records::FrameRecord;

/// The planes after the first one. Kernels, and buffers that stages fill and read within a frame, are those of the first plane.
pub(super) struct MorePlanes {
    uniforms: Vec<Uniforms<FrameRecord>>,
    images: Vec<ChannelImages>,
    add: AddPlane,
}

/// What the stages of a plane get.
pub(super) struct Plane<'a> {
    pub(super) number: u32,
    pub(super) inputs: StageInputs<'a>,
    /// As `inputs`, for what is decided before the planes part: pixels have one camera ray, whichever plane asks.
    pub(super) camera_rays: StageInputs<'a>,
}

impl MorePlanes {
    /// Planes with these images.
    ///
    /// # Errors
    /// When the device refuses.
    pub(super) fn new(device: &Device, images: Vec<ChannelImages>) -> Result<Self> {
        Ok(Self {
            uniforms: (1..=images.len())
                .map(|number| Uniforms::new(device, &format!("frame_uniforms of plane {number}")))
                .collect::<Result<_>>()?,
            images,
            add: AddPlane::new(device)?,
        })
    }

    /// Sets the frame's parameters. The planes draw their random numbers with seeds of their own, or what they add up would be correlated.
    pub(super) fn upload(&self, frame: &mut Frame<'_>, record: &FrameRecord) -> Result<()> {
        (1..).zip(&self.uniforms).try_for_each(|(number, uniforms)| {
            let seed = pcg4d([record.seed, number, 0, 0])[0];
            uniforms.upload(frame, &FrameRecord { seed, ..*record })
        })
    }

    pub(super) fn begin_frame(&mut self) {
        self.images.iter_mut().for_each(ChannelImages::begin_frame);
    }

    pub(super) fn reset_history(&mut self) {
        self.images.iter_mut().for_each(ChannelImages::reset_history);
    }

    pub(super) fn images(&self) -> &[ChannelImages] {
        &self.images
    }
}

/// Whether planes differ: without reflection and refraction the first one has all the light.
pub(super) fn are_told_apart(params: &FrameParams) -> bool {
    params.gbuffer.reflect_refract > 0
}

impl FullFrame {
    pub(super) fn first_plane<'a>(&'a self, scene: Option<&'a dyn SceneResources>) -> Plane<'a> {
        let inputs = self.inputs(scene);
        Plane { number: 0, inputs, camera_rays: inputs }
    }

    /// Records the other planes and adds their flat frames to that of the first one.
    pub(super) fn add_planes(
        &self,
        frame: &mut Frame<'_>,
        first: &Plane<'_>,
        params: &FrameParams,
    ) -> Result<()> {
        let Some(more) = self.more_planes.as_ref().filter(|_| are_told_apart(params)) else {
            return Ok(());
        };
        for ((number, images), uniforms) in (1..).zip(&more.images).zip(&more.uniforms) {
            frame.end_names_with(&format!(", plane {number}"));
            let camera_rays = StageInputs { images, ..first.inputs };
            let inputs = StageInputs { uniforms: Some(uniforms), ..camera_rays };
            self.plane(frame, &Plane { number, inputs, camera_rays }, params)?;
            more.add.record(frame, &first.inputs, images)?;
            self.passes_are_of(frame, FrameStage::Checkerboard);
        }
        frame.end_names_with("");
        Ok(())
    }
}
