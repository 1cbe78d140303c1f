//! AMD FidelityFX Super Resolution 1: upscaling (EASU) and sharpening (RCAS) of display codes.

use crate::blue_noise::noise_buffer;
use crate::kernels;
use crate::params::{Encoding, PostParams, Upscale};
use crate::records::{EASU_ROWS, EasuPush, RCAS_COLUMNS, RCAS_ROWS, RcasPush};
use pt_core::settings::{InvalidValue, Validate, check_range};
use pt_core::{Buffer, Device, Frame, Image, Kernel, Result};
use pt_shaders::channels::Format;
use serde::{Deserialize, Serialize};

/// Quality presets of FSR 1: name and factor between the sides of frame and picture.
pub const PRESETS: &[(&str, f32)] =
    &[("ultra-quality", 1.3), ("quality", 1.5), ("balanced", 1.7), ("performance", 2.0)];

/// Knobs of upscaling and sharpening.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FsrParams {
    /// Whether pictures that are not upscaled by FSR are sharpened too. Default false.
    pub sharpen: bool,
    /// Stops below the strongest sharpening, 0 (strongest) to 10. Default 1, which is closest to native pictures; AMD and
    /// Quake II RTX take 0.2.
    pub sharpness: f32,
    /// Whether pixels that stand out from their neighbours, as noise does, are sharpened less. Default false.
    pub denoise: bool,
}

impl Default for FsrParams {
    fn default() -> Self {
        Self { sharpen: false, sharpness: 1.0, denoise: false }
    }
}

impl Validate for FsrParams {
    fn validate(&self) -> std::result::Result<(), InvalidValue> {
        check_range("sharpness", self.sharpness, 0.0..=10.0, "stops")
    }
}

/// Upscales and sharpens display codes. They are sRGB codes, or PQ codes for HDR output: a space that is perceptual and ends
/// at 1, as the method asks for.
pub struct Fsr {
    easu_kernel: Kernel,
    rcas_kernel: Kernel,
    rcas_codes_kernel: Kernel,
    blue_noise: Buffer,
    codes: Image,
    upscaled: Option<Image>,
}

impl Fsr {
    /// Creates kernels and images for a frame of `size` and a picture of `output_size`.
    ///
    /// # Errors
    /// When the device refuses.
    pub fn new(device: &Device, size: [u32; 2], output_size: [u32; 2]) -> Result<Self> {
        let image = |name, size| Image::new(device, name, Format::Rgba16F, size);
        Ok(Self {
            easu_kernel: Kernel::compute::<EasuPush>(device, &kernels::EASU, &[])?,
            rcas_kernel: Kernel::compute::<RcasPush>(device, &kernels::RCAS, &[])?,
            rcas_codes_kernel: Kernel::compute::<RcasPush>(device, &kernels::RCAS_CODES, &[])?,
            blue_noise: noise_buffer(device)?,
            codes: image("display_codes", size)?,
            upscaled: if size == output_size { None } else { Some(image("upscaled_codes", output_size)?) },
        })
    }

    /// Where the tone map's codes go.
    pub fn codes(&self) -> &Image {
        &self.codes
    }

    /// What the codes of [`Fsr::codes`] have to be for an output of `encoding`: scRGB is linear, and made at the end.
    pub fn input_encoding(encoding: Encoding) -> Encoding {
        if encoding == Encoding::Srgb { Encoding::Srgb } else { Encoding::Pq }
    }

    /// Adds its passes to the frame: "easu" unless both sizes are the same, and "rcas" into `target`, whose format says
    /// whether the picture is 8-bit sRGB or HDR.
    ///
    /// # Errors
    /// When the passes do not fit into the frame.
    pub fn record(&self, frame: &mut Frame<'_>, target: &Image, params: &PostParams) -> Result<()> {
        let [width, height] = target.extent();
        if let Some(upscaled) = &self.upscaled {
            frame
                .pass("easu", &self.easu_kernel)
                .sample("source", &self.codes)
                .write("target", upscaled)
                .push(&EasuPush { input_size: self.codes.extent().into() })
                .dispatch([width, height.div_ceil(EASU_ROWS), 1])?;
        }
        let source = self.upscaled.as_ref().unwrap_or(&self.codes);
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
        let groups = [width.div_ceil(RCAS_COLUMNS), height.div_ceil(RCAS_ROWS)];
        pass.push(&push).dispatch([groups[0] * (RCAS_COLUMNS + 2), groups[1], 1])
    }

    /// The upscaled codes before sharpening, when it upscales.
    pub fn upscaled(&self) -> Option<&Image> {
        self.upscaled.as_ref()
    }
}
