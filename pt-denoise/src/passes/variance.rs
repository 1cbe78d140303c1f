//! Estimate of the noise that is left.

use crate::DenoiseParams;
use crate::images::{GEOMETRY, MOMENTS, SURFACE};
use crate::kernels;
use crate::records::VariancePush;
use pt_core::{Device, Frame, Kernel, Result, SplitLight, StageInputs, StageIo};
use pt_shaders::channels::{
    BOUNCE_THROUGHPUT, COLOR_HF, COLOR_SPEC, METALLIC_ROUGHNESS, MOTION, NORMAL, VIEW_DEPTH, VIEW_DIRECTION,
};

/// Variance of the luminance of both light channels, into their alpha; and the surfaces as the a-trous filter sees them.
pub(crate) struct Variance {
    kernel: Kernel,
    io: StageIo,
}

impl Variance {
    /// What it accesses besides source and target, of accumulated light.
    pub(crate) const TEMPORAL_IO: StageIo = StageIo {
        reads: &[
            SURFACE,
            MOMENTS,
            NORMAL,
            VIEW_DEPTH,
            VIEW_DIRECTION,
            MOTION,
            METALLIC_ROUGHNESS,
            BOUNCE_THROUGHPUT,
        ],
        writes: &[GEOMETRY],
        ..StageIo::of("denoise variance")
    };
    /// What it accesses besides the target, of each frame by itself.
    pub(crate) const SPATIAL_IO: StageIo = StageIo {
        reads: &[
            COLOR_HF,
            COLOR_SPEC,
            NORMAL,
            VIEW_DEPTH,
            VIEW_DIRECTION,
            MOTION,
            METALLIC_ROUGHNESS,
            BOUNCE_THROUGHPUT,
        ],
        writes: &[GEOMETRY],
        ..StageIo::of("denoise variance")
    };

    /// From the moments of the accumulated light, or from the pixels around where the history is short.
    pub(crate) fn temporal(device: &Device) -> Result<Self> {
        let kernel = Kernel::compute::<VariancePush>(device, &kernels::VARIANCE, &[])?;
        Self::TEMPORAL_IO.check([&kernel])?;
        Ok(Self { kernel, io: Self::TEMPORAL_IO })
    }

    /// From the pixels around; it takes the light of the lighting stages.
    pub(crate) fn spatial(device: &Device) -> Result<Self> {
        let kernel = Kernel::compute::<VariancePush>(device, &kernels::VARIANCE_SPATIAL, &[])?;
        Self::SPATIAL_IO.check([&kernel])?;
        Ok(Self { kernel, io: Self::SPATIAL_IO })
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
