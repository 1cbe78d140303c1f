use crate::records::EffectsPush;
use crate::{GbufferParams, Jitter, frame_jitter, images, kernels};
use pt_core::trace::TraceVariant;
use pt_core::{Device, Frame, Kernel, Result, StageInputs, StageIo};
use pt_shaders::channels::{FLAT_COLOR, FLAT_MOTION, RNG_SEED, SHADING_POSITION, THROUGHPUT, TRANSPARENT};
use pt_shaders::records::FEATURE_EFFECTS;

/// The effects between the camera and the surfaces that its rays find, in two passes that only frames of scenes with effects have. The first one
/// follows [`crate::PrimaryRays`]; [`crate::ReflectRefract`] blends those on its rays itself. The second one follows the interleave, so that
/// anti-aliasing reprojects what covers a surface by its own motion, and the denoiser the surface by that of the surface.
pub struct Effects {
    blend: Kernel,
    motion: Kernel,
}

impl Effects {
    /// The images that the blending accesses.
    pub const BLEND: StageIo = StageIo {
        reads: &[RNG_SEED, SHADING_POSITION],
        updates: &[THROUGHPUT, TRANSPARENT],
        writes: &[images::EFFECTS_MOTION],
        ..StageIo::of("effects")
    };

    /// The images that the choice of the motion accesses; it writes only where an effect decides.
    pub const MOTION: StageIo = StageIo {
        reads: &[images::EFFECTS_MOTION, FLAT_COLOR],
        writes: &[FLAT_MOTION],
        ..StageIo::of("effects motion")
    };

    /// Whether a frame of a scene with these `FEATURE_*` bits has the passes.
    pub fn are_in(scene_features: u32) -> bool {
        scene_features & FEATURE_EFFECTS != 0
    }

    /// Compiles the kernels. `effect_layers`: [`GbufferParams::effect_layers`].
    ///
    /// # Errors
    /// When the device refuses them.
    pub fn new(device: &Device, variant: TraceVariant, effect_layers: u32) -> Result<Self> {
        let constants = [
            ("scene_features", variant.scene_features.into()),
            ("random_source", variant.random.code().into()),
            ("effect_layers", effect_layers.into()),
        ];
        let blend = Kernel::compute::<EffectsPush>(device, &kernels::EFFECTS, &constants)?;
        let motion = Kernel::compute::<()>(device, &kernels::EFFECTS_MOTION, &[])?;
        Self::BLEND.check([&blend])?;
        Self::MOTION.check([&motion])?;
        Ok(Self { blend, motion })
    }

    /// Records the blending, after the primary rays and with their parameters.
    ///
    /// # Errors
    /// When the pass does not fit into the frame.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        params: &GbufferParams,
    ) -> Result<()> {
        let push = EffectsPush {
            jitter: frame_jitter(params.jitter, frame.index()).into(),
            jitter_per_pixel: u32::from(params.jitter == Jitter::Pixel),
            pad: 0,
        };
        let pass = inputs.pass(frame, Self::BLEND.stage, &self.blend, &Self::BLEND);
        pass.push(&push).dispatch(inputs.split_threads())
    }

    /// Records the choice of the motion, after the interleave.
    ///
    /// # Errors
    /// When the pass does not fit into the frame.
    pub fn record_motion(&self, frame: &mut Frame<'_>, inputs: &StageInputs<'_>) -> Result<()> {
        let pass = inputs.pass(frame, Self::MOTION.stage, &self.motion, &Self::MOTION);
        pass.touches_part().dispatch(inputs.flat_threads())
    }
}
