//! The stages by name, and those that need a scene.

use crate::session::join;
use pt_core::trace::TraceVariant;
use pt_core::{Device, Result};
use pt_gbuffer::{PrimaryRays, ReflectRefract};
use pt_lights::{DirectLighting, DirectParams};
use pt_shaders::named_enum;
use std::thread;

named_enum! {
    /// The stages that a replay can start at, in the order of the frame.
    pub enum Stage {
        /// Denoiser and composite of the light channels.
        Denoise = "denoise",
        /// Interleave of the checkerboard fields.
        Checkerboard = "checkerboard",
        /// Temporal anti-aliasing, bloom, exposure, tone map, FSR 1.
        Post = "post",
    }
}

impl Stage {
    /// Whether a frame that starts at stage `first` has this one.
    pub(super) fn is_in(self, first: Self) -> bool {
        first.code() <= self.code()
    }
}

/// The stages that trace rays: they need a scene.
pub(super) struct TracedStages {
    pub(super) primary: PrimaryRays,
    pub(super) reflect_refract: ReflectRefract,
    pub(super) direct: DirectLighting,
}

impl TracedStages {
    /// Compiles their kernels side by side.
    pub(super) fn new(device: &Device, variant: TraceVariant, lights: &DirectParams) -> Result<Self> {
        thread::scope(|threads| {
            // Kernels that trace rays take the most time to compile.
            let reflect_refract = threads.spawn(|| ReflectRefract::new(device, variant));
            let direct = threads.spawn(|| DirectLighting::new(device, variant, lights));
            Ok(Self {
                primary: PrimaryRays::new(device, variant)?,
                reflect_refract: join(reflect_refract)?,
                direct: join(direct)?,
            })
        })
    }
}
