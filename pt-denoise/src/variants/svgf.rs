//! Spatiotemporal variance-guided filtering: Schied et al. 2017; with gradients its adaptive form: Schied, Peters and Dachsbacher 2018.

use super::{Variant, history, levels, ping, writing};
use crate::DenoiseParams;
use crate::images::{HISTORY_HF, HISTORY_SPEC, LEVELS2_HF, LEVELS2_SPEC, PING_HF, PING_SPEC};
use crate::passes::{Atrous, AtrousTargets, Changes, Form, Temporal, Variance};
use crate::records::HistoryFormat;
use pt_core::{Device, Frame, Result, SplitLight, StageInputs, StageIo};

pub(super) struct Svgf {
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
        const TARGETS: StageIo = writing("denoise a-trous", &[HISTORY_HF, HISTORY_SPEC, PING_HF, PING_SPEC]);
        const HALF_TARGETS: StageIo =
            writing("denoise a-trous", &[HISTORY_HF, HISTORY_SPEC, LEVELS2_HF, LEVELS2_SPEC]);
        const LAST: StageIo = writing("denoise a-trous", &[PING_HF, PING_SPEC]);
        let temporal = Temporal::io(Self::form(adaptive), &params.temporal);
        let [level, between] = Atrous::IO;
        let [guide, variance] = Variance::TEMPORAL_IO;
        match params.histories {
            HistoryFormat::Full => vec![TARGETS, temporal, guide, variance, level, between],
            HistoryFormat::Half => vec![HALF_TARGETS, temporal, guide, variance, LAST, level, between],
        }
    }

    pub(super) fn new(device: &Device, params: &DenoiseParams, adaptive: bool) -> Result<Self> {
        Ok(Self {
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
        changes: Option<Changes<'_>>,
        params: &DenoiseParams,
    ) -> Result<SplitLight<'a>> {
        let images = inputs.images;
        let (history, ping) = (history(images), ping(images));
        // What is accumulated has the format of the history.
        let accumulated = match (params.atrous.feedback, params.histories) {
            (false, _) => history,
            (true, HistoryFormat::Full) => ping,
            (true, HistoryFormat::Half) => levels(images),
        };
        self.temporal.record(frame, inputs, None, accumulated, changes, params)?;
        self.variance.record(frame, inputs, accumulated, params)?;
        let targets = AtrousTargets { first: params.atrous.feedback.then_some(history), last: ping };
        self.atrous.record(frame, inputs, accumulated, targets, &params.atrous)
    }
}
