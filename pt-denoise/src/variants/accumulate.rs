//! Temporal accumulation alone.

use super::{Variant, history, writing};
use crate::DenoiseParams;
use crate::images::{HISTORY_HF, HISTORY_SPEC};
use crate::passes::{Changes, Form, Temporal};
use pt_core::{Device, Frame, Result, SplitLight, StageInputs, StageIo};

pub(super) struct Accumulate {
    temporal: Temporal,
}

impl Accumulate {
    pub(super) fn io(params: &DenoiseParams) -> Vec<StageIo> {
        vec![
            writing("denoise temporal", &[HISTORY_HF, HISTORY_SPEC]),
            Temporal::io(Form::Plain, &params.temporal),
        ]
    }

    pub(super) fn new(device: &Device, params: &DenoiseParams) -> Result<Self> {
        Ok(Self { temporal: Temporal::new(device, Form::Plain, params)? })
    }
}

impl Variant for Accumulate {
    fn record<'a>(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'a>,
        _changes: Option<Changes<'_>>,
        params: &DenoiseParams,
    ) -> Result<SplitLight<'a>> {
        let history = history(inputs.images);
        self.temporal.record(frame, inputs, None, history, None, params)?;
        Ok(history)
    }
}
