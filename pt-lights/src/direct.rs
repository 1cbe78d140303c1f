use crate::records::DirectPush;
use pt_core::settings::{InvalidValue, Validate};
use pt_core::trace::TraceBackend;
use pt_core::{Device, Frame, Kernel, Result, StageInputs, StageIo};
use pt_shaders::channels;
use pt_shaders::records::{
    KIND_EMISSIVE, KIND_ENVIRONMENT, KIND_POSITIONAL, KIND_SUN, MASK_OPAQUE,
};
use serde::{Deserialize, Serialize};

/// Knobs of direct lighting. A kind of light that is off is not sampled, its light is missing.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DirectParams {
    /// Light of directional lights. Default true.
    pub sun: bool,
    /// Light of point and spot lights. Default true.
    pub positional: bool,
    /// Light of emissive triangles. Default true.
    pub emissive: bool,
    /// Light of the environment. Default true.
    pub environment: bool,
}

impl Default for DirectParams {
    fn default() -> Self {
        Self { sun: true, positional: true, emissive: true, environment: true }
    }
}

impl Validate for DirectParams {
    fn validate(&self) -> std::result::Result<(), InvalidValue> {
        Ok(())
    }
}

impl DirectParams {
    /// The kernel's push constants.
    pub fn push(&self) -> DirectPush {
        let bit = |on: bool, kind: u32| if on { kind } else { 0 };
        DirectPush {
            kinds: bit(self.sun, KIND_SUN)
                | bit(self.positional, KIND_POSITIONAL)
                | bit(self.emissive, KIND_EMISSIVE)
                | bit(self.environment, KIND_ENVIRONMENT),
            mask: MASK_OPAQUE,
        }
    }
}

/// The direct lighting stage: one candidate and one shadow ray per pixel for each kind of light.
pub struct DirectLighting {
    kernel: Kernel,
}

impl DirectLighting {
    /// What the stage touches.
    pub const IO: StageIo = StageIo {
        reads: &[
            channels::RNG_SEED,
            channels::BASE_COLOR,
            channels::METALLIC_ROUGHNESS,
            channels::NORMAL,
            channels::VERTEX_NORMAL,
            channels::SHADING_POSITION,
            channels::VIEW_DIRECTION,
        ],
        writes: &[channels::COLOR_HF, channels::COLOR_SPEC],
        ..StageIo::of("direct lighting")
    };

    /// Compiles the kernel for a trace backend.
    pub fn new(device: &Device, backend: TraceBackend) -> Result<Self> {
        let kernel = Kernel::trace::<DirectPush>(device, &crate::kernels::DIRECT, backend)?;
        Self::IO.check([&kernel])?;
        Ok(Self { kernel })
    }

    /// Records the pass. The scene of `inputs` has its lights attached.
    ///
    /// # Errors
    /// When the pass does not fit into the frame.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        params: &DirectParams,
    ) -> Result<()> {
        let pass = inputs.pass(frame, "direct lighting", &self.kernel, &Self::IO);
        pass.push(&params.push()).dispatch(inputs.split_threads())
    }
}
