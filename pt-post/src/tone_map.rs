//! Exposure and tone mapping.

use crate::kernels;
use crate::params::{ExposureMode, PostParams, exposure_scale};
use crate::records::{ExposureRecord, HISTOGRAM_BINS, MeterPush, TonemapPush};
use pt_core::{Buffer, ChannelImages, Device, Frame, Kernel, Result};
use pt_shaders::channels::{ACCUMULATED, ChannelId, DISPLAY, FLAT_COLOR};

/// Which radiance is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Radiance {
    /// This frame.
    Frame,
    /// The mean of the frames so far.
    Accumulated,
}

impl Radiance {
    /// The channel that holds it.
    pub const fn channel(self) -> ChannelId {
        match self {
            Self::Frame => FLAT_COLOR,
            Self::Accumulated => ACCUMULATED,
        }
    }
}

/// Radiance of the flat frame to the display picture.
///
/// Auto exposure meters the frame itself: no state crosses frames. NaN and negative values are shown black, +infinity white;
/// pixels with any non-finite channel are not metered.
pub struct ToneMap {
    histogram_kernel: Kernel,
    meter_kernel: Kernel,
    tonemap_kernel: Kernel,
    histogram: Buffer,
    exposure: Buffer,
}

impl ToneMap {
    /// Channels that it writes, on every pixel. It reads [`Radiance::channel`].
    pub const WRITES: &[ChannelId] = &[DISPLAY];

    /// Creates kernels and buffers.
    ///
    /// # Errors
    /// When the device refuses.
    pub fn new(device: &Device) -> Result<Self> {
        let nothing_exposed =
            ExposureRecord { ev100: 0.0, scale: exposure_scale(0.0, 0.0), metered_pixels: 0 };
        Ok(Self {
            histogram_kernel: Kernel::compute::<()>(device, &kernels::HISTOGRAM)?,
            meter_kernel: Kernel::compute::<MeterPush>(device, &kernels::METER)?,
            tonemap_kernel: Kernel::compute::<TonemapPush>(device, &kernels::TONEMAP)?,
            histogram: Buffer::from_slice(device, "histogram", &[0u32; 2 * HISTOGRAM_BINS as usize])?,
            exposure: Buffer::from_slice(device, "exposure", &[nothing_exposed])?,
        })
    }

    /// Adds its passes to the frame: "histogram" and "meter" (auto) or an upload of the exposure (manual), then "tone map".
    ///
    /// # Errors
    /// When the passes do not fit into the frame.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        images: &ChannelImages,
        radiance: Radiance,
        params: &PostParams,
    ) -> Result<()> {
        let radiance = images.current(radiance.channel());
        let [width, height] = images.size();
        match params.exposure {
            ExposureMode::Auto => {
                frame
                    .pass("histogram", &self.histogram_kernel)
                    .read("radiance", radiance)
                    .update("histogram", &self.histogram)
                    .dispatch([width, height, 1])?;
                frame
                    .pass("meter", &self.meter_kernel)
                    .update("histogram", &self.histogram)
                    .write("exposure", &self.exposure)
                    .push(&MeterPush {
                        low: params.meter_low,
                        high: params.meter_high,
                        bias: params.meter_bias,
                        min_ev100: params.min_ev100,
                        max_ev100: params.max_ev100,
                        fallback_ev100: params.ev100,
                        compensation: params.compensation,
                    })
                    .dispatch([HISTOGRAM_BINS, 1, 1])?;
            }
            ExposureMode::Manual => {
                let record = ExposureRecord {
                    ev100: params.ev100,
                    scale: exposure_scale(params.ev100, params.compensation),
                    metered_pixels: 0,
                };
                frame.upload(&self.exposure, bytemuck::bytes_of(&record))?;
            }
        }
        frame
            .pass("tone map", &self.tonemap_kernel)
            .read("radiance", radiance)
            .read("exposure", &self.exposure)
            .writes(images, Self::WRITES)
            .push(&TonemapPush { operator: params.tonemap.code() })
            .dispatch([width, height, 1])
    }

    /// The exposure of the frame that was submitted last; waits for it.
    ///
    /// # Errors
    /// When the device fails.
    pub fn exposure(&self) -> Result<ExposureRecord> {
        Ok(self.exposure.read()?[0])
    }
}
