//! Replaces what a stage has written by other radiance, for example by ground truth.

use crate::device::Device;
use crate::error::Result;
use crate::frame::Frame;
use crate::image::Image;
use crate::kernel::Kernel;
use pt_shaders::channels::Format;

/// A pass that replaces the radiance of an image and keeps its alpha.
pub struct Substitute {
    kernel: Kernel,
}

impl Substitute {
    /// For targets of four floats, or half floats.
    ///
    /// # Errors
    /// When the device refuses the kernel.
    pub fn new(device: &Device, target: Format) -> Result<Self> {
        let code = if target == Format::Rgba16F {
            &crate::kernels::SUBSTITUTE_HALF
        } else {
            &crate::kernels::SUBSTITUTE
        };
        Ok(Self { kernel: Kernel::compute::<()>(device, code, &[])? })
    }

    /// Adds its pass to the frame. The images have one size.
    ///
    /// # Errors
    /// When the pass does not fit into the frame, or the target has another format.
    pub fn record(&self, frame: &mut Frame<'_>, name: &str, source: &Image, target: &Image) -> Result<()> {
        let [width, height] = target.extent();
        frame
            .pass(name, &self.kernel)
            .sample("source", source)
            .update("target", target)
            .dispatch([width, height, 1])
    }
}
