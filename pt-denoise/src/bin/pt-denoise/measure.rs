//! A denoised frame against its ground truth, and its change against the change of the truth.

use crate::sequence::{Disoccluded, Row};
use anyhow::{Result, bail};
use pt_core::split::to_flat;
use pt_core::{ChannelImages, StageIo};
use pt_image::image_file::LinearImage;
use pt_image::metrics::{Correspondence, FramePair, Metric, MetricError, compare, temporal_error};
use pt_shaders::channels::{MOTION, VIEW_DEPTH};

/// A frame with what is needed to compare the next one with it.
pub struct Seen {
    radiance: LinearImage,
    reference: LinearImage,
    /// Flat pixels: channel `motion`, channel `view_depth`.
    surfaces: Vec<([f32; 4], f32)>,
}

impl Seen {
    /// The channels that say where surfaces were.
    pub const IO: StageIo = StageIo { reads: &[MOTION, VIEW_DEPTH], ..StageIo::of("measures") };

    /// The frame in `images`.
    pub fn of(images: &ChannelImages, radiance: LinearImage, reference: LinearImage) -> Result<Self> {
        let motion = images.current(MOTION).read_f32()?;
        let depth = images.current(VIEW_DEPTH).read_f32()?;
        let motion = motion.chunks_exact(4).map(|m| [m[0], m[1], m[2], m[3]]);
        let surfaces: Vec<_> = motion.zip(depth).collect();
        let surfaces = to_flat(&surfaces, images.size());
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
        let correspondence = self.motion_from(before);
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

    /// Where surfaces were that the frame before shows: at the distance at which they were there.
    fn motion_from(&self, before: &Self) -> Correspondence {
        let size = [self.radiance.width, self.radiance.height];
        let offset = |i: usize| {
            let (motion, depth) = self.surfaces[i];
            let offset = [motion[0] * size[0] as f32, motion[1] * size[1] as f32];
            let at = [i as u32 % size[0], i as u32 / size[0]];
            let place = [0, 1].map(|k| (at[k] as f32 + offset[k]).round());
            let inside = (0..2).all(|k| (0.0..size[k] as f32).contains(&place[k]));
            let was =
                inside.then(|| before.surfaces[(place[1] as u32 * size[0] + place[0] as u32) as usize].1)?;
            let expected = depth + motion[2];
            let tolerance = 0.02 * expected.abs() + 2.0 / motion[3].max(1e-18);
            ((was - expected).abs() <= tolerance).then_some(offset)
        };
        Correspondence { offsets: (0..self.surfaces.len()).map(offset).collect() }
    }
}
