//! How much the light has changed since the last frame.

use super::declared;
use super::temporal::push;
use crate::DenoiseParams;
use crate::images::{
    GRADIENTS, GRADIENTS2, HISTORY_LF_COCG, HISTORY_LF_SH, MOMENTS, SUMS_HF, SUMS_LF, SUMS_SPEC, SUMS2_HF,
    SUMS2_LF, SUMS2_SPEC,
};
use crate::kernels;
use crate::records::{GradientFilter, GradientPixel, GradientPush, Projection, Stratum, TemporalPush};
use pt_core::kernel::Constant;
use pt_core::{Device, Frame, Image, Kernel, Result, StageInputs, StageIo, knobs};
use pt_shaders::channels::{COLOR_HF, COLOR_SPEC, ChannelId, GRADIENT_SAMPLE};

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
        /// Which way gradient pixels are found.
        pub projection: Projection = Projection::Backward, source "Schied, Peters and Dachsbacher 2018, section 4.2";
        /// Pixels of a stratum.
        pub stratum: Stratum = Stratum::Three, source "Schied, Peters and Dachsbacher 2018, section 4.2" => structural;
        /// The filter over the gradients.
        pub filter: GradientFilter = GradientFilter::Atrous, source "Schied, Peters and Dachsbacher 2018, section 4.3" => structural;
    }
}

impl AntilagParams {
    /// The specialisation constant of kernels that know strata.
    pub(crate) fn stratum_constant(&self) -> (&'static str, Constant) {
        ("stratum_side", Constant::Int(self.stratum.side() as i32))
    }
}

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
    fn new(device: &Device, compared: Compared, params: &AntilagParams) -> Result<Self> {
        let constants = [params.stratum_constant()];
        let (change, io) = match compared {
            Compared::Pixels => {
                let io = AntilagDirect::PIXELS;
                (declared::<GradientPush>(device, &kernels::GRADIENT, &io, &constants)?, io)
            }
            Compared::Direct => {
                let io = AntilagDirect::SUMS;
                (declared::<TemporalPush>(device, &kernels::GRADIENT_DIRECT, &io, &constants)?, io)
            }
            Compared::Indirect => {
                let io = AntilagIndirect::SUMS;
                (declared::<TemporalPush>(device, &kernels::GRADIENT_LF, &io, &constants)?, io)
            }
        };
        let constants = [params.stratum_constant(), ("radius", Constant::Int(params.filter.radius()))];
        let filter = Kernel::compute::<GradientPush>(device, &kernels::GRADIENT_FILTER, &constants)?;
        Ok(Self { compared, change, filter, io })
    }

    fn constants(inputs: &StageInputs<'_>, params: &DenoiseParams, step: u32, variance: f32) -> GradientPush {
        GradientPush { size: inputs.images.size().into(), gate: params.antilag.gate, step, variance }
    }

    /// One thread per stratum.
    fn strata(inputs: &StageInputs<'_>, params: &DenoiseParams) -> [u32; 3] {
        let [x, y] = inputs.images.size().map(|side| side.div_ceil(params.antilag.stratum.side()));
        [x, y, 1]
    }

    /// Threads of the pass that compares: sums take one for each pixel, so that the four pixels of the history are sought side by side.
    fn threads(&self, inputs: &StageInputs<'_>, params: &DenoiseParams) -> [u32; 3] {
        match self.compared {
            Compared::Pixels => Self::strata(inputs, params),
            Compared::Direct | Compared::Indirect => inputs.flat_threads(),
        }
    }

    /// Adds the pass that compares to the frame.
    fn compare(&self, frame: &mut Frame<'_>, inputs: &StageInputs<'_>, params: &DenoiseParams) -> Result<()> {
        let pass = inputs.pass(frame, self.io.stage, &self.change, &self.io);
        match self.compared {
            Compared::Pixels => pass.push(&Self::constants(inputs, params, 1, 1.0)),
            Compared::Direct | Compared::Indirect => pass.push(&push(params, inputs.images)),
        }
        .dispatch(self.threads(inputs, params))
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
            let filter = params.antilag.filter;
            let variance =
                if self.compared == Compared::Pixels { 1.0 } else { filter.variance_factor(level) };
            inputs
                .pass(
                    frame,
                    &format!("denoise {name} {} {level}", filter.pass_name()),
                    &self.filter,
                    &StageIo::of(name),
                )
                .sample("source", now)
                .write("target", next)
                .push(&Self::constants(inputs, params, filter.step(level), variance))
                .dispatch(Self::strata(inputs, params))?;
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
        reads: with_surfaces![COLOR_HF, COLOR_SPEC; GRADIENT_SAMPLE],
        reads_previous: with_surfaces_before![MOMENTS],
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
    pub(crate) fn new(device: &Device, params: &AntilagParams) -> Result<Self> {
        let of = |compared| Gradients::new(device, compared, params);
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
        reads: with_surfaces![COLOR_LF_SH, COLOR_LF_COCG],
        reads_previous: with_surfaces_before![HISTORY_LF_SH, HISTORY_LF_COCG],
        writes: &[SUMS_LF],
        ..StageIo::of("denoise sums lf")
    };
    /// The declarations of its passes.
    pub(crate) const IO: [StageIo; 2] =
        [Self::SUMS, StageIo { writes: &[SUMS2_LF], ..StageIo::of("denoise sums lf") }];

    /// Creates the kernels.
    pub(crate) fn new(device: &Device, params: &AntilagParams) -> Result<Self> {
        Ok(Self { sums: Gradients::new(device, Compared::Indirect, params)? })
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

impl GradientFilter {
    /// What its passes are called.
    const fn pass_name(self) -> &'static str {
        match self {
            Self::Atrous => "a-trous",
            Self::Strided => "strided",
        }
    }

    /// Taps to each side.
    pub(crate) const fn radius(self) -> i32 {
        match self {
            Self::Atrous => 1,
            Self::Strided => 2,
        }
    }

    /// Distance of the taps of a level, strata.
    pub(crate) const fn step(self, level: u32) -> u32 {
        match self {
            Self::Atrous => 1 << level,
            Self::Strided => 3u32.pow(level),
        }
    }

    /// What a level makes of the variance of independent strata, after the levels before it: the quotient of two sums of squared weights, that of all levels up to it
    /// and that of those before, for both axes.
    pub(crate) fn variance_factor(self, level: u32) -> f32 {
        let squares = |kernel: &[f64]| kernel.iter().map(|w| w * w).sum::<f64>();
        let before = self.kernel_of_levels(level);
        (squares(&self.kernel_of_levels(level + 1)) / squares(&before)).powi(2) as f32
    }

    /// Weights along an axis of so many levels together.
    fn kernel_of_levels(self, levels: u32) -> Vec<f64> {
        let taps: &[f64] = match self {
            Self::Atrous => &[0.25, 0.5, 0.25],
            Self::Strided => &[0.0625, 0.25, 0.375, 0.25, 0.0625],
        };
        (0..levels).fold(vec![1.0], |kernel, level| {
            let step = self.step(level) as usize;
            let mut wider = vec![0.0; kernel.len() + (taps.len() - 1) * step];
            for (i, tap) in taps.iter().enumerate() {
                kernel.iter().enumerate().for_each(|(k, w)| wider[k + i * step] += tap * w);
            }
            wider
        })
    }
}
