//! What the kernels that trace rays through a scene are made for.

use crate::backend::TraceBackend;
use crate::kernel::Constant;
use crate::random::RandomSource;

/// What the kernels of the stages that need a scene are made for. Another value needs other kernels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TraceVariant {
    /// Trace backend, never `Auto`.
    pub backend: TraceBackend,
    /// Where random numbers come from.
    pub random: RandomSource,
    /// `FEATURE_*` bits of what the scene has: kernels leave out the code for the rest.
    pub scene_features: u32,
}

impl TraceVariant {
    /// Its specialisation constants (scene.glsl, blue_noise.glsl).
    pub fn constants(self) -> [(&'static str, Constant); 2] {
        [("scene_features", self.scene_features.into()), ("random_source", self.random.code().into())]
    }
}
