//! Spatiotemporal variance-guided filtering: Schied et al. 2017; with gradients its adaptive form: Schied, Peters and Dachsbacher 2018.

use super::{Variant, history, ping, pong, writing};
use crate::DenoiseParams;
use crate::images::{HISTORY_HF, HISTORY_SPEC, PING_HF, PING_SPEC, PONG_HF, PONG_SPEC};
use crate::passes::{AntilagDirect, Atrous, Temporal, Variance};
use pt_core::{Device, Frame, Result, SplitLight, StageInputs, StageIo};

pub(super) struct Svgf {
    /// Of the adaptive form.
    gradients: Option<AntilagDirect>,
    temporal: Temporal,
    variance: Variance,
    atrous: Atrous,
}

impl Svgf {
    pub(super) const IO: &[StageIo] = &[
        Temporal::IO,
        Variance::TEMPORAL_IO,
        Atrous::IO,
        writing("denoise a-trous", &[HISTORY_HF, HISTORY_SPEC, PING_HF, PING_SPEC, PONG_HF, PONG_SPEC]),
    ];

    /// The adaptive form.
    pub(super) const IO_ADAPTIVE: &[StageIo] = &[
        AntilagDirect::IO[0],
        AntilagDirect::IO[1],
        AntilagDirect::IO[2],
        Temporal::IO_ANTILAG,
        Variance::TEMPORAL_IO,
        Atrous::IO,
        writing("denoise a-trous", &[HISTORY_HF, HISTORY_SPEC, PING_HF, PING_SPEC, PONG_HF, PONG_SPEC]),
    ];

    pub(super) fn new(device: &Device, adaptive: bool) -> Result<Self> {
        Ok(Self {
            gradients: adaptive.then(|| AntilagDirect::new(device)).transpose()?,
            temporal: Temporal::new(device, adaptive)?,
            variance: Variance::temporal(device)?,
            atrous: Atrous::new(device)?,
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
        self.temporal.record(frame, inputs, accumulated, gradients, params)?;
        self.variance.record(frame, inputs, Some(accumulated), pong, params)?;
        let targets: &[_] = if params.atrous.feedback { &[history, ping, pong] } else { &[ping, pong] };
        self.atrous.record(frame, inputs, pong, targets, &params.atrous)
    }
}
