//! The device's copy bandwidth.

use super::{PassRow, WARM_UP, measure};
use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::Result;
use crate::image::Image;
use crate::kernel::Kernel;
use pt_shaders::channels::Format;

/// How fast a device copies.
#[derive(Clone, Debug, serde::Serialize)]
pub struct CopyBandwidth {
    /// 10^9 bytes read and written a second.
    pub gb_per_s: f64,
    /// The copy that was the fastest.
    pub fastest: String,
}

/// Measures the bandwidth that memory-bound kernels are compared with: the fastest way to copy the bytes of a half-float image of `size`,
/// by kernels (8 bytes per thread between images, 16 between buffers) or by the driver. Medians over `frames`.
///
/// # Errors
/// When the device fails.
pub fn copy_bandwidth(device: &Device, size: [u32; 2], frames: u32) -> Result<CopyBandwidth> {
    let texels = Kernel::compute::<()>(device, &crate::kernels::COPY, &[])?;
    let words = Kernel::compute::<()>(device, &crate::kernels::COPY_WORDS, &[])?;
    let image = |name| Image::new(device, name, Format::Rgba16F, size);
    let (source, target) = (image("copy source")?, image("copy target")?);
    let threads = source.bytes().div_ceil(16);
    let buffer = |name| Buffer::new(device, name, 16 * threads, Location::Device);
    let (source_words, target_words) = (buffer("copy source words")?, buffer("copy target words")?);
    let times = measure(device, size, WARM_UP, frames, |frame| {
        frame
            .pass("kernel, 8 bytes a thread", &texels)
            .sample("source", &source)
            .write("target", &target)
            .dispatch([size[0], size[1], 1])?;
        frame
            .pass("kernel, 16 bytes a thread", &words)
            .read("source", &source_words)
            .write("target", &target_words)
            .dispatch([threads as u32, 1, 1])?;
        frame.copy_image("driver, images", &source, &target)?;
        frame.copy_buffer("driver, buffers", &source_words, &target_words)
    })?;
    let rate = |row: &PassRow| row.gb_per_s().unwrap_or(0.0);
    let fastest = times.passes.iter().max_by(|a, b| rate(a).total_cmp(&rate(b)));
    Ok(fastest.map_or(CopyBandwidth { gb_per_s: 0.0, fastest: String::new() }, |row| CopyBandwidth {
        gb_per_s: rate(row),
        fastest: row.pass.clone(),
    }))
}
