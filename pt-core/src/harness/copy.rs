//! The device's copy bandwidth.

use super::{WARM_UP, measure};
use crate::device::Device;
use crate::error::Result;
use crate::image::Image;
use crate::kernel::Kernel;
use pt_shaders::channels::Format;

/// 10^9 bytes a second that a kernel reads and writes when it copies an image of half floats (8 bytes a texel) of `size`: what
/// kernels are measured against that do little else. The median over `frames`.
///
/// # Errors
/// When the device fails.
pub fn copy_bandwidth(device: &Device, size: [u32; 2], frames: u32) -> Result<f64> {
    let kernel = Kernel::compute::<()>(device, &crate::kernels::COPY, &[])?;
    let image = |name| Image::new(device, name, Format::Rgba16F, size);
    let (source, target) = (image("copy_source")?, image("copy_target")?);
    let times = measure(device, size, WARM_UP, frames, |frame| {
        frame
            .pass("copy", &kernel)
            .sample("source", &source)
            .write("target", &target)
            .dispatch([size[0], size[1], 1])
    })?;
    Ok(times.passes[0].gb_per_s().unwrap_or(0.0))
}
