use crate::records::GodraysPush;
use crate::{images, kernels};
use pt_core::frame::RayCount;
use pt_core::trace::TraceVariant;
use pt_core::{Device, Frame, Kernel, Result, StageInputs, StageIo, knobs};
use pt_shaders::channels::{INTERIOR, THROUGHPUT, TRANSPARENT, VIEW_DEPTH, VIEW_DIRECTION};
use pt_shaders::dimensions::MAX_GODRAYS_STEPS;
use pt_shaders::records::{GlassShadows, MASK_OPAQUE, MASK_TRANSMISSIVE};

knobs! {
    /// Knobs of the god rays: a homogeneous medium all over the scene that scatters the light of directional lights once.
    pub struct GodraysParams {
        /// Extinction of the medium; 0: there is none, and no pass for it.
        pub density: f32 = 0.0, in 0.0..=10.0, unit "1/m" => structural;
        /// Share of the light taken away that is scattered; the rest is absorbed.
        pub albedo: f32 = 0.9, in 0.0..=1.0;
        /// Mean cosine of the scattering angle: 0 scatters alike in all directions, more makes shafts brighter towards the sun.
        pub anisotropy: f32 = 0.6, in -0.99..=0.99, source "Henyey and Greenstein 1941";
        /// Steps of a march, each with a shadow ray.
        pub steps: u32 = 16, in 1..=MAX_GODRAYS_STEPS;
        /// Distance from the camera at which the medium ends; the sky is behind it.
        pub max_distance: f32 = 100.0, in 1e-3..=1e6, unit "m";
    }
}

impl GodraysParams {
    /// Whether the frame has [`Godrays`].
    pub fn is_on(&self) -> bool {
        self.density > 0.0
    }
}

/// The medium between the camera and what its rays find: extinction, and light of directional lights that is scattered once. It is computed for
/// one of 2 x 2 pixels and filtered to all, after [`crate::PrimaryRays`] and before [`crate::ReflectRefract`]. A stage of its own, absent unless
/// [`GodraysParams::density`] asks for it.
pub struct Godrays {
    march: Kernel,
    filter: Kernel,
}

impl Godrays {
    /// The images that the march accesses.
    pub const MARCH: StageIo = StageIo {
        reads: &[VIEW_DEPTH, VIEW_DIRECTION, INTERIOR],
        writes: &[images::GODRAYS],
        ..StageIo::of("god rays")
    };

    /// The images that the filter accesses.
    pub const FILTER: StageIo = StageIo {
        reads: &[VIEW_DEPTH, INTERIOR, images::GODRAYS],
        updates: &[THROUGHPUT, TRANSPARENT],
        ..StageIo::of("god rays filter")
    };

    /// Compiles the kernels.
    ///
    /// # Errors
    /// When the device refuses them.
    pub fn new(device: &Device, variant: TraceVariant) -> Result<Self> {
        let constants = variant.unseen().constants();
        let march = Kernel::trace::<GodraysPush>(device, &kernels::GODRAYS, variant.backend, &constants)?;
        let constants = [("scene_features", variant.scene_features.into())];
        let filter = Kernel::compute::<GodraysPush>(device, &kernels::GODRAYS_FILTER, &constants)?;
        Self::MARCH.check([&march])?;
        Self::FILTER.check([&filter])?;
        Ok(Self { march, filter })
    }

    /// Records both passes. `glass_shadows`: what becomes of sunlight on its way through glass.
    ///
    /// # Errors
    /// When a pass does not fit into the frame.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        params: &GodraysParams,
        glass_shadows: GlassShadows,
    ) -> Result<()> {
        let push = GodraysPush {
            density: params.density,
            albedo: params.albedo,
            anisotropy: params.anisotropy,
            max_distance: params.max_distance,
            steps: params.steps,
            mask: match glass_shadows {
                GlassShadows::Stopped => MASK_OPAQUE | MASK_TRANSMISSIVE,
                _ => MASK_OPAQUE,
            },
            glass_shadows: glass_shadows.code(),
        };
        let [width, height] = inputs.images.current(images::GODRAYS).extent();
        let march = inputs.pass(frame, Self::MARCH.stage, &self.march, &Self::MARCH);
        let rays = RayCount::AtMostPerThread(params.steps);
        march.touches_part().rays(rays).push(&push).dispatch([width, height, 1])?;
        let filter = inputs.pass(frame, Self::FILTER.stage, &self.filter, &Self::FILTER);
        filter.push(&push).dispatch(inputs.split_threads())
    }
}
