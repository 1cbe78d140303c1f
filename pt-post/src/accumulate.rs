//! Running mean over frames.

use crate::kernels;
use crate::records::AccumulatePush;
use pt_core::{ChannelImages, Device, Frame, Image, Kernel, Result};
use pt_shaders::channels::{ACCUMULATED, ChannelId, FLAT_COLOR, Format};

/// Mean of `flat_color` over the frames since the last reset, into `accumulated`.
///
/// The mean is carried in about 48 bits (see `accumulate.comp`), so that the stored one stays within 2e-7 of the exact
/// mean, also after 1e5 frames. `accumulated.a` counts the frames of each pixel: a frame in which the pixel is not finite is
/// left out of its mean.
pub struct Accumulate {
    kernel: Kernel,
    residual: Image,
}

impl Accumulate {
    /// Channels that it reads.
    pub const READS: &[ChannelId] = &[FLAT_COLOR, ACCUMULATED];
    /// Channels that it writes.
    pub const WRITES: &[ChannelId] = &[ACCUMULATED];

    /// Creates the kernel and the low part of the mean for flat frames of `size` pixels.
    ///
    /// # Errors
    /// When the device refuses, or has not the memory (16 bytes a pixel).
    pub fn new(device: &Device, size: [u32; 2]) -> Result<Self> {
        Ok(Self {
            kernel: Kernel::compute::<AccumulatePush>(device, &kernels::ACCUMULATE, &[])?,
            residual: Image::new(device, "accumulate residual", Format::Rgba32F, size)?,
        })
    }

    /// Adds its pass to the frame. `reset` starts over with this frame: the first one, or after a change of the view.
    ///
    /// # Errors
    /// When the pass does not fit into the frame.
    pub fn record(&self, frame: &mut Frame<'_>, images: &ChannelImages, reset: bool) -> Result<()> {
        let [width, height] = images.size();
        frame
            .pass("accumulate", &self.kernel)
            .reads(images, &[FLAT_COLOR])
            .updates(images, &[ACCUMULATED])
            .update("residual", &self.residual)
            .push(&AccumulatePush { reset: u32::from(reset) })
            .dispatch([width, height, 1])
    }
}
