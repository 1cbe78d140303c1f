//! Temporal accumulation.

use super::declared;
use super::gradients::Changes;
use super::push::push;
use crate::DenoiseParams;
use crate::images::{HISTORY_HF, HISTORY_SPEC, MOMENTS, SURFACE};
use crate::kernels;
use crate::records::{GradientPixel, SpecularMotion, TemporalPush};
use pt_core::{Device, Frame, Kernel, Result, SplitLight, StageInputs, StageIo, knobs};
use pt_shaders::ShaderCode;
use pt_shaders::channels::COLOR_SPEC;

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
        /// A sample of indirect diffuse light is limited in the same way, by its luma, and what exceeds the limit is lost; none is no limit.
        pub firefly_lf: Option<f32> = None, in 1.0..=1e6;
        /// What the history of specular light follows; mirror images need a pinhole or thin-lens camera, and pixels that show a surface directly.
        pub specular: SpecularMotion = SpecularMotion::Surface, source "Zhdanov 2021, chapter 49" => structural;
        /// Where the history of specular light follows the surface, it is forgotten as far as the reflection has turned, in units of the lobe alpha =
        /// roughness^2; none keeps it.
        pub parallax: Option<f32> = None, in 0.01..=100.0, unit "radians", source "Zhdanov 2021, chapter 49" => structural;
    }
}

impl TemporalParams {
    /// Cosine of the greatest angle between normals.
    pub(crate) fn normal_cosine(&self) -> f32 {
        self.normal.to_radians().cos()
    }

    /// Whether the kernel needs to know where mirror images were.
    pub(crate) fn follows_images(&self) -> bool {
        self.specular != SpecularMotion::Surface || self.parallax.is_some()
    }

    /// Limit of a sample over what is expected, as kernels take it.
    pub(crate) fn firefly_limit(&self) -> f32 {
        self.firefly.unwrap_or(0.0)
    }
}

/// Which light is accumulated, and how its history is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    /// Of the lighting stages.
    Plain,
    /// The same; history follows changes of the light.
    Adaptive,
    /// Of the pass before, with hit distances in alpha.
    Filtered,
}

/// This frame's light into the history along the motion of the surfaces.
pub(crate) struct Temporal {
    kernel: Kernel,
    io: StageIo,
}

impl Temporal {
    /// The images that it accesses besides its target.
    const PLAIN: StageIo = StageIo {
        reads: with_surfaces![COLOR_HF, COLOR_SPEC],
        reads_previous: with_surfaces_before![MOMENTS, HISTORY_HF, HISTORY_SPEC],
        writes: &[SURFACE, MOMENTS],
        ..StageIo::of("denoise temporal")
    };
    const ADAPTIVE: StageIo =
        StageIo { reads: with_surfaces![COLOR_HF, COLOR_SPEC; GRADIENT_SAMPLE], ..Self::PLAIN };
    const FILTERED: StageIo = StageIo { reads: with_surfaces![], ..Self::PLAIN };
    /// The same where specular history follows mirror images.
    const VIRTUAL: StageIo = StageIo {
        reads: with_surfaces![COLOR_HF, COLOR_SPEC; METALLIC_ROUGHNESS, BOUNCE_THROUGHPUT],
        reads_previous: with_surfaces_before![MOMENTS, HISTORY_HF, HISTORY_SPEC, COLOR_SPEC],
        ..Self::PLAIN
    };
    const VIRTUAL_ADAPTIVE: StageIo = StageIo {
        reads: with_surfaces![COLOR_HF, COLOR_SPEC; METALLIC_ROUGHNESS, BOUNCE_THROUGHPUT, GRADIENT_SAMPLE],
        ..Self::VIRTUAL
    };

    fn code_and_io(form: Form, params: &TemporalParams) -> (&'static ShaderCode, StageIo) {
        match (form, params.follows_images()) {
            (Form::Plain, false) => (&kernels::TEMPORAL, Self::PLAIN),
            (Form::Adaptive, false) => (&kernels::TEMPORAL_ANTILAG, Self::ADAPTIVE),
            (Form::Plain, true) => (&kernels::TEMPORAL_VIRTUAL, Self::VIRTUAL),
            (Form::Adaptive, true) => (&kernels::TEMPORAL_VIRTUAL_ANTILAG, Self::VIRTUAL_ADAPTIVE),
            (Form::Filtered, _) => (&kernels::TEMPORAL_RECURRENT, Self::FILTERED),
        }
    }

    /// Its declaration.
    pub(crate) fn io(form: Form, params: &TemporalParams) -> StageIo {
        Self::code_and_io(form, params).1
    }

    /// Creates the kernel.
    pub(crate) fn new(device: &Device, form: Form, params: &DenoiseParams) -> Result<Self> {
        let (code, io) = Self::code_and_io(form, &params.temporal);
        let constants: &[_] = if form == Form::Adaptive { &[params.antilag.stratum_constant()] } else { &[] };
        Ok(Self { kernel: declared::<TemporalPush>(device, code, &io, constants)?, io })
    }

    /// Adds its pass to the frame. `target` has the format of the history; its alpha is the variance of the luminance that follows from the moments, or the hit distance of filtered light. `changes`: of a
    /// kernel that follows changes of the light; `source`: of one that takes filtered light.
    pub(crate) fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        source: Option<SplitLight<'_>>,
        target: SplitLight<'_>,
        changes: Option<Changes<'_>>,
        params: &DenoiseParams,
    ) -> Result<()> {
        let mut pass = inputs
            .pass(frame, "denoise temporal", &self.kernel, &self.io)
            .write("im_history_hf_target", target.hf)
            .write("im_history_spec_target", target.spec);
        if let Some(source) = source {
            pass = pass.sample("source_hf", source.hf).sample("source_spec", source.spec);
        }
        if let Some(changes) = changes {
            pass = pass
                .sample("gradients", changes.pixels)
                .sample("sums_hf", changes.sums_hf)
                .sample("sums_spec", changes.sums_spec);
        }
        let mut push = push(params, inputs);
        // Pixels without the brightest of the last frame are too dark in the history: a difference says nothing.
        if params.antilag.pixel == GradientPixel::Brightest {
            push.gate_noise = f32::MAX;
        }
        pass.push(&push).dispatch(inputs.flat_threads())
    }
}
