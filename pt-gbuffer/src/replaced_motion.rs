use crate::records::ReplacedMotionPush;
use crate::{GbufferParams, Jitter, frame_jitter, kernels};
use pt_core::trace::TraceVariant;
use pt_core::{Device, Frame, Kernel, Result, StageInputs, StageIo};
use pt_shaders::channels::{BARYCENTRICS, MOTION, RNG_SEED, SHADING_POSITION, VIEW_DIRECTION, VISIBILITY};

/// The motion of surfaces that [`crate::ReflectRefract`] has found by way of curved mirrors or through glass: where the last frame shows the same
/// point. A stage of its own, absent unless [`GbufferParams::replaced_motion`] asks for it.
pub struct ReplacedMotion {
    kernel: Kernel,
}

impl ReplacedMotion {
    /// The images that the stage accesses.
    pub const IO: StageIo = StageIo {
        reads: &[VISIBILITY, BARYCENTRICS, VIEW_DIRECTION],
        reads_previous: &[RNG_SEED, VISIBILITY, SHADING_POSITION],
        updates: &[MOTION],
        ..StageIo::of("replaced motion")
    };

    /// Compiles the kernel.
    ///
    /// # Errors
    /// When the device refuses it.
    pub fn new(device: &Device, variant: TraceVariant) -> Result<Self> {
        let constants = [
            ("scene_features", variant.scene_features.into()),
            ("random_source", variant.random.code().into()),
        ];
        let kernel = Kernel::compute::<ReplacedMotionPush>(device, &kernels::REPLACED_MOTION, &constants)?;
        Self::IO.check([&kernel])?;
        Ok(Self { kernel })
    }

    /// Records the pass behind those of reflection and refraction. Without a last frame there is none.
    ///
    /// # Errors
    /// When the pass does not fit into the frame.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        params: &GbufferParams,
    ) -> Result<()> {
        let Some(last) = frame.index().checked_sub(1).filter(|_| inputs.images.has_history()) else {
            return Ok(());
        };
        let push = ReplacedMotionPush {
            jitter: frame_jitter(params.jitter, frame.index()).into(),
            jitter_prev: frame_jitter(params.jitter, last).into(),
            jitter_per_pixel: u32::from(params.jitter == Jitter::Pixel),
            pad: 0,
        };
        let pass = inputs.pass(frame, Self::IO.stage, &self.kernel, &Self::IO);
        pass.touches_part().push(&push).dispatch(inputs.split_threads())
    }
}
