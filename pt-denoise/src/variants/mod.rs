//! The variants of the denoiser: each puts passes together.

mod accumulate;
mod atrous;
mod low_frequency;
mod recurrent;
mod svgf;

use crate::DenoiseParams;
use crate::images::{
    HISTORY_HF, HISTORY_SPEC, LEVELS2_HF, LEVELS2_SPEC, PING_HF, PING_SPEC, PONG_HF, PONG_SPEC,
};
use crate::passes::{Changes, Gradients};
use crate::records::Denoiser;
use low_frequency::LowFrequency;
use pt_core::{ChannelImages, Device, Error, Frame, Result, SplitLight, StageInputs, StageIo};
use pt_shaders::channels::ChannelId;

/// A variant with its kernels.
trait Variant: Send + Sync {
    /// Adds its passes to the frame and returns the filtered light. `changes`: of a variant that follows them.
    fn record<'a>(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'a>,
        changes: Option<Changes<'_>>,
        params: &DenoiseParams,
    ) -> Result<SplitLight<'a>>;
}

/// The denoiser that the knobs ask for, from the lighting stages to the composite.
pub struct DenoiseChain {
    io: Vec<StageIo>,
    /// Of a variant that follows changes of the light.
    gradients: Option<Gradients>,
    variant: Option<Box<dyn Variant>>,
    /// Of indirect diffuse light, if there is any.
    low_frequency: Option<LowFrequency>,
}

impl DenoiseChain {
    /// Creates the kernels of `params.variant`; `indirect`: there is indirect light.
    ///
    /// # Errors
    /// When the device refuses.
    pub fn new(device: &Device, params: &DenoiseParams, indirect: bool) -> Result<Self> {
        let variant: Option<Box<dyn Variant>> = match params.variant {
            Denoiser::Off => None,
            Denoiser::Accumulate => Some(Box::new(accumulate::Accumulate::new(device, params)?)),
            Denoiser::Svgf => Some(Box::new(svgf::Svgf::new(device, params, false)?)),
            Denoiser::Asvgf => Some(Box::new(svgf::Svgf::new(device, params, true)?)),
            Denoiser::Atrous => Some(Box::new(atrous::AtrousAlone::new(device, params)?)),
            Denoiser::Recurrent => Some(Box::new(recurrent::Recurrent::new(device, params)?)),
            Denoiser::Oidn => {
                return Err(Error::Unsupported(
                    "denoise.variant=oidn is no pass of a frame; record frames with pt capture and run pt-denoise DIR --variant oidn"
                        .into(),
                ));
            }
        };
        let low_frequency = indirect.then(|| LowFrequency::new(device, params)).transpose()?;
        let gradients = params.follows_changes().then(|| Gradients::new(device, &params.antilag, indirect));
        Ok(Self { io: params.passes(indirect), gradients: gradients.transpose()?, variant, low_frequency })
    }

    /// The declarations of its passes, in order; [`Denoiser::Off`] only hands on what it is given.
    pub fn io(&self) -> &[StageIo] {
        &self.io
    }

    /// The images of the lighting stages that the composite reads because no pass filters them.
    pub fn handed_on(&self) -> StageIo {
        let keeps_indirect = self.low_frequency.as_ref().is_some_and(LowFrequency::hands_on);
        match &self.variant {
            _ if keeps_indirect => SplitLight::UNFILTERED_INDIRECT,
            None => SplitLight::UNFILTERED,
            Some(_) => StageIo::of("denoiser"),
        }
    }

    /// Records the passes for one frame and returns the light for the composite.
    ///
    /// # Errors
    /// When the passes do not fit into the frame.
    pub fn record<'a>(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'a>,
        params: &DenoiseParams,
    ) -> Result<SplitLight<'a>> {
        let unfiltered = SplitLight::unfiltered(inputs.images);
        let changes = self.gradients.as_ref().map(|g| g.record(frame, inputs, params)).transpose()?;
        let lf = match (&self.low_frequency, unfiltered.lf) {
            (Some(passes), Some(source)) => Some(passes.record(frame, inputs, source, changes, params)?),
            _ => None,
        };
        match &self.variant {
            Some(variant) => Ok(SplitLight { lf, ..variant.record(frame, inputs, changes, params)? }),
            None => Ok(SplitLight { lf, ..unfiltered }),
        }
    }
}

impl DenoiseParams {
    /// Whether the variant's history follows changes of the light.
    fn follows_changes(&self) -> bool {
        self.variant == Denoiser::Asvgf
    }

    /// The declarations of the variant's passes, in order; `indirect`: there is indirect light.
    pub fn passes(&self, indirect: bool) -> Vec<StageIo> {
        let direct = match self.variant {
            Denoiser::Off | Denoiser::Oidn => vec![SplitLight::UNFILTERED],
            Denoiser::Accumulate => accumulate::Accumulate::io(self),
            Denoiser::Svgf => svgf::Svgf::io(self, false),
            Denoiser::Asvgf => svgf::Svgf::io(self, true),
            Denoiser::Atrous => atrous::AtrousAlone::io(),
            Denoiser::Recurrent => recurrent::Recurrent::io(self),
        };
        let mut all = Vec::new();
        if self.follows_changes() {
            all.extend(Gradients::io(indirect));
        }
        if indirect {
            all.extend(LowFrequency::io(self.variant));
        }
        all.extend(direct);
        all
    }
}

/// A declaration of images that are bound by other names, because several passes take them in turn. It comes before those of the passes: from there on
/// the memory is theirs.
const fn writing(stage: &'static str, writes: &'static [ChannelId]) -> StageIo {
    StageIo { writes, ..StageIo::of(stage) }
}

fn history(images: &ChannelImages) -> SplitLight<'_> {
    SplitLight { hf: images.current(HISTORY_HF), spec: images.current(HISTORY_SPEC), lf: None }
}

fn levels(images: &ChannelImages) -> SplitLight<'_> {
    SplitLight { hf: images.current(LEVELS2_HF), spec: images.current(LEVELS2_SPEC), lf: None }
}

fn ping(images: &ChannelImages) -> SplitLight<'_> {
    SplitLight { hf: images.current(PING_HF), spec: images.current(PING_SPEC), lf: None }
}

fn pong(images: &ChannelImages) -> SplitLight<'_> {
    SplitLight { hf: images.current(PONG_HF), spec: images.current(PONG_SPEC), lf: None }
}
