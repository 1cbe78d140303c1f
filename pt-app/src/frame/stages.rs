//! The stages by name, and those that need a scene.

use crate::session::join;
use pt_core::trace::TraceBackend;
use pt_core::{Device, Result};
use pt_gbuffer::{PrimaryRays, ReflectRefract};
use pt_lights::DirectLighting;
use std::thread;

/// The stages of the frame that have a crate of their own, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, clap::ValueEnum)]
pub enum Stage {
    /// Composite of the light channels.
    Denoise,
    /// Interleave of the checkerboard fields.
    Checkerboard,
    /// Temporal anti-aliasing, bloom, exposure, tone map, FSR 1.
    Post,
}

/// The stages that trace rays: they need a scene.
pub(super) struct TracedStages {
    pub(super) primary: PrimaryRays,
    pub(super) reflect_refract: ReflectRefract,
    pub(super) direct: DirectLighting,
}

impl TracedStages {
    /// Compiles their kernels side by side.
    pub(super) fn new(device: &Device, backend: TraceBackend) -> Result<Self> {
        thread::scope(|threads| {
            // Kernels that trace rays take the most time to compile.
            let reflect_refract = threads.spawn(|| ReflectRefract::new(device, backend));
            let direct = threads.spawn(|| DirectLighting::new(device, backend));
            Ok(Self {
                primary: PrimaryRays::new(device, backend)?,
                reflect_refract: join(reflect_refract)?,
                direct: join(direct)?,
            })
        })
    }
}
