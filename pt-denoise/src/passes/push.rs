//! Push constants that several passes share.

use crate::DenoiseParams;
use crate::records::TemporalPush;
use pt_core::StageInputs;
use pt_core::frame::Uniforms;
use pt_shaders::glam::UVec2;

/// Push constants of all passes that read the last frame.
pub(super) fn push(params: &DenoiseParams, inputs: &StageInputs<'_>) -> TemporalPush {
    let images = inputs.images;
    let DenoiseParams { temporal, antilag, .. } = params;
    TemporalPush {
        size: images.size().into(),
        alpha_hf: temporal.alpha_hf,
        alpha_spec: temporal.alpha_spec,
        alpha_lf: temporal.alpha_lf,
        alpha_moments: temporal.alpha_moments,
        depth: temporal.depth,
        normal: temporal.normal_cosine(),
        firefly: temporal.firefly_limit(),
        firefly_lf: temporal.firefly_lf.unwrap_or(0.0),
        antilag_hf: antilag.hf,
        antilag_spec: antilag.spec,
        antilag_lf: antilag.lf,
        gate: antilag.gate,
        gate_noise: antilag.gate_noise,
        specular: temporal.specular.code(),
        parallax: temporal.parallax.unwrap_or(0.0),
        max_length: params.histories.max_length(),
        reset: (!images.has_history()).into(),
        rounding: rounding(inputs),
    }
}

/// Frame and seed of the random numbers by which histories are rounded.
pub(super) fn rounding(inputs: &StageInputs<'_>) -> UVec2 {
    let record = inputs.uniforms.and_then(Uniforms::record);
    record.map_or(UVec2::ZERO, |record| UVec2::new(record.frame_index, record.seed))
}
