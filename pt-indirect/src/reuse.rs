//! Spatiotemporal reservoir resampling of bounced light, `reuse=restir-gi`: the passes behind the paths.

use crate::bounces::{ReuseTables, TABLES_OVER_TIME, Tables};
use crate::images::*;
use crate::kernels;
use crate::params::IndirectParams;
use crate::records::{IndirectPush, RestirVisibility};
use pt_core::frame::{Pass, RayCount};
use pt_core::trace::TraceVariant;
use pt_core::{Device, Frame, Kernel, Result, StageInputs, StageIo};
use pt_shaders::channels::*;

/// Resamples what the paths have found with the last frame's reservoirs, then with the neighbours'.
pub(crate) struct Reuse {
    temporal: Kernel,
    spatial: Kernel,
    visibility: RestirVisibility,
}

impl Reuse {
    const TEMPORAL: StageIo = StageIo {
        reads: &[
            RNG_SEED,
            NORMAL,
            SHADING_POSITION,
            VIEW_DIRECTION,
            VIEW_DEPTH,
            MOTION,
            VISIBILITY,
            BARYCENTRICS,
        ],
        reads_previous: &[
            SHADING_POSITION,
            VIEW_DIRECTION,
            VIEW_DEPTH,
            REUSE_SURFACE,
            REUSE_POINT,
            REUSE_LIGHT,
        ],
        writes: &[REUSE_SURFACE, REUSE_POINT, REUSE_LIGHT],
        tables: TABLES_OVER_TIME,
        ..StageIo::of("bounce reuse over time")
    };

    const SPATIAL: StageIo = StageIo {
        reads: &[
            RNG_SEED,
            SHADING_POSITION,
            VIEW_DIRECTION,
            VIEW_DEPTH,
            REUSE_SURFACE,
            REUSE_POINT,
            REUSE_LIGHT,
        ],
        ..StageIo::of("bounce reuse of neighbours")
    };

    /// The images of the passes, in order.
    pub(crate) const IO: [StageIo; 2] = [Self::TEMPORAL, Self::SPATIAL];

    pub(crate) fn new(device: &Device, variant: TraceVariant, params: &IndirectParams) -> Result<Self> {
        let visibility = params.restir_visibility;
        let constants = [
            ("scene_features", variant.scene_features.into()),
            ("random_source", variant.random.code().into()),
        ];
        let compute = |code| Kernel::compute::<IndirectPush>(device, code, &constants);
        let trace = |code, more: &[_]| {
            let constants = [&variant.unseen().constants()[..], more].concat();
            Kernel::trace::<IndirectPush>(device, code, variant.backend, &constants)
        };
        let in_weight = visibility == RestirVisibility::InWeight;
        let temporal = match in_weight {
            true => trace(&kernels::REUSE_TEMPORAL_TRACED, &[])?,
            false => compute(&kernels::REUSE_TEMPORAL)?,
        };
        let spatial = match visibility {
            RestirVisibility::None => compute(&kernels::REUSE_SPATIAL)?,
            _ => trace(&kernels::REUSE_SPATIAL_TRACED, &[("visible_weights", in_weight.into())])?,
        };
        Self::TEMPORAL.check([&temporal])?;
        Self::SPATIAL.check([&spatial])?;
        Ok(Self { temporal, spatial, visibility })
    }

    /// Of `tables`, `reuse` are those of the reuse.
    pub(crate) fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        tables: &Tables,
        reuse: &ReuseTables,
        push: &IndirectPush,
    ) -> Result<()> {
        let threads = inputs.split_threads();
        let counted = |pass: Pass<'_, '_>, rays| match rays {
            0 => pass.dispatch(threads),
            rays => pass.rays(RayCount::AtMostPerThread(rays)).dispatch(threads),
        };
        let pass = inputs.pass(frame, Self::TEMPORAL.stage, &self.temporal, &Self::TEMPORAL).touches_part();
        let pass = tables.bind(pass).push(push).streams(&reuse.points).streams(&reuse.shares);
        let pass = pass.streams_updated(&reuse.reusable).streams_updated(&tables.lights);
        let rays = match self.visibility {
            RestirVisibility::InWeight if push.restir_counts & 0xffff > 0 => 2,
            _ => 0,
        };
        counted(pass, rays)?;

        let pass = inputs.pass(frame, Self::SPATIAL.stage, &self.spatial, &Self::SPATIAL).touches_part();
        let pass = tables.bind(pass).push(push).streams_written(&reuse.points);
        let rays = match self.visibility {
            RestirVisibility::None => 0,
            RestirVisibility::Final => 1,
            RestirVisibility::InWeight => 2 * (push.restir_counts >> 16),
        };
        counted(pass, rays)
    }
}
