//! Estimate of the noise that is left.

use super::declared;
use crate::DenoiseParams;
use crate::images::{GEOMETRY, MOMENTS, SURFACE};
use crate::kernels;
use crate::records::VariancePush;
use pt_core::{Device, Frame, Kernel, Result, SplitLight, StageInputs, StageIo};
use pt_shaders::channels::{COLOR_HF, COLOR_SPEC};

/// Variance of the luminance of both light channels, into their alpha; and the surfaces as the a-trous filter sees them.
pub(crate) struct Variance {
    kernel: Kernel,
    io: StageIo,
}

impl Variance {
    /// What it accesses besides source and target, of accumulated light.
    pub(crate) const TEMPORAL_IO: StageIo = StageIo {
        reads: with_guides![SURFACE, MOMENTS],
        writes: &[GEOMETRY],
        ..StageIo::of("denoise variance")
    };
    /// What it accesses besides the target, of each frame by itself.
    pub(crate) const SPATIAL_IO: StageIo = StageIo {
        reads: with_guides![COLOR_HF, COLOR_SPEC],
        writes: &[GEOMETRY],
        ..StageIo::of("denoise variance")
    };

    /// From the moments of the accumulated light, or from the pixels around where the history is short.
    pub(crate) fn temporal(device: &Device) -> Result<Self> {
        let io = Self::TEMPORAL_IO;
        Ok(Self { kernel: declared::<VariancePush>(device, &kernels::VARIANCE, &io, &[])?, io })
    }

    /// From the pixels around; it takes the light of the lighting stages.
    pub(crate) fn spatial(device: &Device) -> Result<Self> {
        let io = Self::SPATIAL_IO;
        Ok(Self { kernel: declared::<VariancePush>(device, &kernels::VARIANCE_SPATIAL, &io, &[])?, io })
    }

    /// Adds its pass to the frame. `source`: the accumulated light.
    pub(crate) fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        source: Option<SplitLight<'_>>,
        target: SplitLight<'_>,
        params: &DenoiseParams,
    ) -> Result<()> {
        let push = VariancePush {
            size: inputs.images.size().into(),
            alpha_hf: params.temporal.alpha_hf,
            alpha_spec: params.temporal.alpha_spec,
            depth: params.atrous.depth,
            normal: params.atrous.normal,
            firefly: params.temporal.firefly_limit(),
            min_length: params.atrous.min_length,
        };
        let mut pass = inputs.pass(frame, "denoise variance", &self.kernel, &self.io);
        if let Some(source) = source {
            pass = pass.sample("source_hf", source.hf).sample("source_spec", source.spec);
        }
        let pass = pass.write("target_hf", target.hf).write("target_spec", target.spec);
        pass.push(&push).dispatch(inputs.flat_threads())
    }
}
