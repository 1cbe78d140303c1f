//! Estimate of the noise that is left.

use super::declared;
use crate::DenoiseParams;
use crate::images::{GUIDE, SURFACE};
use crate::kernels;
use crate::records::VariancePush;
use pt_core::{Device, Frame, Kernel, Result, SplitLight, StageInputs, StageIo};
use pt_shaders::ShaderCode;
use pt_shaders::channels::{COLOR_HF, COLOR_SPEC};

/// Variance of the luminance of both light channels, into their alpha, where it does not follow from the history; and the surfaces as the a-trous filter sees them.
pub(crate) struct Variance {
    kernel: Kernel,
    io: StageIo,
}

impl Variance {
    /// What it accesses besides the light, of accumulated light.
    pub(crate) const TEMPORAL_IO: StageIo =
        StageIo { reads: with_guides![SURFACE], writes: &[GUIDE], ..StageIo::of("denoise variance") };
    /// The same of each frame by itself.
    pub(crate) const SPATIAL_IO: StageIo = StageIo {
        reads: with_guides![COLOR_HF, COLOR_SPEC],
        writes: &[GUIDE],
        ..StageIo::of("denoise variance")
    };

    /// Of accumulated light, from the pixels around where the history is short.
    pub(crate) fn temporal(device: &Device) -> Result<Self> {
        Self::with(device, &kernels::VARIANCE, Self::TEMPORAL_IO)
    }

    /// Of the light of the lighting stages, from the pixels around.
    pub(crate) fn spatial(device: &Device) -> Result<Self> {
        Self::with(device, &kernels::VARIANCE_SPATIAL, Self::SPATIAL_IO)
    }

    fn with(device: &Device, code: &ShaderCode, io: StageIo) -> Result<Self> {
        Ok(Self { kernel: declared::<VariancePush>(device, code, &io, &[])?, io })
    }

    /// Adds its pass to the frame. `light`: what it changes, of accumulated light, or what it writes.
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
        let pass = inputs.pass(frame, "denoise variance", &self.kernel, &self.io);
        let pass = match self.io.reads.contains(&SURFACE) {
            true => pass.update("light_hf", light.hf).update("light_spec", light.spec),
            false => pass.write("light_hf", light.hf).write("light_spec", light.spec),
        };
        pass.push(&push).dispatch(inputs.flat_threads())
    }
}
