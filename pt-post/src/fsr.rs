//! AMD FidelityFX Super Resolution 1: upscaling (EASU) and sharpening (RCAS) of display codes.

use crate::dither::noise_buffer;
use crate::images::{DISPLAY_CODES, UPSCALED_CODES};
use crate::kernels;
use crate::params::{PostParams, Upscale};
use crate::records::{EASU_HALF_ROWS, EASU_ROWS, EasuPush, Encoding, RCAS_COLUMNS, RCAS_ROWS, RcasPush};
use pt_core::{Buffer, ChannelImages, Device, Frame, Image, Kernel, Result, StageIo};
use pt_shaders::channels::{ChannelId, Format};

/// Upscales and sharpens display codes. They are sRGB codes, or PQ codes for HDR output: a space that is perceptual and ends
/// at 1, as the method asks for.
pub struct Fsr {
    easu_kernel: Kernel,
    rcas_kernel: Kernel,
    rcas_codes_kernel: Kernel,
    blue_noise: Buffer,
    /// Whether EASU, and RCAS into 8-bit codes, compute in half floats.
    half: bool,
}

impl Fsr {
    /// The images that it accesses: its input, and the upscaled codes between its passes.
    pub fn io(upscales: bool) -> StageIo {
        let writes: &[ChannelId] = if upscales { &[DISPLAY_CODES, UPSCALED_CODES] } else { &[DISPLAY_CODES] };
        StageIo { writes, ..StageIo::of("fsr") }
    }

    /// Creates the kernels: those in half floats on GPUs that have them.
    ///
    /// # Errors
    /// When the device refuses.
    pub fn new(device: &Device) -> Result<Self> {
        Self::with_precision(device, Self::computes_in_half_floats(device))
    }

    /// What [`Self::new`] takes for this device.
    pub fn computes_in_half_floats(device: &Device) -> bool {
        device.info().capabilities.half_floats && !device.info().is_cpu()
    }

    /// As [`Self::new`]. `half`: EASU, and RCAS into 8-bit codes, compute in half floats.
    ///
    /// # Errors
    /// When the device refuses; half floats need `half_floats` of the capabilities of the device.
    pub fn with_precision(device: &Device, half: bool) -> Result<Self> {
        let [easu, rcas] =
            if half { [&kernels::EASU_HALF, &kernels::RCAS_HALF] } else { [&kernels::EASU, &kernels::RCAS] };
        Ok(Self {
            easu_kernel: Kernel::compute::<EasuPush>(device, easu, &[])?,
            rcas_kernel: Kernel::compute::<RcasPush>(device, rcas, &[])?,
            rcas_codes_kernel: Kernel::compute::<RcasPush>(device, &kernels::RCAS_CODES, &[])?,
            blue_noise: noise_buffer(device)?,
            half,
        })
    }

    /// The encoding of `display_codes` for an output of `encoding`: scRGB is linear, and therefore computed at the end.
    pub fn input_encoding(encoding: Encoding) -> Encoding {
        if encoding == Encoding::Srgb { Encoding::Srgb } else { Encoding::Pq }
    }

    /// Adds its passes to the frame: "easu" unless `display_codes` and `target` have one size, and "rcas" into `target`, whose
    /// format says whether the picture is 8-bit sRGB or HDR.
    ///
    /// # Errors
    /// When the passes do not fit into the frame.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        images: &ChannelImages,
        target: &Image,
        params: &PostParams,
    ) -> Result<()> {
        let [width, height] = target.extent();
        let mut source = images.current(DISPLAY_CODES);
        if source.extent() != target.extent() {
            let upscaled = images.current(UPSCALED_CODES);
            frame
                .pass("easu", &self.easu_kernel)
                .sample("source", source)
                .write("target", upscaled)
                .push(&EasuPush { input_size: source.extent().into() })
                .dispatch([width, height.div_ceil(if self.half { EASU_HALF_ROWS } else { EASU_ROWS }), 1])?;
            source = upscaled;
        }
        let sharpen = params.upscale == Upscale::Fsr1 || params.fsr.sharpen;
        let push = RcasPush {
            strength: if sharpen { (-params.fsr.sharpness).exp2() } else { 0.0 },
            denoise: params.fsr.denoise.into(),
            encoding: params.encoding.code(),
            dither: params.dither.into(),
        };
        let eight_bits = target.format() == Format::Rgba8Unorm;
        let kernel = if eight_bits { &self.rcas_kernel } else { &self.rcas_codes_kernel };
        let pass = frame.pass("rcas", kernel).sample("source", source).write("target", target);
        let pass = if eight_bits { pass.read("blue_noise", &self.blue_noise) } else { pass };
        if eight_bits && self.half {
            // Two pixels a thread.
            return pass.push(&push).dispatch([width, height.div_ceil(2), 1]);
        }
        let groups = [width.div_ceil(RCAS_COLUMNS), height.div_ceil(RCAS_ROWS)];
        pass.push(&push).dispatch([groups[0] * (RCAS_COLUMNS + 2), groups[1], 1])
    }
}
