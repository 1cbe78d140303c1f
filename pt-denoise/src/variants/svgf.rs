//! Spatiotemporal variance-guided filtering: Schied et al. 2017; with gradients its adaptive form: Schied, Peters and Dachsbacher 2018.

use super::{Variant, history, ping, pong, writing};
use crate::DenoiseParams;
use crate::images::{HISTORY_HF, HISTORY_SPEC, PING_HF, PING_SPEC, PONG_HF, PONG_SPEC};
use crate::passes::{AntilagDirect, Atrous, Form, Temporal, Variance};
use pt_core::{Device, Frame, Result, SplitLight, StageInputs, StageIo};

pub(super) struct Svgf {
    /// Of the adaptive form.
    gradients: Option<AntilagDirect>,
    temporal: Temporal,
    variance: Variance,
    atrous: Atrous,
}

impl Svgf {
    const fn form(adaptive: bool) -> Form {
        if adaptive { Form::Adaptive } else { Form::Plain }
    }

    /// `adaptive`: of the adaptive form.
    pub(super) fn io(params: &DenoiseParams, adaptive: bool) -> Vec<StageIo> {
        const TARGETS: StageIo =
            writing("denoise a-trous", &[HISTORY_HF, HISTORY_SPEC, PING_HF, PING_SPEC, PONG_HF, PONG_SPEC]);
        let mut all = if adaptive { AntilagDirect::IO.to_vec() } else { Vec::new() };
        let temporal = Temporal::io(Self::form(adaptive), &params.temporal);
        all.extend([temporal, Variance::TEMPORAL_IO, Atrous::IO, TARGETS]);
        all
    }

    pub(super) fn new(device: &Device, params: &DenoiseParams, adaptive: bool) -> Result<Self> {
        Ok(Self {
            gradients: adaptive.then(|| AntilagDirect::new(device, &params.antilag)).transpose()?,
            temporal: Temporal::new(device, Self::form(adaptive), params)?,
            variance: Variance::temporal(device)?,
            atrous: Atrous::new(device, &params.atrous)?,
        })
    }
}

impl Variant for Svgf {
    fn record<'a>(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'a>,
        params: &DenoiseParams,
    ) -> Result<SplitLight<'a>> {
        let images = inputs.images;
        let (history, ping, pong) = (history(images), ping(images), pong(images));
        let accumulated = if params.atrous.feedback { ping } else { history };
        let gradients = self.gradients.as_ref().map(|g| g.record(frame, inputs, params)).transpose()?;
        self.temporal.record(frame, inputs, None, accumulated, gradients, params)?;
        self.variance.record(frame, inputs, Some(accumulated), pong, params)?;
        let targets: &[_] = if params.atrous.feedback { &[history, ping, pong] } else { &[ping, pong] };
        self.atrous.record(frame, inputs, pong, targets, &params.atrous)
    }
}
