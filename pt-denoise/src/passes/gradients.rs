//! How much the light has changed since the last frame.

use super::temporal::push;
use crate::DenoiseParams;
use crate::images::{
    GRADIENTS, GRADIENTS2, HISTORY_LF_COCG, HISTORY_LF_SH, MOMENTS, SUMS_HF, SUMS_LF, SUMS_SPEC, SUMS2_HF,
    SUMS2_LF, SUMS2_SPEC, SURFACE,
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
        /// Change of light that is not sampled again which does not count, because it may be noise.
        pub gate_noise: f32 = 4.0, in 0.0..=100.0, unit "standard deviations";
        /// Levels of the filter over the gradients.
        pub iterations: u32 = 3, in 0..=7, source "Schied, Peters and Dachsbacher 2018, section 4.3";
        /// Which pixel of 3 x 3 is the gradient pixel; the brightest one shows changes where little light arrives, but hides lights that go on, and makes
        /// `off` and `accumulate` too bright on a capture.
        pub pixel: GradientPixel = GradientPixel::Random;
    }
}

/// Pixels of the flat frame along a side of a stratum.
const STRATUM_SIDE: u32 = 3;

/// Filtered gradients of direct light.
#[derive(Clone, Copy)]
pub(crate) struct DirectGradients<'a> {
    /// Of the gradient pixels.
    pub pixels: &'a Image,
    /// Of diffuse light against its history.
    pub sums_hf: &'a Image,
    /// Of specular light against its history.
    pub sums_spec: &'a Image,
}

/// What is compared.
#[derive(Clone, Copy, PartialEq)]
enum Compared {
    /// The light of gradient pixels with that of the last frame.
    Pixels,
    /// Sums of direct light with those of the history.
    Direct,
    /// Sums of indirect diffuse light with those of the history.
    Indirect,
}

/// Gradients of one kind and their filter.
struct Gradients {
    compared: Compared,
    change: Kernel,
    filter: Kernel,
    io: StageIo,
}

impl Gradients {
    fn new(device: &Device, compared: Compared) -> Result<Self> {
        let (change, io) = match compared {
            Compared::Pixels => {
                (Kernel::compute::<GradientPush>(device, &kernels::GRADIENT, &[])?, AntilagDirect::PIXELS)
            }
            Compared::Direct => (
                Kernel::compute::<TemporalPush>(device, &kernels::GRADIENT_DIRECT, &[])?,
                AntilagDirect::SUMS,
            ),
            Compared::Indirect => {
                (Kernel::compute::<TemporalPush>(device, &kernels::GRADIENT_LF, &[])?, AntilagIndirect::SUMS)
            }
        };
        io.check([&change])?;
        let filter = Kernel::compute::<GradientPush>(device, &kernels::GRADIENT_ATROUS, &[])?;
        Ok(Self { compared, change, filter, io })
    }

    fn constants(inputs: &StageInputs<'_>, params: &DenoiseParams, step: u32, variance: f32) -> GradientPush {
        GradientPush { size: inputs.images.size().into(), gate: params.antilag.gate, step, variance }
    }

    /// One thread per stratum.
    fn strata(inputs: &StageInputs<'_>) -> [u32; 3] {
        let size = inputs.images.size();
        [size[0].div_ceil(STRATUM_SIDE), size[1].div_ceil(STRATUM_SIDE), 1]
    }

    /// Threads of the pass that compares: sums take one for each pixel, so that the four pixels of the history are sought side by side.
    fn threads(&self, inputs: &StageInputs<'_>) -> [u32; 3] {
        let [x, y, z] = Self::strata(inputs);
        match self.compared {
            Compared::Pixels => [x, y, z],
            Compared::Direct | Compared::Indirect => [STRATUM_SIDE * x, STRATUM_SIDE * y, z],
        }
    }

    /// Adds the pass that compares to the frame.
    fn compare(&self, frame: &mut Frame<'_>, inputs: &StageInputs<'_>, params: &DenoiseParams) -> Result<()> {
        let pass = inputs.pass(frame, self.io.stage, &self.change, &self.io);
        match self.compared {
            Compared::Pixels => pass.push(&Self::constants(inputs, params, 1, 1.0)),
            Compared::Direct | Compared::Indirect => pass.push(&push(params, inputs.images)),
        }
        .dispatch(self.threads(inputs))
    }

    /// Adds the levels of the filter over the first image and returns the filtered one.
    fn filtered<'a>(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'a>,
        params: &DenoiseParams,
        images: [ChannelId; 2],
    ) -> Result<&'a Image> {
        let name = images[0].channel().name;
        let [mut now, mut next] = images.map(|id| inputs.images.current(id));
        for level in 0..params.antilag.iterations {
            let variance = if self.compared == Compared::Pixels { 1.0 } else { variance_factor(level) };
            inputs
                .pass(frame, &format!("denoise {name} a-trous {level}"), &self.filter, &StageIo::of(name))
                .sample("source", now)
                .write("target", next)
                .push(&Self::constants(inputs, params, 1 << level, variance))
                .dispatch(Self::strata(inputs))?;
            std::mem::swap(&mut now, &mut next);
        }
        Ok(now)
    }
}

/// Changes of direct light: of gradient pixels, and of sums against the history.
pub(crate) struct AntilagDirect {
    pixels: Gradients,
    sums: Gradients,
}

impl AntilagDirect {
    const PIXELS: StageIo = StageIo {
        reads: &[COLOR_HF, COLOR_SPEC, GRADIENT_SAMPLE],
        writes: &[GRADIENTS],
        ..StageIo::of("denoise gradients")
    };
    const SUMS: StageIo = StageIo {
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
        reads_previous: &[VERTEX_NORMAL, VIEW_DEPTH, SURFACE, MOMENTS],
        writes: &[SUMS_HF, SUMS_SPEC],
        ..StageIo::of("denoise sums")
    };
    /// The declarations of its passes.
    pub(crate) const IO: [StageIo; 3] = [
        Self::PIXELS,
        Self::SUMS,
        StageIo { writes: &[GRADIENTS2, SUMS2_HF, SUMS2_SPEC], ..StageIo::of("denoise gradients") },
    ];

    /// Creates the kernels.
    pub(crate) fn new(device: &Device) -> Result<Self> {
        let of = |compared| Gradients::new(device, compared);
        Ok(Self { pixels: of(Compared::Pixels)?, sums: of(Compared::Direct)? })
    }

    /// Adds the passes to the frame and returns the filtered gradients.
    pub(crate) fn record<'a>(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'a>,
        params: &DenoiseParams,
    ) -> Result<DirectGradients<'a>> {
        self.pixels.compare(frame, inputs, params)?;
        self.sums.compare(frame, inputs, params)?;
        Ok(DirectGradients {
            pixels: self.pixels.filtered(frame, inputs, params, [GRADIENTS, GRADIENTS2])?,
            sums_hf: self.sums.filtered(frame, inputs, params, [SUMS_HF, SUMS2_HF])?,
            sums_spec: self.sums.filtered(frame, inputs, params, [SUMS_SPEC, SUMS2_SPEC])?,
        })
    }
}

/// Changes of indirect diffuse light: of sums against the history.
pub(crate) struct AntilagIndirect {
    sums: Gradients,
}

impl AntilagIndirect {
    const SUMS: StageIo = StageIo {
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
        writes: &[SUMS_LF],
        ..StageIo::of("denoise sums lf")
    };
    /// The declarations of its passes.
    pub(crate) const IO: [StageIo; 2] =
        [Self::SUMS, StageIo { writes: &[SUMS2_LF], ..StageIo::of("denoise sums lf") }];

    /// Creates the kernels.
    pub(crate) fn new(device: &Device) -> Result<Self> {
        Ok(Self { sums: Gradients::new(device, Compared::Indirect)? })
    }

    /// Adds the passes to the frame and returns the filtered sums.
    pub(crate) fn record<'a>(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'a>,
        params: &DenoiseParams,
    ) -> Result<&'a Image> {
        self.sums.compare(frame, inputs, params)?;
        self.sums.filtered(frame, inputs, params, [SUMS_LF, SUMS2_LF])
    }
}

/// What level `level` of the filter makes of the variance of independent strata. Levels 0 to l together are a triangle of half width m = 2^(l + 1)
/// along each axis, whose squared weights have the sum (2 m^2 + 1) / (3 m^3); this is the quotient of two such sums, for both axes.
pub(crate) fn variance_factor(level: u32) -> f32 {
    let sum = |half_width: f64| (2.0 * half_width * half_width + 1.0) / (3.0 * half_width.powi(3));
    let half_width = f64::from(2u32 << level);
    (sum(half_width) / sum(half_width / 2.0)).powi(2) as f32
}
