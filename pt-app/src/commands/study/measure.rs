//! A frame against its ground truth, and its change against the change of the truth.

use super::truth::Truth;
use crate::frame::FullFrame;
use anyhow::{Result, bail};
use pt_core::{Image, Surfaces};
use pt_image::image_file::{ImageState, LinearImage};
use pt_image::metrics::{FramePair, Metric, MetricError, SequenceMetric, compare, temporal_error};
use pt_study::metric::MeasureAt;
use std::collections::BTreeMap;

/// A frame that was rendered.
pub struct Shot {
    /// Linear radiance before exposure, or linear display values.
    pub image: LinearImage,
    /// Its ground truth.
    pub truth: Truth,
    surfaces: Option<Surfaces>,
}

impl Shot {
    /// The frame that `full` recorded last, at the place where it is measured; waits for it. `temporal`: whether the next frame is compared with it.
    ///
    /// # Errors
    /// When the device fails, or the frame has not the size of its truth.
    pub fn of(full: &FullFrame, truth: Truth, temporal: bool, measure_at: MeasureAt) -> Result<Self> {
        let image = match measure_at {
            MeasureAt::Radiance => linear(full.radiance())?,
            MeasureAt::Display => full.picture()?,
        };
        let [a, b] = [&image, &*truth.image].map(|image| [image.width, image.height]);
        if a != b {
            bail!(
                "radiance has {}x{} pixels and the reference {}x{}: fsr1 upscales the tone-mapped picture; measure_at = \"display\" measures it",
                a[0],
                a[1],
                b[0],
                b[1]
            );
        }
        let surfaces = temporal.then(|| Surfaces::read(full.images())).transpose()?;
        Ok(Self { image, truth, surfaces })
    }

    /// The value of a metric between the first half of the reference's samples and all of them: what a perfect frame would have.
    pub fn reference_noise(&self, metric: SequenceMetric) -> Option<f64> {
        let found = compare(self.truth.half.as_ref()?, &self.truth.image, &[metric.image()?]).ok()?;
        found.first().map(|found| found.value)
    }

    /// The values of metrics; `None` where the frame has values that are no light, or no frame before it.
    ///
    /// # Errors
    /// A reference that is no light.
    pub fn measure(&self, before: Option<&Self>, metrics: &[SequenceMetric]) -> Result<Vec<Option<f64>>> {
        let of_images: Vec<Metric> = metrics.iter().filter_map(|metric| metric.image()).collect();
        let measured = match compare(&self.image, &self.truth.image, &of_images) {
            Ok(found) => found,
            // A value that is no light is a result of the frame; of the truth it is an error.
            Err(MetricError::NonFinite { b: 0, .. }) => Vec::new(),
            Err(error) => return Err(error.into()),
        };
        let found: BTreeMap<Metric, f64> = measured.iter().map(|found| (found.metric, found.value)).collect();
        let temporal = self.temporal(before);
        let value = |metric: &SequenceMetric| {
            let value = match metric {
                SequenceMetric::Image(metric) => found.get(metric).copied(),
                SequenceMetric::TemporalPixel => temporal.map(|[pixel, _]| pixel),
                SequenceMetric::TemporalBlock => temporal.map(|[_, block]| block),
            };
            value.filter(|value| value.is_finite())
        };
        Ok(metrics.iter().map(value).collect())
    }

    /// Errors of the change by pixels and by blocks.
    fn temporal(&self, before: Option<&Self>) -> Option<[f64; 2]> {
        let before = before?;
        let size = [self.image.width, self.image.height];
        let motion = self.surfaces.as_ref()?.seen_in(before.surfaces.as_ref()?, size);
        let pair = |now, before| FramePair { now, before };
        let test = pair(&self.image, &before.image);
        let error = temporal_error(test, pair(&self.truth.image, &before.truth.image), &motion).ok()?;
        Some([error.pixel, error.block])
    }
}

/// An image of four components as linear radiance; waits for the device.
///
/// # Errors
/// When the device fails.
pub fn linear(image: &Image) -> Result<LinearImage> {
    let [width, height] = image.extent();
    let pixels = image.read_f32()?.chunks_exact(4).map(|c| [c[0], c[1], c[2]]).collect();
    Ok(LinearImage { width, height, pixels, state: ImageState::SceneReferred })
}
