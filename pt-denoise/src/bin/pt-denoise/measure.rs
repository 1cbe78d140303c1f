//! A denoised frame against its ground truth, and its change against the change of the truth.

use anyhow::{Result, bail};
use pt_core::{ChannelImages, StageIo, Surfaces};
use pt_image::image_file::LinearImage;
use pt_image::metrics::{FramePair, Metric, MetricError, compare, temporal_error};
use serde::Serialize;
use std::collections::BTreeMap;

/// A line of the JSON file.
#[derive(Default, Serialize)]
pub struct Row {
    pub variant: &'static str,
    pub frame: u32,
    pub relmse: Option<f64>,
    pub flip: Option<f64>,
    /// Error of the change from the frame before, by pixels along the motion; none in the first frame.
    pub temporal_pixel: Option<f64>,
    /// The same by blocks.
    pub temporal_block: Option<f64>,
    /// Gradient energy over that of the reference.
    pub detail_ratio: Option<f64>,
    pub energy_ratio: Option<f64>,
    /// Errors of the pixels whose surface the frame before did not show, and of the others; none in the first frame and after a cut.
    pub disoccluded: Option<Disoccluded>,
    pub gpu_ms: f64,
    /// Of each pass.
    pub passes: BTreeMap<String, f64>,
}

/// Errors apart.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Disoccluded {
    /// Part of the pixels.
    pub share: f64,
    /// None without such pixels.
    pub relmse: Option<f64>,
    pub flip: Option<f64>,
    /// Of the other pixels.
    pub relmse_others: Option<f64>,
    pub flip_others: Option<f64>,
}

/// A frame with what is needed to compare the next one with it.
pub struct Seen {
    radiance: LinearImage,
    reference: LinearImage,
    surfaces: Surfaces,
}

impl Seen {
    /// The channels that say where surfaces were.
    pub const IO: StageIo = Surfaces::IO;

    /// The frame in `images`.
    pub fn of(images: &ChannelImages, radiance: LinearImage, reference: LinearImage) -> Result<Self> {
        let surfaces = Surfaces::read(images)?;
        Ok(Self { radiance, reference, surfaces })
    }

    /// Fills the errors of a row. They stay empty where the frame has values that are no light.
    pub fn measure(&self, before: Option<&Self>, row: &mut Row) -> Result<()> {
        let metrics = [Metric::RelMse, Metric::Flip, Metric::Energy, Metric::Detail];
        let found = match compare(&self.radiance, &self.reference, &metrics) {
            Ok(found) => found,
            // Samples that are no light are what a denoiser is measured with, too.
            Err(MetricError::NonFinite { a, b: 0, .. }) if a > 0 => return Ok(()),
            Err(error) => bail!("{error}"),
        };
        let value = |i: usize| found.get(i).map(|m| m.value);
        [row.relmse, row.flip, row.energy_ratio, row.detail_ratio] = [0, 1, 2, 3].map(value);
        let Some(before) = before else { return Ok(()) };
        let size = [self.radiance.width, self.radiance.height];
        let correspondence = self.surfaces.seen_in(&before.surfaces, size);
        let new: Vec<bool> = correspondence.offsets.iter().map(Option::is_none).collect();
        let count = new.iter().filter(|is_new| **is_new).count();
        let mean = |metric: usize, of_new: bool| {
            let of: Vec<f64> = (found.get(metric)?.map.iter().zip(&new))
                .filter(|(_, is_new)| **is_new == of_new)
                .map(|(error, _)| f64::from(*error))
                .collect();
            (!of.is_empty()).then(|| of.iter().sum::<f64>() / of.len() as f64)
        };
        row.disoccluded = Some(Disoccluded {
            share: count as f64 / new.len().max(1) as f64,
            relmse: mean(0, true),
            flip: mean(1, true),
            relmse_others: mean(0, false),
            flip_others: mean(1, false),
        });
        let test = FramePair { now: &self.radiance, before: &before.radiance };
        let truth = FramePair { now: &self.reference, before: &before.reference };
        if let Ok(error) = temporal_error(test, truth, &correspondence) {
            (row.temporal_pixel, row.temporal_block) = (Some(error.pixel), Some(error.block));
        }
        Ok(())
    }
}
