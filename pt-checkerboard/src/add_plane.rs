use crate::kernels;
use crate::records::AddPlanePush;
use pt_core::{ChannelImages, Device, Frame, Kernel, Result, StageInputs, StageIo};
use pt_shaders::channels::{FLAT_COLOR, FLAT_MOTION};

/// Adds the flat frames of planes (`gbuffer.decomposition=planes`) to that of plane 0.
pub struct AddPlane {
    kernel: Kernel,
}

impl AddPlane {
    /// The images of plane 0 that it accesses. Those of the other plane are the same channels of other images.
    pub const IO: StageIo =
        StageIo { updates: &[FLAT_COLOR], writes: &[FLAT_MOTION], ..StageIo::of("add plane") };

    /// Creates the kernel.
    ///
    /// # Errors
    /// When the device refuses it.
    pub fn new(device: &Device) -> Result<Self> {
        let kernel = Kernel::compute::<AddPlanePush>(device, &kernels::ADD_PLANE, &[])?;
        Self::IO.check([&kernel])?;
        Ok(Self { kernel })
    }

    /// Adds its pass to the frame: after it, the flat frame of `inputs` has the light of `plane` too.
    ///
    /// # Errors
    /// When the pass does not fit into the frame.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        plane: &ChannelImages,
    ) -> Result<()> {
        inputs
            .pass(frame, Self::IO.stage, &self.kernel, &Self::IO)
            .touches_part()
            .read("plane_color", plane.current(FLAT_COLOR))
            .read("plane_motion", plane.current(FLAT_MOTION))
            .push(&AddPlanePush { size: inputs.images.size().into() })
            .dispatch(inputs.flat_threads())
    }
}
