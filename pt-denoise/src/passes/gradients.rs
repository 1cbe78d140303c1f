//! How much the light has changed since the last frame.

use super::declared;
use super::push::push;
use crate::DenoiseParams;
use crate::images::{
    GRADIENTS, GRADIENTS2, HISTORY_LF_COCG, HISTORY_LF_SH, MOMENTS, SUMS_HF, SUMS_LF, SUMS_SPEC, SUMS2_HF,
    SUMS2_LF, SUMS2_SPEC,
};
use crate::kernels;
use crate::records::{GradientFilter, GradientPixel, GradientPush, Projection, Stratum, TemporalPush};
use pt_core::kernel::Constant;
use pt_core::{Device, Frame, Image, Kernel, Result, StageInputs, StageIo, knobs};
use pt_shaders::channels::ChannelId;

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
        pub gate: f32 = 0.15, in 0.0..=1.0;
        /// Change of light that is not sampled again which does not count, because it may be noise.
        pub gate_noise: f32 = 3.0, in 0.0..=100.0, unit "standard deviations";
        /// Levels of the filter over the gradients.
        pub iterations: u32 = 3, in 0..=7, source "Schied, Peters and Dachsbacher 2018, section 4.3";
        /// Which pixel of a stratum is the gradient pixel; the brightest one shows changes where little light arrives, but hides lights that go on, and makes
        /// `off` and `accumulate` too bright on a capture.
        pub pixel: GradientPixel = GradientPixel::Random;
        /// Which way gradient pixels are found.
        pub projection: Projection = Projection::Backward, source "Schied, Peters and Dachsbacher 2018, section 4.2";
        /// Pixels of a stratum.
        pub stratum: Stratum = Stratum::Five, source "Schied, Peters and Dachsbacher 2018, section 4.2" => structural;
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

/// Filtered changes of the light.
#[derive(Clone, Copy)]
pub(crate) struct Changes<'a> {
    /// Of the gradient pixels.
    pub pixels: &'a Image,
    /// Of diffuse light against its history.
    pub sums_hf: &'a Image,
    /// Of specular light against its history.
    pub sums_spec: &'a Image,
    /// Of indirect diffuse light against its history, if there is any.
    pub sums_lf: Option<&'a Image>,
}

/// Changes of the light, of gradient pixels and of sums against the history, and their filter.
pub(crate) struct Gradients {
    compare: Kernel,
    filter: Kernel,
    indirect: bool,
}

impl Gradients {
    const DIRECT: StageIo = StageIo {
        reads: with_surfaces![COLOR_HF, COLOR_SPEC; GRADIENT_SAMPLE],
        reads_previous: with_surfaces_before![MOMENTS],
        writes: &[GRADIENTS, SUMS_HF, SUMS_SPEC],
        ..StageIo::of("denoise gradients")
    };
    const INDIRECT: StageIo = StageIo {
        reads: with_surfaces![COLOR_HF, COLOR_SPEC, COLOR_LF_SH, COLOR_LF_COCG; GRADIENT_SAMPLE],
        reads_previous: with_surfaces_before![MOMENTS, HISTORY_LF_SH, HISTORY_LF_COCG],
        writes: &[GRADIENTS, SUMS_HF, SUMS_SPEC, SUMS_LF],
        ..StageIo::of("denoise gradients")
    };
    const FILTER: StageIo = StageIo::of("denoise gradients");

    const fn comparison(indirect: bool) -> StageIo {
        if indirect { Self::INDIRECT } else { Self::DIRECT }
    }

    /// The declarations of its passes; `indirect`: there is indirect diffuse light.
    pub(crate) const fn io(indirect: bool) -> [StageIo; 2] {
        let targets: &[_] = match indirect {
            true => &[GRADIENTS2, SUMS2_HF, SUMS2_SPEC, SUMS2_LF],
            false => &[GRADIENTS2, SUMS2_HF, SUMS2_SPEC],
        };
        [Self::comparison(indirect), StageIo { writes: targets, ..Self::FILTER }]
    }

    /// Creates the kernels.
    pub(crate) fn new(device: &Device, params: &AntilagParams, indirect: bool) -> Result<Self> {
        let (compare, filter) = match indirect {
            true => (&kernels::GRADIENTS_INDIRECT, &kernels::GRADIENT_FILTER_INDIRECT),
            false => (&kernels::GRADIENTS, &kernels::GRADIENT_FILTER),
        };
        let [stratum, radius] =
            [params.stratum_constant(), ("radius", Constant::Int(params.filter.radius()))];
        let io = Self::comparison(indirect);
        Ok(Self {
            compare: declared::<TemporalPush>(device, compare, &io, &[stratum])?,
            filter: declared::<GradientPush>(device, filter, &Self::FILTER, &[stratum, radius])?,
            indirect,
        })
    }

    /// Adds the passes to the frame and returns the filtered changes.
    pub(crate) fn record<'a>(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'a>,
        params: &DenoiseParams,
    ) -> Result<Changes<'a>> {
        // A thread for each pixel, so that the four pixels of the history are sought side by side.
        inputs
            .pass(frame, "denoise gradients", &self.compare, &Self::comparison(self.indirect))
            .push(&push(params, inputs))
            .dispatch(inputs.flat_threads())?;
        let images = |[pixels, hf, spec, lf]: [ChannelId; 4]| Changes {
            pixels: inputs.images.current(pixels),
            sums_hf: inputs.images.current(hf),
            sums_spec: inputs.images.current(spec),
            sums_lf: self.indirect.then(|| inputs.images.current(lf)),
        };
        let mut now = images([GRADIENTS, SUMS_HF, SUMS_SPEC, SUMS_LF]);
        let mut next = images([GRADIENTS2, SUMS2_HF, SUMS2_SPEC, SUMS2_LF]);
        let filter = params.antilag.filter;
        let [x, y] = inputs.images.size().map(|side| side.div_ceil(params.antilag.stratum.side()));
        for level in 0..params.antilag.iterations {
            let name = format!("denoise gradients {} {level}", filter.pass_name());
            let mut pass = inputs
                .pass(frame, &name, &self.filter, &Self::FILTER)
                .sample("source_pixels", now.pixels)
                .sample("source_hf", now.sums_hf)
                .sample("source_spec", now.sums_spec)
                .write("target_pixels", next.pixels)
                .write("target_hf", next.sums_hf)
                .write("target_spec", next.sums_spec);
            if let (Some(source), Some(target)) = (now.sums_lf, next.sums_lf) {
                pass = pass.sample("source_lf", source).write("target_lf", target);
            }
            let (step, variance) = (filter.step(level), filter.variance_factor(level));
            pass.push(&GradientPush { size: inputs.images.size().into(), step, variance })
                .dispatch([x, y, 1])?;
            std::mem::swap(&mut now, &mut next);
        }
        Ok(now)
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
