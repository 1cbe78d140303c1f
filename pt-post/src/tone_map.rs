//! Tone mapping.

use crate::bloom::Bloomed;
use crate::dither::noise_buffer;
use crate::exposure::Exposure;
use crate::kernels;
use crate::params::{ExposureMode, PostParams};
use crate::records::{Encoding, TONEMAP_ROWS, Tonemap, TonemapPush};
use pt_core::{Buffer, Device, Error, Frame, Image, Kernel, Result};
use pt_shaders::channels::Format;

/// Exposed radiance to the codes of a display.
///
/// NaN and negative values are shown black, +infinity white, each channel by itself.
pub struct ToneMap {
    tonemap: Tonemap,
    picture_kernel: Kernel,
    codes_kernel: Kernel,
    blue_noise: Buffer,
}

impl ToneMap {
    /// Creates the kernels for one curve, and for `encoding` where what they store are codes as half floats. With `alpha` that of the
    /// radiance, which is not premultiplied, goes to the picture; otherwise it is opaque.
    ///
    /// # Errors
    /// When the device refuses.
    pub fn new(device: &Device, tonemap: Tonemap, encoding: Encoding, alpha: bool) -> Result<Self> {
        let kernel = |code, encoding: Encoding| {
            let constants = [
                ("tonemap", tonemap.code().into()),
                ("encoding", encoding.code().into()),
                ("with_alpha", alpha.into()),
            ];
            Kernel::compute::<TonemapPush>(device, code, &constants)
        };
        Ok(Self {
            tonemap,
            picture_kernel: kernel(&kernels::TONEMAP, Encoding::Srgb)?,
            codes_kernel: kernel(&kernels::TONEMAP_CODES, encoding)?,
            blue_noise: noise_buffer(device)?,
        })
    }

    /// Adds its pass to the frame. `target` has the size of `radiance`. Its format says what is stored: 8-bit codes are sRGB and
    /// dithered; half floats are the codes of the encoding themselves.
    ///
    /// # Errors
    /// When the pass does not fit into the frame, or `params` ask for another curve than the kernels were made for.
    pub fn record<'a>(
        &self,
        frame: &mut Frame<'_>,
        radiance: impl Into<Bloomed<'a>>,
        exposure: &Exposure,
        target: &Image,
        params: &PostParams,
    ) -> Result<()> {
        if params.tonemap != self.tonemap {
            return Err(Error::StructuralKnob { key: "post.tonemap".into() });
        }
        let bloomed = radiance.into();
        let [width, height] = target.extent();
        let picture = target.format() == Format::Rgba8Unorm;
        let kernel = if picture { &self.picture_kernel } else { &self.codes_kernel };
        let pass = frame
            .pass("tone map", kernel)
            .sample("radiance", bloomed.radiance)
            .sample("glow", bloomed.glow)
            .read("exposure", exposure.buffer())
            .read("curve", exposure.curve())
            .write("target", target);
        let pass = if picture { pass.read("blue_noise", &self.blue_noise) } else { pass };
        pass.push(&TonemapPush {
            dither: params.dither.into(),
            manual: (params.exposure != ExposureMode::Auto).into(),
            bias: params.curve.bias,
            reinhard: params.curve.reinhard,
            knee: params.curve.knee,
            white_point: params.curve.white_point,
            compensation: params.compensation,
            paper_white: params.paper_white,
            peak: params.peak,
            glow_share: bloomed.share,
        })
        .dispatch([width, height.div_ceil(TONEMAP_ROWS), 1])
    }
}
