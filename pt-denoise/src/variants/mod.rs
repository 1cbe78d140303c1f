//! The variants of the denoiser: each puts passes together.

mod accumulate;
mod atrous;
mod svgf;

use crate::DenoiseParams;
use crate::images::{HISTORY_HF, HISTORY_SPEC, PING_HF, PING_SPEC, PONG_HF, PONG_SPEC};
use crate::records::Denoiser;
use pt_core::{ChannelImages, Device, Frame, Result, SplitLight, StageInputs, StageIo};
use pt_shaders::channels::ChannelId;

/// A variant with its kernels.
trait Variant: Send + Sync {
    /// Adds its passes to the frame and returns the filtered light.
    fn record<'a>(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'a>,
        params: &DenoiseParams,
    ) -> Result<SplitLight<'a>>;
}

/// The denoiser that the knobs ask for, from the lighting stages to the composite.
pub struct DenoiseChain {
    denoiser: Denoiser,
    variant: Option<Box<dyn Variant>>,
}

impl DenoiseChain {
    /// Creates the kernels of `params.denoiser`.
    ///
    /// # Errors
    /// When the device refuses.
    pub fn new(device: &Device, params: &DenoiseParams) -> Result<Self> {
        let variant: Option<Box<dyn Variant>> = match params.denoiser {
            Denoiser::Off => None,
            Denoiser::Accumulate => Some(Box::new(accumulate::Accumulate::new(device)?)),
            Denoiser::Svgf => Some(Box::new(svgf::Svgf::new(device)?)),
            Denoiser::Atrous => Some(Box::new(atrous::AtrousAlone::new(device)?)),
        };
        Ok(Self { denoiser: params.denoiser, variant })
    }

    /// The declarations of its passes, in order; [`Denoiser::Off`] only hands on what it is given.
    pub fn io(&self) -> &'static [StageIo] {
        self.denoiser.io()
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
        match &self.variant {
            Some(variant) => variant.record(frame, inputs, params),
            None => Ok(SplitLight::unfiltered(inputs.images)),
        }
    }
}

impl Denoiser {
    /// The declarations of the variant's passes, in order.
    pub fn io(self) -> &'static [StageIo] {
        match self {
            Self::Off => &[SplitLight::UNFILTERED],
            Self::Accumulate => accumulate::Accumulate::IO,
            Self::Svgf => svgf::Svgf::IO,
            Self::Atrous => atrous::AtrousAlone::IO,
        }
    }
}

/// A declaration of images that are bound by other names, because several passes take them in turn.
const fn writing(stage: &'static str, writes: &'static [ChannelId]) -> StageIo {
    StageIo { writes, ..StageIo::of(stage) }
}

fn history(images: &ChannelImages) -> SplitLight<'_> {
    SplitLight { hf: images.current(HISTORY_HF), spec: images.current(HISTORY_SPEC) }
}

fn ping(images: &ChannelImages) -> SplitLight<'_> {
    SplitLight { hf: images.current(PING_HF), spec: images.current(PING_SPEC) }
}

fn pong(images: &ChannelImages) -> SplitLight<'_> {
    SplitLight { hf: images.current(PONG_HF), spec: images.current(PONG_SPEC) }
}
