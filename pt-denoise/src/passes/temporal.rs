//! Temporal accumulation.

use super::gradients::DirectGradients;
use crate::DenoiseParams;
use crate::images::{HISTORY_HF, HISTORY_SPEC, MOMENTS, SURFACE};
use crate::kernels;
use crate::records::{GradientPixel, TemporalPush};
use pt_core::{ChannelImages, Device, Frame, Kernel, Result, SplitLight, StageInputs, StageIo, knobs};
use pt_shaders::channels::{
    COLOR_HF, COLOR_SPEC, GRADIENT_SAMPLE, MOTION, SHADING_POSITION, VERTEX_NORMAL, VIEW_DEPTH,
    VIEW_DIRECTION,
};

knobs! {
    /// Knobs of temporal accumulation.
    pub struct TemporalParams {
        /// Least weight of a new frame in the diffuse channel; before, history is a running mean.
        pub alpha_hf: f32 = 0.05, in 0.001..=1.0, source "Schied et al. 2017, eq. 1";
        /// Least weight of a new frame in the specular channel.
        pub alpha_spec: f32 = 0.05, in 0.001..=1.0, source "Schied et al. 2017, eq. 1";
        /// Least weight of a new frame in the indirect diffuse channel.
        pub alpha_lf: f32 = 0.05, in 0.001..=1.0, source "Schied et al. 2017, eq. 1";
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
    /// Cosine of the greatest angle between normals.
    pub(crate) fn normal_cosine(&self) -> f32 {
        self.normal.to_radians().cos()
    }

    /// Limit of a sample over what is expected, as kernels take it.
    pub(crate) fn firefly_limit(&self) -> f32 {
        self.firefly.unwrap_or(0.0)
    }
}

/// Push constants of all passes that read the last frame.
pub(super) fn push(params: &DenoiseParams, images: &ChannelImages) -> TemporalPush {
    let DenoiseParams { temporal, antilag, .. } = params;
    TemporalPush {
        size: images.size().into(),
        alpha_hf: temporal.alpha_hf,
        alpha_spec: temporal.alpha_spec,
        alpha_lf: temporal.alpha_lf,
        alpha_moments: temporal.alpha_moments,
        depth: temporal.depth,
        normal: temporal.normal_cosine(),
        firefly: temporal.firefly_limit(),
        antilag_hf: antilag.hf,
        antilag_spec: antilag.spec,
        antilag_lf: antilag.lf,
        gate_noise: antilag.gate_noise,
        max_length: MAX_LENGTH,
        reset: (!images.has_history()).into(),
    }
}

/// Greatest length of a history, frames. Larger than the inverse of any sensible least weight; fp32 holds it exactly.
pub(crate) const MAX_LENGTH: u32 = 4096;

/// This frame's light into the history along the motion of the surfaces.
pub(crate) struct Temporal {
    kernel: Kernel,
    io: StageIo,
}

impl Temporal {
    /// The images that it accesses besides its target.
    pub(crate) const IO: StageIo = StageIo {
        reads: &[COLOR_HF, COLOR_SPEC, SHADING_POSITION, VERTEX_NORMAL, VIEW_DEPTH, VIEW_DIRECTION, MOTION],
        reads_previous: &[VERTEX_NORMAL, VIEW_DEPTH, SURFACE, MOMENTS, HISTORY_HF, HISTORY_SPEC],
        writes: &[SURFACE, MOMENTS],
        ..StageIo::of("denoise temporal")
    };
    /// The same of the kernel that follows changes of the light.
    pub(crate) const IO_ANTILAG: StageIo = StageIo {
        reads: &[
            COLOR_HF,
            COLOR_SPEC,
            SHADING_POSITION,
            VERTEX_NORMAL,
            VIEW_DEPTH,
            VIEW_DIRECTION,
            MOTION,
            GRADIENT_SAMPLE,
        ],
        ..Self::IO
    };

    /// Creates the kernel; `antilag`: it follows changes of the light.
    pub(crate) fn new(device: &Device, antilag: bool) -> Result<Self> {
        let (code, io) = match antilag {
            true => (&kernels::TEMPORAL_ANTILAG, Self::IO_ANTILAG),
            false => (&kernels::TEMPORAL, Self::IO),
        };
        let kernel = Kernel::compute::<TemporalPush>(device, code, &[])?;
        io.check([&kernel])?;
        Ok(Self { kernel, io })
    }

    /// Adds its pass to the frame. The alpha of `target` says nothing. `gradients`: of a kernel that follows changes of the light.
    pub(crate) fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        target: SplitLight<'_>,
        gradients: Option<DirectGradients<'_>>,
        params: &DenoiseParams,
    ) -> Result<()> {
        let mut pass = inputs
            .pass(frame, "denoise temporal", &self.kernel, &self.io)
            .write("target_hf", target.hf)
            .write("target_spec", target.spec);
        if let Some(gradients) = gradients {
            pass = pass
                .sample("gradients", gradients.pixels)
                .sample("sums_hf", gradients.sums_hf)
                .sample("sums_spec", gradients.sums_spec);
        }
        let mut push = push(params, inputs.images);
        // Pixels without the brightest of the last frame are too dark in the history: a difference says nothing.
        if params.antilag.pixel == GradientPixel::Brightest {
            push.gate_noise = f32::MAX;
        }
        pass.push(&push).dispatch(inputs.flat_threads())
    }
}
