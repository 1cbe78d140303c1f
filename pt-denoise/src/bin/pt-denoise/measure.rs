//! A denoised frame against its ground truth, and its change against the change of the truth.

use crate::sequence::Row;
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
        match compare(&self.radiance, &self.reference, &metrics) {
            Ok(found) => {
                let value = |i: usize| found.get(i).map(|m| m.value);
                [row.relmse, row.flip, row.energy_ratio, row.detail_ratio] = [0, 1, 2, 3].map(value);
            }
            // Samples that are no light are what a denoiser is measured with, too.
            Err(MetricError::NonFinite { a, b: 0, .. }) if a > 0 => return Ok(()),
            Err(error) => bail!("{error}"),
        }
        let Some(before) = before else { return Ok(()) };
        let test = FramePair { now: &self.radiance, before: &before.radiance };
        let truth = FramePair { now: &self.reference, before: &before.reference };
        if let Ok(error) = temporal_error(test, truth, &self.motion_from(before)) {
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
