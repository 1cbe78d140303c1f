use crate::kernels;
use crate::records::CameraInteriorPush;
use pt_core::frame::Pass;
use pt_core::trace::TraceVariant;
use pt_core::{Buffer, Device, Frame, Kernel, Location, Result, StageInputs, StageIo};
use pt_shaders::records::FEATURE_TRANSMISSION;

/// The solids that the camera is inside of, found anew in every frame: the camera and the solids move.
pub(crate) struct CameraInterior {
    kernel: Kernel,
    /// A list of `interior.glsl` without its indices of refraction.
    solids: Buffer,
}

impl CameraInterior {
    /// It needs no image.
    const IO: StageIo = StageIo::of("camera interior");

    /// `None` for scenes without transmission.
    pub(crate) fn new(device: &Device, variant: TraceVariant) -> Result<Option<Self>> {
        if variant.scene_features & FEATURE_TRANSMISSION == 0 {
            return Ok(None);
        }
        // Back faces bound solids too.
        let constants = variant.unseen().constants();
        let code = &kernels::CAMERA_INTERIOR;
        let kernel = Kernel::trace::<CameraInteriorPush>(device, code, variant.backend, &constants)?;
        let solids = Buffer::new(device, "solids of the camera", 16, Location::Device)?;
        Ok(Some(Self { kernel, solids }))
    }

    pub(crate) fn address(&self) -> u64 {
        self.solids.address()
    }

    pub(crate) fn record(&self, frame: &mut Frame<'_>, inputs: &StageInputs<'_>) -> Result<()> {
        let push = CameraInteriorPush { camera_solids: self.address() };
        let pass = inputs.pass(frame, Self::IO.stage, &self.kernel, &Self::IO);
        pass.streams_written(&self.solids).push(&push).dispatch([1, 1, 1])
    }

    /// Declares that the pass reads the list.
    pub(crate) fn bind<'f, 'r>(&self, pass: Pass<'f, 'r>) -> Pass<'f, 'r> {
        pass.addresses(&self.solids)
    }
}
