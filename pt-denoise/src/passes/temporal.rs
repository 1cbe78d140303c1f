//! Temporal accumulation.

use crate::images::{HISTORY_HF, HISTORY_SPEC, MOMENTS, SURFACE};
use crate::kernels;
use crate::records::TemporalPush;
use pt_core::{Device, Frame, Kernel, Result, SplitLight, StageInputs, StageIo, knobs};
use pt_shaders::channels::{
    COLOR_HF, COLOR_SPEC, MOTION, SHADING_POSITION, VERTEX_NORMAL, VIEW_DEPTH, VIEW_DIRECTION,
};

knobs! {
    /// Knobs of temporal accumulation.
    pub struct TemporalParams {
        /// Least weight of a new frame in the diffuse channel; before, history is a running mean.
        pub alpha_hf: f32 = 0.05, in 0.001..=1.0, source "Schied et al. 2017, eq. 1";
        /// Least weight of a new frame in the specular channel.
        pub alpha_spec: f32 = 0.05, in 0.001..=1.0, source "Schied et al. 2017, eq. 1";
        /// Least weight of a new frame in the moments of the luminance.
        pub alpha_moments: f32 = 0.05, in 0.001..=1.0, source "Schied et al. 2017, section 4.2";
        /// Greatest difference of a history pixel in distance from the camera, relative to the distance; the slope of the surface within two
        /// pixels is always allowed.
        pub depth: f32 = 0.02, in 0.0..=1.0;
        /// Greatest angle between the vertex normals of a pixel and of a history pixel.
        pub normal: f32 = 25.0, in 0.0..=180.0, unit "degrees";
        /// A sample is limited to this many times what history and the pixels around hold, the brightest of them left out, and what exceeds the
        /// limit is lost; none is no limit.
        pub firefly: Option<f32> = Some(1e5), in 1.0..=1e6;
    }
}

impl TemporalParams {
    /// Limit of a sample over what is expected, as kernels take it.
    pub(crate) fn firefly_limit(&self) -> f32 {
        self.firefly.unwrap_or(0.0)
    }

    fn push(&self, size: [u32; 2], reset: bool) -> TemporalPush {
        TemporalPush {
            size: size.into(),
            alpha_hf: self.alpha_hf,
            alpha_spec: self.alpha_spec,
            alpha_moments: self.alpha_moments,
            depth: self.depth,
            normal: self.normal.to_radians().cos(),
            firefly: self.firefly_limit(),
            max_length: MAX_LENGTH,
            reset: reset.into(),
        }
    }
}

/// Greatest length of a history, frames. Larger than the inverse of any sensible least weight; fp32 holds it exactly.
pub(crate) const MAX_LENGTH: u32 = 4096;

/// This frame's light into the history along the motion of the surfaces.
pub(crate) struct Temporal {
    kernel: Kernel,
}

impl Temporal {
    /// The images that it accesses besides its target.
    pub(crate) const IO: StageIo = StageIo {
        reads: &[COLOR_HF, COLOR_SPEC, SHADING_POSITION, VERTEX_NORMAL, VIEW_DEPTH, VIEW_DIRECTION, MOTION],
        reads_previous: &[VERTEX_NORMAL, VIEW_DEPTH, SURFACE, MOMENTS, HISTORY_HF, HISTORY_SPEC],
        writes: &[SURFACE, MOMENTS],
        ..StageIo::of("denoise temporal")
    };

    /// Creates the kernel.
    pub(crate) fn new(device: &Device) -> Result<Self> {
        let kernel = Kernel::compute::<TemporalPush>(device, &kernels::TEMPORAL, &[])?;
        Self::IO.check([&kernel])?;
        Ok(Self { kernel })
    }

    /// Adds its pass to the frame. The alpha of `target` says nothing.
    pub(crate) fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        target: SplitLight<'_>,
        params: &TemporalParams,
    ) -> Result<()> {
        inputs
            .pass(frame, "denoise temporal", &self.kernel, &Self::IO)
            .write("target_hf", target.hf)
            .write("target_spec", target.spec)
            .push(&params.push(inputs.images.size(), !inputs.images.has_history()))
            .dispatch(inputs.flat_threads())
    }
}
