//! Spatiotemporal reservoir resampling of direct light, `sampler=restir-di`: the passes before the shadow rays.

use crate::images::*;
use crate::kernels;
use crate::params::DirectParams;
use crate::records::{DirectPush, RestirVisibility};
use pt_core::split::{flat_to_split, split_size};
use pt_core::trace::TraceVariant;
use pt_core::{ChannelImages, Device, Frame, Kernel, Result, StageInputs, StageIo};
use pt_shaders::channels::*;
use pt_shaders::records::{NONE, field_width};

/// Draws candidates and reuses the last frame's reservoirs, then the neighbours'.
pub(crate) struct Restir {
    temporal: Kernel,
    spatial: Kernel,
    spatial_io: StageIo,
}

impl Restir {
    const TEMPORAL: StageIo = StageIo {
        reads: &[
            RNG_SEED,
            BASE_COLOR,
            METALLIC_ROUGHNESS,
            NORMAL,
            VERTEX_NORMAL,
            SHADING_POSITION,
            VIEW_DIRECTION,
            VIEW_DEPTH,
            MOTION,
            CLUSTER,
            VISIBILITY,
            BARYCENTRICS,
            THROUGHPUT,
            BOUNCE_THROUGHPUT,
        ],
        reads_previous: &[
            NORMAL,
            SHADING_POSITION,
            VIEW_DIRECTION,
            VIEW_DEPTH,
            RESTIR_SURFACE,
            RESTIR_HISTORY_POINT,
            RESTIR_HISTORY_WEIGHT,
        ],
        writes: &[RESTIR_SURFACE, RESTIR_TEMPORAL_POINT, RESTIR_TEMPORAL_WEIGHT],
        ..StageIo::of("light reuse over time")
    };

    const SPATIAL: StageIo = StageIo {
        reads: &[
            RNG_SEED,
            NORMAL,
            SHADING_POSITION,
            VIEW_DIRECTION,
            VIEW_DEPTH,
            RESTIR_SURFACE,
            RESTIR_TEMPORAL_POINT,
            RESTIR_TEMPORAL_WEIGHT,
        ],
        writes: &[RESTIR_POINT, RESTIR_WEIGHT, RESTIR_HISTORY_POINT, RESTIR_HISTORY_WEIGHT],
        ..StageIo::of("light reuse of neighbours")
    };

    const SPATIAL_TRACED: StageIo = StageIo {
        reads: &[
            RNG_SEED,
            NORMAL,
            VERTEX_NORMAL,
            SHADING_POSITION,
            VIEW_DIRECTION,
            VIEW_DEPTH,
            RESTIR_SURFACE,
            RESTIR_TEMPORAL_POINT,
            RESTIR_TEMPORAL_WEIGHT,
        ],
        ..Self::SPATIAL
    };

    /// What direct lighting reads besides the images of every sampler.
    pub(crate) const SHADING: StageIo =
        StageIo { reads: &[RESTIR_POINT, RESTIR_WEIGHT], ..StageIo::of("direct lighting") };

    /// What it updates to drop samples that are hidden.
    pub(crate) const DROPPING: StageIo =
        StageIo { updates: &[RESTIR_HISTORY_WEIGHT], ..StageIo::of("direct lighting") };

    fn spatial_io(params: &DirectParams) -> StageIo {
        match params.restir_visibility {
            RestirVisibility::InWeight => Self::SPATIAL_TRACED,
            RestirVisibility::None | RestirVisibility::Final => Self::SPATIAL,
        }
    }

    /// The images of the passes, in order.
    pub(crate) fn io(params: &DirectParams) -> [StageIo; 2] {
        [Self::TEMPORAL, Self::spatial_io(params)]
    }

    pub(crate) fn new(device: &Device, variant: TraceVariant, params: &DirectParams) -> Result<Self> {
        let constants = [
            ("scene_features", variant.scene_features.into()),
            ("random_source", variant.random.code().into()),
            ("area_sampling", params.area_sampling.code().into()),
            ("environment_listed", params.is_environment_listed().into()),
            ("light_sampler", params.sampler.code().into()),
            ("ris_source", params.ris_source.code().into()),
        ];
        let compute = |code| Kernel::compute::<DirectPush>(device, code, &constants);
        let temporal = compute(&kernels::RESTIR_TEMPORAL)?;
        let spatial = match params.restir_visibility {
            RestirVisibility::InWeight => {
                let mut constants = constants.to_vec();
                constants.push(("culling", variant.culling.unseen().code().into()));
                let code = &kernels::RESTIR_SPATIAL_TRACED;
                Kernel::trace::<DirectPush>(device, code, variant.backend, &constants)?
            }
            RestirVisibility::None | RestirVisibility::Final => compute(&kernels::RESTIR_SPATIAL)?,
        };
        let spatial_io = Self::spatial_io(params);
        Self::TEMPORAL.check([&temporal])?;
        spatial_io.check([&spatial])?;
        Ok(Self { temporal, spatial, spatial_io })
    }

    pub(crate) fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        push: &DirectPush,
    ) -> Result<()> {
        let name = Self::TEMPORAL.stage;
        let pass = inputs.pass(frame, name, &self.temporal, &Self::TEMPORAL).touches_part();
        pass.push(push).dispatch(inputs.split_threads())?;
        let pass = inputs.pass(frame, self.spatial_io.stage, &self.spatial, &self.spatial_io);
        pass.push(push).dispatch(inputs.split_threads())
    }
}

/// How many of the 8 neighbours of a pixel are shaded with the same light sample, on average over the pixels that have a sample: reuse makes the
/// noise of neighbours alike, which a denoiser takes for a feature of the picture.
///
/// # Errors
/// When the images cannot be read.
///
/// # Panics
/// When no stage of the images' plan has reservoirs.
pub fn duplicated_samples(images: &ChannelImages) -> Result<f64> {
    let words = images.current(RESTIR_POINT).read_u32()?;
    let points: Vec<[u32; 2]> = words.chunks_exact(2).map(|point| [point[0], point[1]]).collect();
    Ok(mean_duplicates(&points, images.size()))
}

/// The same of samples (light and place on it) in split order.
fn mean_duplicates(points: &[[u32; 2]], size: [u32; 2]) -> f64 {
    let [width, height] = size.map(i64::from);
    let row = split_size(size)[0] as usize;
    let at = |x: i64, y: i64| {
        let inside = (0..width).contains(&x) && (0..height).contains(&y);
        inside.then(|| {
            let [x, y] = flat_to_split([x as u32, y as u32], field_width(size[0])).map(|v| v as usize);
            points[y * row + x]
        })
    };
    let (mut duplicates, mut samples) = (0_u64, 0_u64);
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let Some(own) = at(x, y).filter(|point| point[0] != NONE) else { continue };
        samples += 1;
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
        let same = around.filter(|&d| d != (0, 0) && at(x + d.0, y + d.1) == Some(own)).count();
        duplicates += same as u64;
    }
    if samples == 0 { 0.0 } else { duplicates as f64 / samples as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pt_core::split::to_split;

    /// Counted by hand: two pairs side by side, one of them in the same place on another light, and pixels without a sample.
    #[test]
    fn duplicates_are_counted_in_the_flat_frame() {
        let none = [NONE, 0];
        let (a, b, c) = ([1, 7], [2, 7], [3, 1]);
        #[rustfmt::skip]
        let flat = [
            a, a, none, none,
            b, c, none, a,
            none, none, b, c,
        ];
        // a-a share a side; the third a touches neither; c and c do not touch; b and b do not.
        let points = to_split(&flat, [4, 3], none);
        assert_eq!(mean_duplicates(&points, [4, 3]), 2.0 / 7.0);
        assert_eq!(
            mean_duplicates(&to_split(&[a; 9], [3, 3], none), [3, 3]),
            (4.0 * 3.0 + 4.0 * 5.0 + 8.0) / 9.0
        );
        assert_eq!(mean_duplicates(&[none; 4], [2, 2]), 0.0);
    }
}
