use crate::records::DirectPush;
use pt_core::trace::TraceVariant;
use pt_core::{Device, Frame, Kernel, Result, StageInputs, StageIo, knobs};
use pt_shaders::channels;
use pt_shaders::records::{KIND_EMISSIVE, KIND_ENVIRONMENT, KIND_POSITIONAL, KIND_SUN, MASK_OPAQUE};

knobs! {
    /// Knobs of direct lighting. A kind of light that is off is not sampled, its light is missing.
    pub struct DirectParams {
        /// Whether directional lights give light.
        pub sun: bool = true;
        /// Whether point and spot lights give light.
        pub positional: bool = true;
        /// Whether emissive triangles give light.
        pub emissive: bool = true;
        /// Whether the environment gives light.
        pub environment: bool = true;
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
    /// The images that the stage accesses.
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

    /// Compiles the kernel.
    pub fn new(device: &Device, variant: TraceVariant) -> Result<Self> {
        let kernel = Kernel::trace::<DirectPush>(
            device,
            &crate::kernels::DIRECT,
            variant.backend,
            &variant.constants(),
        )?;
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
