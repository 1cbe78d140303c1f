//! Push constants that several passes share.

use crate::DenoiseParams;
use crate::records::TemporalPush;
use pt_core::ChannelImages;

/// Push constants of all passes that read the last frame.
pub(super) fn push(params: &DenoiseParams, images: &ChannelImages) -> TemporalPush {
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
        max_length: MAX_LENGTH,
        reset: (!images.has_history()).into(),
    }
}

/// Greatest length of a history, frames. Larger than the inverse of any sensible least weight; fp32 holds it exactly.
pub(crate) const MAX_LENGTH: u32 = 4096;
