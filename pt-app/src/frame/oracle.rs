//! Stages whose output is replaced by ground truth, to see what error the stages after them add.

use super::{FullFrame, ShownTruth};
use crate::params::FrameParams;
use pt_core::split::to_split;
use pt_core::{Device, Error, Frame, Image, Result, Substitute};
use pt_image::image_file::LinearImage;
use pt_post::{Metered, Written};
use pt_shaders::channels::{COLOR, FLAT_COLOR, Format};
use pt_shaders::named_enum;

named_enum! {
    /// Stages whose output can be replaced by ground truth, in the order in which a ledger feeds them: that of the frame, but for the tone map. It
    /// meters the whole picture: behind radiance that is fed, nothing would be left of its error.
    pub enum Oracle {
        /// Exposure and tone curve of the tone map: those that the ground truth has.
        Tonemap = "tonemap",
        /// Direct lighting: the mean of many runs on the same surfaces.
        Lights = "lights",
        /// Indirect lighting: the same.
        Indirect = "indirect",
        /// The composite of the denoised light: what is left is the error of interleave and anti-aliasing.
        Denoise = "denoise",
        /// The flat frame: what is left is the error of anti-aliasing.
        Interleave = "interleave",
        /// The anti-aliased frame: what is left is its rounding to half floats.
        Taa = "taa",
    }
}

impl Oracle {
    /// Whether a frame has the stage.
    pub fn is_in(self, params: &FrameParams) -> bool {
        match self {
            Self::Indirect => params.indirect.is_on(),
            Self::Taa => params.post.uses_taa(),
            Self::Tonemap => params.post.meters(),
            Self::Lights | Self::Denoise | Self::Interleave => true,
        }
    }

    /// What switches the stage on.
    fn switched_on_by(self) -> &'static str {
        match self {
            Self::Indirect => "--set indirect.bounces=1 switches it on",
            Self::Taa => "--profile realtime or --set post.taa.enabled=true switches it on",
            Self::Tonemap => "--exposure auto or --tonemap noise-aware gives it something to measure",
            Self::Lights | Self::Denoise | Self::Interleave => "every frame has it",
        }
    }

    /// Why the mean of many runs is not the ground truth of the stage; `None`: it is.
    pub fn cannot_be_fed(self, params: &FrameParams) -> Option<String> {
        use pt_shaders::records::LightSampler;
        let learns = matches!(
            params.lights.sampler,
            LightSampler::RestirDi | LightSampler::NeeAt | LightSampler::ClusterStats
        );
        let merged = params.lights.rays == pt_lights::records::LightRays::Merged;
        (matches!(self, Self::Lights | Self::Indirect) && learns && merged).then(|| {
            format!(
                "the light sampler {} learns from each run, so that the mean of many runs is not that of the frame; take another one, \
                 or do not feed {}",
                params.lights.sampler.name(),
                self.name()
            )
        })
    }
}

/// The replaced stages of a frame. Ground truth is the radiance of whole pixels, so that anti-aliasing is told that a fed frame was sampled in the
/// middle of its pixels.
pub struct Oracles {
    on: Vec<Oracle>,
    runs: u32,
    full: Substitute,
    half: Substitute,
    /// Ground truth in the order of the fields.
    split: Image,
    /// Ground truth in the order of the picture.
    flat: Image,
    /// The picture of the ground truth, where the tone map is fed; what it was shown with.
    shown: Option<(Box<ShownTruth>, Option<Metered>)>,
}

impl Oracles {
    /// The names of all stages.
    pub fn names() -> Vec<&'static str> {
        use pt_shaders::NamedEnum;
        Oracle::NAMED.iter().map(|value| value.name).collect()
    }

    /// Replaces the output of the stages `on` in a frame of `params`; the light is the mean of `runs` runs.
    ///
    /// # Errors
    /// A frame that lacks a stage, or that is smaller than its picture; a device that refuses.
    pub fn new(device: &Device, frame: &FullFrame, on: &[Oracle], runs: u32) -> Result<Self> {
        let params = &frame.made_for;
        if let Some(stage) = on.iter().find(|stage| !stage.is_in(params)) {
            return Err(Error::Unsupported(format!(
                "the frame has no {} to feed with ground truth; {}",
                stage.name(),
                stage.switched_on_by()
            )));
        }
        if let Some(reason) = on.iter().find_map(|stage| stage.cannot_be_fed(params)) {
            return Err(Error::Unsupported(reason));
        }
        if frame.more_planes.is_some() {
            return Err(Error::Unsupported(
                "a frame of several planes cannot be fed with ground truth, which does not tell them apart; gbuffer.decomposition=replacement"
                    .into(),
            ));
        }
        let size = frame.images.size();
        if frame.radiance().extent() != size || frame.images.output_size() != size {
            return Err(Error::Unsupported(
                "a frame that is upscaled cannot be fed with ground truth; post.upscale=none".into(),
            ));
        }
        let image = |name, extent| Image::new(device, name, Format::Rgba32F, extent);
        Ok(Self {
            on: on.to_vec(),
            runs: runs.max(1),
            full: Substitute::new(device, Format::Rgba32F)?,
            half: Substitute::new(device, Format::Rgba16F)?,
            split: image("ground truth, split", pt_core::split::split_size(size))?,
            flat: image("ground truth", size)?,
            shown: on
                .contains(&Oracle::Tonemap)
                .then(|| Ok::<_, Error>((Box::new(ShownTruth::new(device, size, params)?), None)))
                .transpose()?,
        })
    }

    /// Sets the ground truth of the next frame; waits for the device. `time_step`: see [`super::Moment::time_step`].
    ///
    /// # Errors
    /// Another size than the frame's; a device that fails.
    pub fn set_truth(&mut self, truth: &LinearImage, time_step: Option<f32>) -> Result<()> {
        let size = [truth.width, truth.height];
        if size != self.flat.extent() {
            return Err(Error::Unsupported("the ground truth has not the size of the frame".into()));
        }
        let texels: Vec<[f32; 4]> = truth.pixels.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect();
        self.flat.write_f32(texels.as_flattened())?;
        self.split.write_f32(to_split(&texels, size, [0.0; 4]).as_flattened())?;
        if let Some((shown, metered)) = &mut self.shown {
            shown.show(truth, time_step)?;
            *metered = Some(shown.metered()?);
        }
        Ok(())
    }

    /// Whether the colour that anti-aliasing reads is ground truth.
    pub(super) fn feeds_taa(&self) -> bool {
        self.is_fed(Oracle::Denoise) || self.is_fed(Oracle::Interleave)
    }

    /// Whether light is fed.
    pub(super) fn feeds_light(&self) -> bool {
        self.is_fed(Oracle::Lights) || self.is_fed(Oracle::Indirect)
    }

    /// Whether path traced ground truth is needed for each frame.
    pub fn needs_truth(&self) -> bool {
        self.feeds_taa() || self.is_fed(Oracle::Taa) || self.is_fed(Oracle::Tonemap)
    }

    pub(super) fn is_fed(&self, stage: Oracle) -> bool {
        self.on.contains(&stage)
    }

    pub(super) fn runs(&self) -> u32 {
        self.runs
    }

    pub(super) fn after_composite(&self, frame: &mut Frame<'_>, full: &FullFrame) -> Result<()> {
        self.feed(frame, Oracle::Denoise, &self.full, &self.split, full.images.current(COLOR))
    }

    pub(super) fn after_interleave(&self, frame: &mut Frame<'_>, full: &FullFrame) -> Result<()> {
        self.feed(frame, Oracle::Interleave, &self.full, &self.flat, full.images.current(FLAT_COLOR))
    }

    pub(super) fn after_post(&self, frame: &mut Frame<'_>, written: Written<'_>) -> Result<()> {
        match (written, &self.shown) {
            (Written::Resolved(resolved), _) => {
                self.feed(frame, Oracle::Taa, &self.half, &self.flat, resolved)
            }
            (Written::Exposure(exposure), Some((_, Some(metered)))) => exposure.replace(frame, metered),
            (Written::Exposure(_), _) => Ok(()),
        }
    }

    fn feed(
        &self,
        frame: &mut Frame<'_>,
        stage: Oracle,
        pass: &Substitute,
        truth: &Image,
        target: &Image,
    ) -> Result<()> {
        if !self.is_fed(stage) {
            return Ok(());
        }
        pass.record(frame, &format!("ground truth of {}", stage.name()), truth, target)
    }
}
