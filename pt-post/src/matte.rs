//! Alpha of frames with a transparent background.

use crate::images::{COVERAGE, MATTE};
use crate::kernels;
use crate::records::MattePush;
use pt_core::{Device, Frame, Image, Kernel, Result, StageInputs, StageIo};
use pt_shaders::channels::FLAT_COLOR;

/// Radiance of the surfaces alone, and the share of the frames since the last reset of history that met one, into `post.matte`.
pub struct Matte {
    kernel: Kernel,
}

impl Matte {
    /// The images that it accesses besides the resolved frame.
    pub const IO: StageIo =
        StageIo { reads: &[FLAT_COLOR], writes: &[MATTE], updates: &[COVERAGE], ..StageIo::of("matte") };

    /// Creates the kernel.
    ///
    /// # Errors
    /// When the device refuses.
    pub fn new(device: &Device) -> Result<Self> {
        let kernel = Kernel::compute::<MattePush>(device, &kernels::MATTE, &[])?;
        Self::IO.check([&kernel])?;
        Ok(Self { kernel })
    }

    /// Adds its pass to the frame. `resolved` is the flat frame, or with `accumulates` the mean of the frames; the alpha is that of the same
    /// frames.
    ///
    /// # Errors
    /// When the pass does not fit into the frame.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        resolved: &Image,
        accumulates: bool,
    ) -> Result<()> {
        let reset = !(accumulates && inputs.images.has_history());
        inputs
            .pass(frame, "matte", &self.kernel, &Self::IO)
            .sample("resolved", resolved)
            .push(&MattePush { reset: reset.into() })
            .dispatch(inputs.flat_threads())
    }
}
