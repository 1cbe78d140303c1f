//! The stages by name, and those that need a scene.

use crate::params::FrameParams;
use crate::session::join;
use pt_core::trace::TraceVariant;
use pt_core::{Device, Result, TableWish};
use pt_denoise::GradientPixels;
use pt_gbuffer::{Effects, Godrays, PrimaryRays, ReflectRefract, ReplacedMotion};
use pt_indirect::{BounceLights, IndirectLighting};
use pt_lights::records::LightRays;
use pt_lights::{DirectLighting, DirectParams, caustic_targets};
use pt_scene::Scene;
use pt_shaders::records::LightSampler;
use pt_shaders::{NamedEnum, named_enum};
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

named_enum! {
    /// The stages of the frame, in its order; those with knobs are named as their tables of knobs.
    pub enum FrameStage {
        /// What comes before the stages: uploads, moving geometry, tables of lights.
        Scene = "scene",
        /// Primary rays, mirrors and glass.
        Gbuffer = "gbuffer",
        /// Direct lighting.
        Lights = "lights",
        /// Indirect lighting.
        Indirect = "indirect",
        /// Denoiser with its gradient pixels, and composite.
        Denoise = "denoise",
        /// Interleave of the checkerboard fields.
        Checkerboard = "checkerboard",
        /// Temporal anti-aliasing, bloom, exposure, tone map, FSR 1.
        Post = "post",
    }
}

impl FrameStage {
    /// Where a replay starts that runs this stage without rays, if it needs none.
    pub fn replayed(self) -> Option<Stage> {
        Stage::from_name(self.name()).ok()
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
    /// Absent in scenes without effects.
    pub(super) effects: Option<Effects>,
    /// Absent without a medium.
    pub(super) godrays: Option<Godrays>,
    pub(super) reflect_refract: ReflectRefract,
    /// Absent unless knobs ask for it.
    pub(super) replaced_motion: Option<ReplacedMotion>,
    /// Absent without a denoiser that needs them.
    pub(super) gradient_pixels: Option<GradientPixels>,
    pub(super) direct: DirectLighting,
    /// Absent without bounces.
    pub(super) indirect: Option<IndirectLighting>,
}

impl TracedStages {
    /// Compiles their kernels side by side.
    pub(super) fn new(
        device: &Device,
        variant: TraceVariant,
        scene: &Scene,
        has_planes: bool,
        params: &FrameParams,
    ) -> Result<Self> {
        let FrameParams { indirect, .. } = params;
        let lights = &params.direct();
        thread::scope(|threads| {
            // Kernels that trace rays take the most time to compile.
            let layers = params.gbuffer.effect_layers;
            let bounces = indirect.is_on().then(|| {
                let lights = bounce_lights(lights);
                threads.spawn(move || IndirectLighting::new(device, variant, lights, indirect, layers))
            });
            let reflect_refract =
                threads.spawn(move || ReflectRefract::new(device, variant, has_planes, layers));
            let effects = Effects::are_in(variant.scene_features)
                .then(|| threads.spawn(move || Effects::new(device, variant, layers)));
            let godrays =
                params.gbuffer.godrays.is_on().then(|| threads.spawn(|| Godrays::new(device, variant)));
            let gradient_pixels = params
                .has_gradient_pixels()
                .then(|| threads.spawn(|| GradientPixels::new(device, variant, &params.denoise)));
            let targets = if lights.caustics { caustic_targets(scene) } else { Vec::new() };
            let direct =
                threads.spawn(move || DirectLighting::with_caustics(device, variant, lights, &targets));
            let mut stages = Self {
                primary: PrimaryRays::new(device, variant)?,
                effects: effects.map(join).transpose()?,
                godrays: godrays.map(join).transpose()?,
                reflect_refract: join(reflect_refract)?,
                replaced_motion: (params.gbuffer.searches_motion())
                    .then(|| ReplacedMotion::new(device, variant))
                    .transpose()?,
                gradient_pixels: gradient_pixels.map(join).transpose()?,
                direct: join(direct)?,
                indirect: bounces.map(join).transpose()?,
            };
            stages.direct.leave_to_bounce_rays(indirect.left_by_direct_light(&bounce_lights(lights)));
            Ok(stages)
        })
    }

    /// The tables that they declare, in frames of `size` pixels.
    pub(super) fn tables(&self, size: [u32; 2], params: &FrameParams) -> Vec<TableWish> {
        let mut tables = DirectLighting::tables(size, &params.lights);
        tables.extend(self.indirect.iter().flat_map(|stage| stage.tables(size, &params.indirect)));
        tables
    }
}

/// The surfaces that bounce rays meet are lit as those of the G-buffer are. Without one sampler for all local lights these are picked by
/// power.
pub fn bounce_lights(params: &DirectParams) -> BounceLights {
    let push = params.push(0.0);
    let merged = params.rays == LightRays::Merged;
    BounceLights {
        kinds: push.kinds,
        sampler: if merged { params.sampler } else { LightSampler::Power },
        area_sampling: params.area_sampling,
        bvh_importance: params.bvh_importance,
        ris_source: params.ris_source,
        ris_candidates: params.ris_candidates,
        ris_stratified: params.ris_stratified,
        shadow_mask: push.mask,
        glass_shadows: params.glass_shadows,
        replays: params.replays(),
    }
}
