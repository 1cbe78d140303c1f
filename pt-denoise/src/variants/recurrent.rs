//! Blurs whose output is the history of the next frame: Zhdanov 2021, "ReBLUR: A Hierarchical Recurrent Denoiser", Ray Tracing Gems II, chapter 49.

use super::{Variant, history, ping, pong, writing};
use crate::DenoiseParams;
use crate::images::{HISTORY_HF, HISTORY_SPEC, PING_HF, PING_SPEC, PONG_HF, PONG_SPEC};
use crate::passes::{Blur, Changes, Form, RecurrentBlur, Temporal};
use pt_core::{Device, Frame, Result, SplitLight, StageInputs, StageIo};

pub(super) struct Recurrent {
    blur: RecurrentBlur,
    temporal: Temporal,
}

impl Recurrent {
    pub(super) fn io(params: &DenoiseParams) -> Vec<StageIo> {
        const TARGETS: StageIo =
            writing("denoise recurrent", &[PING_HF, PING_SPEC, PONG_HF, PONG_SPEC, HISTORY_HF, HISTORY_SPEC]);
        vec![
            TARGETS,
            RecurrentBlur::BEFORE,
            Temporal::io(Form::Filtered, &params.temporal),
            RecurrentBlur::IO,
        ]
    }

    pub(super) fn new(device: &Device, params: &DenoiseParams) -> Result<Self> {
        Ok(Self {
            blur: RecurrentBlur::new(device)?,
            temporal: Temporal::new(device, Form::Filtered, params)?,
        })
    }
}

impl Variant for Recurrent {
    fn record<'a>(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'a>,
        _changes: Option<Changes<'_>>,
        params: &DenoiseParams,
    ) -> Result<SplitLight<'a>> {
        let images = inputs.images;
        let (history, ping, pong) = (history(images), ping(images), pong(images));
        self.blur.record(frame, inputs, Blur::Before, None, ping, params)?;
        self.temporal.record(frame, inputs, Some(ping), history, None, params)?;
        self.blur.record(frame, inputs, Blur::Fix, Some(history), ping, params)?;
        self.blur.record(frame, inputs, Blur::History, Some(ping), history, params)?;
        self.blur.record(frame, inputs, Blur::After, Some(history), pong, params)?;
        Ok(pong)
    }
}
