use crate::records::{DirectPush, GlassShadows, PartialMetal};
use pt_core::trace::TraceVariant;
use pt_core::{Device, Frame, Kernel, Result, StageInputs, StageIo, knobs};
use pt_shaders::channels;
use pt_shaders::records::{
    KIND_EMISSIVE, KIND_ENVIRONMENT, KIND_POSITIONAL, KIND_SUN, MASK_OPAQUE, MASK_TRANSMISSIVE,
};

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
        /// What becomes of the light on its way through transmissive surfaces: refraction, and so caustics, are left out in any case.
        pub glass_shadows: GlassShadows = GlassShadows::Tinted;
        /// How materials of metalness between 0 and 1 are shaded.
        pub partial_metal: PartialMetal = PartialMetal::TwoBrdfs, source "glTF 2.0, appendix B.2";
        /// Perceptual roughness up to which a second ray, in a direction that the surface reflects, looks for the environment: sampling the
        /// environment alone does not find narrow lobes.
        pub reflection_roughness: f32 = 0.3, in 0.0..=1.0, source "Veach 1997, section 9.2";
    }
}

impl DirectParams {
    /// The kernel's push constants.
    pub fn push(&self, texture_lod_bias: f32) -> DirectPush {
        let bit = |on: bool, kind: u32| if on { kind } else { 0 };
        DirectPush {
            kinds: bit(self.sun, KIND_SUN)
                | bit(self.positional, KIND_POSITIONAL)
                | bit(self.emissive, KIND_EMISSIVE)
                | bit(self.environment, KIND_ENVIRONMENT),
            mask: match self.glass_shadows {
                GlassShadows::Stopped => MASK_OPAQUE | MASK_TRANSMISSIVE,
                GlassShadows::Tinted | GlassShadows::Passed => MASK_OPAQUE,
            },
            tinted_glass: u32::from(self.glass_shadows == GlassShadows::Tinted),
            mixed: u32::from(self.partial_metal == PartialMetal::MixedParameters),
            reflection_roughness: self.reflection_roughness,
            lod_scale: texture_lod_bias.exp2(),
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
            channels::VISIBILITY,
            channels::BARYCENTRICS,
            channels::THROUGHPUT,
            channels::BOUNCE_THROUGHPUT,
        ],
        writes: &[channels::COLOR_HF, channels::COLOR_SPEC],
        ..StageIo::of("direct lighting")
    };

    /// Compiles the kernel.
    pub fn new(device: &Device, variant: TraceVariant) -> Result<Self> {
        let variant = variant.unseen();
        let kernel = Kernel::trace::<DirectPush>(
            device,
            &crate::kernels::DIRECT,
            variant.backend,
            &variant.constants(),
        )?;
        Self::IO.check([&kernel])?;
        Ok(Self { kernel })
    }

    /// Records the pass. The scene of `inputs` has its lights attached. `texture_lod_bias`: as that of the G-buffer.
    ///
    /// # Errors
    /// When the pass does not fit into the frame.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        params: &DirectParams,
        texture_lod_bias: f32,
    ) -> Result<()> {
        // Only surfaces with lobes are looked up again at the visible triangle.
        let pass = inputs.pass(frame, "direct lighting", &self.kernel, &Self::IO).touches_part();
        pass.push(&params.push(texture_lod_bias)).dispatch(inputs.split_threads())
    }
}
