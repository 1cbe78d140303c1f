//! How much the light has changed since the last frame.

use super::temporal::push;
use crate::DenoiseParams;
use crate::images::{
    GRADIENTS, GRADIENTS_LF, GRADIENTS2, GRADIENTS2_LF, HISTORY_LF_COCG, HISTORY_LF_SH, SURFACE,
};
use crate::kernels;
use crate::records::{GradientPixel, GradientPush, TemporalPush};
use pt_core::{Device, Frame, Image, Kernel, Result, StageInputs, StageIo, knobs};
use pt_shaders::channels::{
    COLOR_HF, COLOR_LF_COCG, COLOR_LF_SH, COLOR_SPEC, ChannelId, GRADIENT_SAMPLE, MOTION, SHADING_POSITION,
    VERTEX_NORMAL, VIEW_DEPTH, VIEW_DIRECTION,
};

knobs! {
    /// Knobs of adaptive temporal filtering (`asvgf`).
    pub struct AntilagParams {
        /// Factor on the relative change of diffuse light, which is how much of its history is forgotten.
        pub hf: f32 = 1.0, in 0.0..=10.0, source "Schied, Peters and Dachsbacher 2018, section 4.3";
        /// The same of specular light.
        pub spec: f32 = 1.0, in 0.0..=10.0, source "Schied, Peters and Dachsbacher 2018, section 4.3";
        /// The same of indirect diffuse light.
        pub lf: f32 = 1.0, in 0.0..=10.0, source "Schied, Peters and Dachsbacher 2018, section 4.3";
        /// Relative change of the light of a gradient pixel that does not count.
        pub gate: f32 = 0.05, in 0.0..=1.0;
        /// Change of indirect diffuse light that does not count, because it may be noise.
        pub gate_lf: f32 = 4.0, in 0.0..=100.0, unit "standard deviations";
        /// Levels of the filter over the gradients.
        pub iterations: u32 = 3, in 0..=7, source "Schied, Peters and Dachsbacher 2018, section 4.3";
        /// Which pixel of 3 x 3 is the gradient pixel. The brightest one is no fair sample: the denoiser leaves it out of the history, and `off` and
        /// `accumulate` on a capture of these pixels are too bright.
        pub pixel: GradientPixel = GradientPixel::Brightest;
    }
}

/// Pixels of the flat frame along a side of a stratum.
const STRATUM_SIDE: u32 = 3;

/// The images that the filter takes in turn, of the direct and of the indirect light.
const IMAGES: [[ChannelId; 2]; 2] = [[GRADIENTS, GRADIENTS2], [GRADIENTS_LF, GRADIENTS2_LF]];

/// Gradients of direct light (diffuse and specular), or of indirect diffuse light, and their filter.
pub(crate) struct Gradients {
    change: Kernel,
    filter: Kernel,
    io: StageIo,
    of_lf: bool,
}

impl Gradients {
    /// The images that the passes over direct light access.
    pub(crate) const IO: StageIo = StageIo {
        reads: &[COLOR_HF, COLOR_SPEC, GRADIENT_SAMPLE],
        writes: &[GRADIENTS],
        ..StageIo::of("denoise gradients")
    };
    /// Images that the filter takes in turn.
    pub(crate) const FILTER: StageIo =
        StageIo { writes: &[GRADIENTS2], ..StageIo::of("denoise gradients") };
    /// The images that the passes over indirect light access.
    pub(crate) const IO_LF: StageIo = StageIo {
        reads: &[
            COLOR_LF_SH,
            COLOR_LF_COCG,
            SHADING_POSITION,
            VERTEX_NORMAL,
            VIEW_DEPTH,
            VIEW_DIRECTION,
            MOTION,
        ],
        reads_previous: &[VERTEX_NORMAL, VIEW_DEPTH, SURFACE, HISTORY_LF_SH, HISTORY_LF_COCG],
        writes: &[GRADIENTS_LF],
        ..StageIo::of("denoise gradients lf")
    };
    /// Images that the filter takes in turn.
    pub(crate) const FILTER_LF: StageIo =
        StageIo { writes: &[GRADIENTS2_LF], ..StageIo::of("denoise gradients lf") };

    /// Of direct light.
    pub(crate) fn new(device: &Device) -> Result<Self> {
        let change = Kernel::compute::<GradientPush>(device, &kernels::GRADIENT, &[])?;
        Self::with(device, change, Self::IO, false)
    }

    /// Of indirect diffuse light.
    pub(crate) fn of_lf(device: &Device) -> Result<Self> {
        let change = Kernel::compute::<TemporalPush>(device, &kernels::GRADIENT_LF, &[])?;
        Self::with(device, change, Self::IO_LF, true)
    }

    fn with(device: &Device, change: Kernel, io: StageIo, of_lf: bool) -> Result<Self> {
        io.check([&change])?;
        let filter = Kernel::compute::<GradientPush>(device, &kernels::GRADIENT_ATROUS, &[])?;
        Ok(Self { change, filter, io, of_lf })
    }

    /// Adds the passes to the frame and returns the filtered gradients.
    pub(crate) fn record<'a>(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'a>,
        params: &DenoiseParams,
    ) -> Result<&'a Image> {
        let images = inputs.images;
        let size = images.size();
        let strata = [size[0].div_ceil(STRATUM_SIDE), size[1].div_ceil(STRATUM_SIDE), 1];
        let constants = |step: u32, variance: f32| GradientPush {
            size: size.into(),
            gate: params.antilag.gate,
            step,
            variance,
        };
        let name = self.io.stage;
        let pass = inputs.pass(frame, name, &self.change, &self.io);
        match self.of_lf {
            true => pass.push(&push(params, images)),
            false => pass.push(&constants(1, 1.0)),
        }
        .dispatch(strata)?;
        let [mut now, mut next] = IMAGES[usize::from(self.of_lf)].map(|id| images.current(id));
        for level in 0..params.antilag.iterations {
            let variance = if self.of_lf { variance_factor(level) } else { 1.0 };
            inputs
                .pass(frame, &format!("{name} a-trous {level}"), &self.filter, &StageIo::of(name))
                .sample("source", now)
                .write("target", next)
                .push(&constants(1 << level, variance))
                .dispatch(strata)?;
            std::mem::swap(&mut now, &mut next);
        }
        Ok(now)
    }
}

/// What level `level` of the filter makes of the variance of independent strata. Levels 0 to l together are a triangle of half width m = 2^(l + 1)
/// along each axis, whose squared weights have the sum (2 m^2 + 1) / (3 m^3); this is the quotient of two such sums, for both axes.
pub(crate) fn variance_factor(level: u32) -> f32 {
    let sum = |half_width: f64| (2.0 * half_width * half_width + 1.0) / (3.0 * half_width.powi(3));
    let half_width = f64::from(2u32 << level);
    (sum(half_width) / sum(half_width / 2.0)).powi(2) as f32
}
