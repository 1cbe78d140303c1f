//! Running mean over frames.

use crate::images::ACCUMULATE_RESIDUAL;
use crate::kernels;
use crate::records::AccumulatePush;
use pt_core::{Device, Frame, Kernel, Result, StageInputs, StageIo};
use pt_shaders::channels::{ACCUMULATED, FLAT_COLOR};

/// Mean of `flat_color` over the frames since the last reset of history, into `accumulated`.
///
/// The mean is carried in about 48 bits (see `accumulate.comp`), so that the stored one stays within 2e-7 of the exact
/// mean, also after 1e5 frames. `accumulated.a` counts the frames of each pixel: a frame in which the pixel is not finite is
/// left out of its mean.
pub struct Accumulate {
    kernel: Kernel,
}

impl Accumulate {
    /// The images that it accesses.
    pub const IO: StageIo = StageIo {
        reads: &[FLAT_COLOR],
        updates: &[ACCUMULATED, ACCUMULATE_RESIDUAL],
        ..StageIo::of("accumulate")
    };

    /// Creates the kernel.
    ///
    /// # Errors
    /// When the device refuses.
    pub fn new(device: &Device) -> Result<Self> {
        let kernel = Kernel::compute::<AccumulatePush>(device, &kernels::ACCUMULATE, &[])?;
        Self::IO.check([&kernel])?;
        Ok(Self { kernel })
    }

    /// Adds its pass to the frame. A frame without history starts over.
    ///
    /// # Errors
    /// When the pass does not fit into the frame.
    pub fn record(&self, frame: &mut Frame<'_>, inputs: &StageInputs<'_>) -> Result<()> {
        inputs
            .pass(frame, "accumulate", &self.kernel, &Self::IO)
            .push(&AccumulatePush { reset: u32::from(!inputs.images.has_history()) })
            .dispatch(inputs.flat_threads())
    }
}
