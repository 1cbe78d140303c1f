//! Metering, the eye's adaptation and the noise-aware curve of the frame.

use crate::kernels;
use crate::params::{ExposureMode, PostParams, exposure_scale};
use crate::records::*;
use pt_core::{Buffer, Device, Frame, Image, Kernel, Result};

/// Finds the exposure, and the tone curve where it depends on the frame. Both stay in device buffers.
///
/// State crosses frames only in adaptation: without a time step (`dt: None`) each frame is metered by itself. Pixels with any
/// non-finite channel, and those without light, are not metered.
pub struct Exposure {
    histogram_kernel: Kernel,
    meter_kernel: Kernel,
    curve_kernel: Kernel,
    histogram: Buffer,
    exposure: Buffer,
    distribution: Buffer,
    curve: Buffer,
}

/// What a frame is shown with.
#[derive(Clone, Debug, PartialEq)]
pub struct Metered {
    /// Its exposure.
    pub exposure: ExposureRecord,
    /// The noise-aware curve, as [`Exposure::read_curve`] returns it.
    pub curve: Vec<f32>,
}

impl Exposure {
    /// Creates kernels and buffers.
    ///
    /// # Errors
    /// When the device refuses.
    pub fn new(device: &Device) -> Result<Self> {
        let nothing_exposed = ExposureRecord {
            ev100: 0.0,
            scale: exposure_scale(0.0, 0.0),
            metered_ev100: 0.0,
            metered_pixels: 0.0,
        };
        Ok(Self {
            histogram_kernel: Kernel::compute::<HistogramPush>(device, &kernels::HISTOGRAM, &[])?,
            meter_kernel: Kernel::compute::<MeterPush>(device, &kernels::METER, &[])?,
            curve_kernel: Kernel::compute::<CurvePush>(device, &kernels::CURVE, &[])?,
            histogram: Buffer::from_slice(device, "histogram", &[0u32; 4 * HISTOGRAM_BINS as usize])?,
            exposure: Buffer::from_slice(device, "exposure", &[nothing_exposed])?,
            distribution: Buffer::from_slice(device, "distribution", &[0f32; CURVE_BINS as usize])?,
            curve: Buffer::from_slice(device, "curve", &[0f32; CURVE_BINS as usize + 1])?,
        })
    }

    /// Adds its passes to the frame: "histogram" and "meter" (auto, or for the noise-aware curve) or an upload of the exposure,
    /// then "tone curve" for the noise-aware curve. The frame is metered without its bloom, which moves light but keeps its sum. `dt`: seconds since the last frame; `None`: no
    /// adaptation, as in the first frame. Negative steps count as 0.
    ///
    /// # Errors
    /// When the passes do not fit into the frame.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        radiance: &Image,
        dt: Option<f32>,
        params: &PostParams,
    ) -> Result<()> {
        let manual = params.exposure != ExposureMode::Auto;
        let noise_aware = params.tonemap == Tonemap::NoiseAware;
        let dt = dt.map(|dt| if dt > 0.0 { dt } else { 0.0 });
        let share = |speed: f32| dt.map_or(1.0, |dt| 1.0 - (-dt * speed).exp());
        let (adapt_up, adapt_down) = (share(params.speed_up), share(params.speed_down));
        if !params.meters() {
            let ev100 = params.fixed_ev100();
            let record = ExposureRecord {
                ev100,
                scale: exposure_scale(ev100, params.compensation),
                metered_ev100: ev100,
                metered_pixels: 0.0,
            };
            return frame.upload(&self.exposure, bytemuck::bytes_of(&record));
        }
        let [columns, rows] = radiance.extent().map(|side| side.div_ceil(HISTOGRAM_SPAN));
        frame
            .pass("histogram", &self.histogram_kernel)
            .sample("radiance", radiance)
            .update("histogram", &self.histogram)
            .push(&HistogramPush { centre_weight: params.centre_weight })
            .dispatch([columns, rows, 1])?;
        frame
            .pass("meter", &self.meter_kernel)
            .update("histogram", &self.histogram)
            .update("exposure", &self.exposure)
            .write("distribution", &self.distribution)
            .push(&MeterPush {
                low: params.meter_low,
                high: params.meter_high,
                bias: params.meter_bias,
                min_ev100: params.min_ev100,
                max_ev100: params.max_ev100,
                fallback_ev100: params.fixed_ev100(),
                compensation: params.compensation,
                adapt_up,
                adapt_down,
                manual: manual.into(),
            })
            .dispatch([HISTOGRAM_BINS, 1, 1])?;
        if !noise_aware {
            return Ok(());
        }
        frame
            .pass("tone curve", &self.curve_kernel)
            .read("distribution", &self.distribution)
            .read("exposure", &self.exposure)
            .update("curve", &self.curve)
            .push(&CurvePush {
                range: params.curve.range,
                noise_stops: params.curve.noise_stops,
                noise_slope: params.curve.noise_slope,
                blur: params.curve.blur,
                adapt_up,
                adapt_down,
            })
            .dispatch([CURVE_BINS, 1, 1])
    }

    /// Replaces what [`Exposure::record`] found by the exposure and the curve of another frame.
    ///
    /// # Errors
    /// When the uploads do not fit into the frame.
    pub fn replace(&self, frame: &mut Frame<'_>, metered: &Metered) -> Result<()> {
        frame.upload(&self.exposure, bytemuck::bytes_of(&metered.exposure))?;
        frame.upload(&self.curve, bytemuck::cast_slice(&metered.curve))
    }

    /// What the frame that was submitted last was shown with; waits for it.
    ///
    /// # Errors
    /// When the device fails.
    pub fn metered(&self) -> Result<Metered> {
        Ok(Metered { exposure: self.read()?, curve: self.read_curve()? })
    }

    /// The exposure of the frame that was submitted last; waits for it.
    ///
    /// # Errors
    /// When the device fails.
    pub fn read(&self) -> Result<ExposureRecord> {
        Ok(self.exposure.read()?[0])
    }

    /// The noise-aware curve of the frame that was submitted last, log2 display luminance at the lower edge of each bin and at
    /// the end of the last; waits for it.
    ///
    /// # Errors
    /// When the device fails.
    pub fn read_curve(&self) -> Result<Vec<f32>> {
        self.curve.read()
    }

    /// Buffers that the next frame adapts from.
    pub fn state(&self) -> [&Buffer; 2] {
        [&self.exposure, &self.curve]
    }

    pub(crate) fn buffer(&self) -> &Buffer {
        &self.exposure
    }

    pub(crate) fn curve(&self) -> &Buffer {
        &self.curve
    }
}
