//! The a-trous filter over each frame by itself.

use super::{Variant, ping, pong, writing};
use crate::DenoiseParams;
use crate::images::{PING_HF, PING_SPEC, PONG_HF, PONG_SPEC};
use crate::passes::{Atrous, AtrousTargets, Changes, Variance};
use pt_core::{Device, Frame, Result, SplitLight, StageInputs, StageIo};

pub(super) struct AtrousAlone {
    variance: Variance,
    atrous: Atrous,
}

impl AtrousAlone {
    pub(super) fn io() -> Vec<StageIo> {
        const TARGETS: StageIo = writing("denoise a-trous", &[PING_HF, PING_SPEC, PONG_HF, PONG_SPEC]);
        let [level, between] = Atrous::IO;
        let [guide, variance] = Variance::SPATIAL_IO;
        vec![TARGETS, guide, variance, level, between]
    }

    pub(super) fn new(device: &Device, params: &DenoiseParams) -> Result<Self> {
        Ok(Self { variance: Variance::spatial(device)?, atrous: Atrous::new(device, &params.atrous)? })
    }
}

impl Variant for AtrousAlone {
    fn record<'a>(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'a>,
        _changes: Option<Changes<'_>>,
        params: &DenoiseParams,
    ) -> Result<SplitLight<'a>> {
        let (ping, pong) = (ping(inputs.images), pong(inputs.images));
        self.variance.record(frame, inputs, ping, params)?;
        self.atrous.record(frame, inputs, ping, AtrousTargets { first: None, last: pong }, &params.atrous)
    }
}
