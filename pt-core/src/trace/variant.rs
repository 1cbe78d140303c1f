//! What the kernels that trace rays through a scene are made for.

use crate::backend::TraceBackend;
use crate::kernel::Constant;
use crate::random::RandomSource;
use pt_shaders::records::Culling;

/// What the kernels of the stages that need a scene are made for. Another value needs other kernels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TraceVariant {
    /// Trace backend, never `Auto`.
    pub backend: TraceBackend,
    /// Where random numbers come from.
    pub random: RandomSource,
    /// Which rays go through back faces; the mask of a ray decides too.
    pub culling: Culling,
    /// `FEATURE_*` bits of what the scene has: kernels leave out the code for the rest.
    pub scene_features: u32,
}

impl TraceVariant {
    /// For kernels none of whose rays the camera sees along: without the test of what only such rays go through.
    pub fn unseen(self) -> Self {
        Self { culling: self.culling.unseen(), ..self }
    }

    /// Its specialisation constants (scene.glsl, blue_noise.glsl, trace.glsl).
    pub fn constants(self) -> [(&'static str, Constant); 3] {
        [
            ("scene_features", self.scene_features.into()),
            ("random_source", self.random.code().into()),
            ("culling", self.culling.code().into()),
        ]
    }
}
