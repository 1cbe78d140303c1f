//! Blurs whose output is the history of the next frame.

use super::declared;
use super::push::rounding;
use crate::DenoiseParams;
use crate::images::SURFACE;
use crate::kernels;
use crate::records::RecurrentPush;
use pt_core::{Device, Frame, Kernel, Result, SplitLight, StageInputs, StageIo, knobs};
use pt_shaders::ShaderCode;
use pt_shaders::channels::{COLOR_HF, COLOR_SPEC};

knobs! {
    /// Knobs of the recurrent blur; tolerances are those of the a-trous filter.
    pub struct RecurrentParams {
        /// Radius of the blur before accumulation, where light comes from far away.
        pub pre_radius: f32 = 8.0, in 0.0..=128.0, unit "pixels", source "Zhdanov 2021, chapter 49";
        /// Radius of the blur that the history goes through in every frame; with n frames it is divided by sqrt(n).
        pub radius: f32 = 24.0, in 0.0..=128.0, unit "pixels", source "Zhdanov 2021, chapter 49";
        /// Radius of the blur of the picture, which the history does not see; divided as radius.
        pub post_radius: f32 = 12.0, in 0.0..=128.0, unit "pixels", source "Zhdanov 2021, chapter 49";
        /// Shorter histories are replaced by means over wide surroundings.
        pub fix_frames: u32 = 4, in 1..=32, unit "frames", source "Zhdanov 2021, chapter 49";
        /// Radius of these surroundings for a history of one frame.
        pub fix_radius: f32 = 24.0, in 0.0..=128.0, unit "pixels", source "Zhdanov 2021, chapter 49";
    }
}

/// Which of the passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Blur {
    /// Of the light of the lighting stages.
    Before,
    /// Of short histories.
    Fix,
    /// Of the history.
    History,
    /// Of the picture.
    After,
}

/// Kernels of the passes, all of which go from one light to another.
pub(crate) struct RecurrentBlur {
    before: Kernel,
    fix: Kernel,
    blur: Kernel,
    after: Kernel,
}

impl RecurrentBlur {
    /// What the blur before accumulation accesses besides its target.
    pub(crate) const BEFORE: StageIo =
        StageIo { reads: with_guides![COLOR_HF, COLOR_SPEC], ..StageIo::of("denoise recurrent") };
    /// What the other passes access besides source and target.
    pub(crate) const IO: StageIo =
        StageIo { reads: with_guides![SURFACE], ..StageIo::of("denoise recurrent") };

    /// Creates the kernels.
    pub(crate) fn new(device: &Device) -> Result<Self> {
        let kernel = |code: &ShaderCode, io| declared::<RecurrentPush>(device, code, &io, &[]);
        Ok(Self {
            before: kernel(&kernels::RECURRENT_PREBLUR, Self::BEFORE)?,
            fix: kernel(&kernels::HISTORY_FIX, Self::IO)?,
            blur: kernel(&kernels::RECURRENT_BLUR_HISTORY, Self::IO)?,
            after: kernel(&kernels::RECURRENT_BLUR, Self::IO)?,
        })
    }

    /// Adds a pass to the frame; `source`: of all but the first.
    pub(crate) fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        blur: Blur,
        source: Option<SplitLight<'_>>,
        target: SplitLight<'_>,
        params: &DenoiseParams,
    ) -> Result<()> {
        let recurrent = &params.recurrent;
        let (kernel, io, name, radius) = match blur {
            Blur::Before => (&self.before, &Self::BEFORE, "denoise pre-blur", recurrent.pre_radius),
            Blur::Fix => (&self.fix, &Self::IO, "denoise history fix", recurrent.fix_radius),
            Blur::History => (&self.blur, &Self::IO, "denoise blur", recurrent.radius),
            Blur::After => (&self.after, &Self::IO, "denoise post-blur", recurrent.post_radius),
        };
        let push = RecurrentPush {
            size: inputs.images.size().into(),
            radius,
            depth: params.atrous.depth,
            normal: params.atrous.normal,
            lobe: params.atrous.lobe,
            fix_frames: recurrent.fix_frames,
            rounding: rounding(inputs),
        };
        let mut pass = inputs.pass(frame, name, kernel, io);
        if let Some(source) = source {
            pass = pass.sample("source_hf", source.hf).sample("source_spec", source.spec);
        }
        let [hf, spec] = match blur {
            Blur::History => ["im_history_hf_target", "im_history_spec_target"],
            _ => ["target_hf", "target_spec"],
        };
        pass.write(hf, target.hf).write(spec, target.spec).push(&push).dispatch(inputs.flat_threads())
    }
}
