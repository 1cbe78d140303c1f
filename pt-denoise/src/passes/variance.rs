//! Estimate of the noise that is left.

use super::declared;
use crate::DenoiseParams;
use crate::images::{GUIDE, SURFACE};
use crate::kernels;
use crate::records::{VARIANCE_BLOCKS, VariancePush};
use pt_core::{Device, Frame, Kernel, Result, SplitLight, StageInputs, StageIo};
use pt_shaders::ShaderCode;
use pt_shaders::channels::{COLOR_HF, COLOR_SPEC};

/// Variance of the luminance of both light channels, into their alpha, where it does not follow from the history; and the surfaces as the a-trous filter sees them.
pub(crate) struct Variance {
    guide: Kernel,
    kernel: Kernel,
    io: StageIo,
}

impl Variance {
    const GUIDE: StageIo =
        StageIo { reads: with_guides![], writes: &[GUIDE], ..StageIo::of("denoise guide") };
    const TEMPORAL: StageIo = StageIo { reads: &[SURFACE, GUIDE], ..StageIo::of("denoise variance") };
    const SPATIAL: StageIo =
        StageIo { reads: &[GUIDE, COLOR_HF, COLOR_SPEC], ..StageIo::of("denoise variance") };
    /// What it accesses besides the light, of accumulated light.
    pub(crate) const TEMPORAL_IO: [StageIo; 2] = [Self::GUIDE, Self::TEMPORAL];
    /// The same of each frame by itself.
    pub(crate) const SPATIAL_IO: [StageIo; 2] = [Self::GUIDE, Self::SPATIAL];

    /// Of accumulated light, from the pixels around where the history is short.
    pub(crate) fn temporal(device: &Device) -> Result<Self> {
        Self::with(device, &kernels::VARIANCE, Self::TEMPORAL)
    }

    /// Of the light of the lighting stages, from the pixels around.
    pub(crate) fn spatial(device: &Device) -> Result<Self> {
        Self::with(device, &kernels::VARIANCE_SPATIAL, Self::SPATIAL)
    }

    fn with(device: &Device, code: &ShaderCode, io: StageIo) -> Result<Self> {
        let guide = declared::<()>(device, &kernels::GUIDE, &Self::GUIDE, &[])?;
        Ok(Self { guide, kernel: declared::<VariancePush>(device, code, &io, &[])?, io })
    }

    /// Adds its passes to the frame. `light`: what it changes, of accumulated light, in the format of the history; or what it writes.
    pub(crate) fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        light: SplitLight<'_>,
        params: &DenoiseParams,
    ) -> Result<()> {
        let push = VariancePush {
            size: inputs.images.size().into(),
            depth: params.atrous.depth,
            normal: params.atrous.normal,
            firefly: params.temporal.firefly_limit(),
            min_length: params.atrous.min_length,
        };
        inputs.pass(frame, "denoise guide", &self.guide, &Self::GUIDE).dispatch(inputs.split_threads())?;
        let pass = inputs.pass(frame, "denoise variance", &self.kernel, &self.io);
        let [width, height, _] = inputs.flat_threads();
        let (pass, height) = match self.io.reads.contains(&SURFACE) {
            true => (
                pass.update("im_history_hf_target", light.hf).update("im_history_spec_target", light.spec),
                height.div_ceil(VARIANCE_BLOCKS),
            ),
            false => (pass.write("light_hf", light.hf).write("light_spec", light.spec), height),
        };
        pass.push(&push).dispatch([width, height, 1])
    }
}
