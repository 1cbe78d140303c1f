//! The knobs of direct lighting.

use crate::records::{
    DirectPush, EnvironmentRays, LightRays, LightStorage, NeeAtPdf, PartialMetal, RestirVisibility,
    RestirWeights,
};
use pt_core::knobs;
use pt_core::pack::pack_unorm2x16;
use pt_light_sampling::SamplerChoice;
use pt_light_sampling::records::{ListVisibility, StatisticsTable};
use pt_shaders::records::{
    AreaSampling, BvhImportance, EmissionShare, GlassShadows, KIND_EMISSIVE, KIND_ENVIRONMENT, KIND_LOCAL,
    KIND_POSITIONAL, KIND_SUN, LightSampler, MASK_OPAQUE, MASK_TRANSMISSIVE, RisSource,
};

knobs! {
    /// Knobs of direct lighting. A kind of light that is off is not sampled, its light is missing.
    pub struct DirectParams {
        /// Whether directional lights give light.
        pub sun: bool = true;
        /// Whether point and spot lights give light.
        pub positional: bool = true;
        /// Whether emissive triangles give light.
        pub emissive: bool = true;
        /// Whether the environment gives light.
        pub environment: bool = true;
        /// What becomes of the light on its way through transmissive surfaces, which is not bent: `caustics` is the light that is.
        pub glass_shadows: GlassShadows = GlassShadows::Tinted;
        /// Whether photons carry the light of directional lights that smooth glass bends or mirrors to the surfaces that it lights; such glass stops the
        /// shadow rays of the sun then.
        pub caustics: bool = false, source "Jensen 1996" => structural;
        /// Photons of a frame.
        pub caustics_photons: u32 = 262_144, in 1024..=4_194_304 => structural;
        /// Edge of the cells that photons are gathered in, the width of the blur.
        pub caustics_cell: f32 = 0.02, in 1e-4..=1e3, unit "m";
        /// How materials of metalness between 0 and 1 are shaded.
        pub partial_metal: PartialMetal = PartialMetal::TwoBrdfs, source "glTF 2.0, appendix B.2";
        /// Perceptual roughness up to which a second ray, in a direction that the surface reflects, looks for the environment: sampling the
        /// environment alone does not find narrow lobes.
        pub reflection_roughness: f32 = 0.3, in 0.0..=1.0, source "Veach 1997, section 9.2";
        /// How many shadow rays a sample has for local lights: emissive triangles, point and spot lights.
        pub rays: LightRays = LightRays::Merged => structural;
        /// Whether the environment has a shadow ray of its own, or is, with `rays=merged`, a part of the lights that `sampler` picks from, as quads.
        pub environment_rays: EnvironmentRays = EnvironmentRays::Own => structural;
        /// Share of the samples of the environment that go through the portals of the scene, such as windows, if it has any; with
        /// `environment_rays=own`.
        pub portal_share: f32 = 0.5, in 0.0..=0.95;
        /// Share of the samples of the environment that are drawn by the cosine of the surface instead of by radiance, which finds skies that are seen
        /// through few openings; with `environment_rays=own`.
        pub cosine_share: f32 = 0.5, in 0.0..=0.95, source "Veach 1997, section 9.2";
        /// How a local light is picked with `rays=merged`.
        pub sampler: LightSampler = LightSampler::LightBvh => structural;
        /// How points of emissive triangles are drawn with `rays=merged`.
        pub area_sampling: AreaSampling = AreaSampling::Spherical => structural;
        /// Light samples a pixel, each with its own shadow rays.
        pub samples: u32 = 1, in 1..=64;
        /// With which precision the light channels, whose format stays, are stored; `rgbe` shows what 4 bytes a pixel cost instead of 12.
        pub storage: LightStorage = LightStorage::Fp32 => structural;
        /// Frames that shadow statistics reach back: 1 counts the last frame alone, more are an exponential mean of about that length.
        pub statistics_frames: u32 = 16, in 1..=256, unit "frames" => structural;
        /// Frames between two visits of a cluster, in which its counts join the statistics and the subsets of its list get their weights.
        pub statistics_interval: u32 = 4, in 1..=64, unit "frames" => structural;
        /// How shadow statistics are stored.
        pub statistics_table: StatisticsTable = StatisticsTable::Auto => structural;
        /// How important a node of the tree of `sampler=light-bvh` is for a shading point.
        pub bvh_importance: BvhImportance = BvhImportance::SphericalGaussian, source "Conty Estevez and Kulla 2018; Tokuyoshi et al. 2024" => structural;
        /// Where the candidates of `sampler=ris` come from.
        pub ris_source: RisSource = RisSource::Cluster => structural;
        /// Candidates of `sampler=ris`.
        pub ris_candidates: u32 = 8, in 1..=16, source "Talbot, Cline and Egbert 2005";
        /// Whether the random numbers that choose these candidates are spread evenly over the lights.
        pub ris_stratified: bool = true;
        /// Whether `sampler=restir-di` reuses the last frame's samples, where the surface was seen.
        pub restir_temporal: bool = true, source "Bitterli et al. 2020, section 4.2";
        /// How much the past of `sampler=restir-di` counts at most: more means less noise that changes more slowly.
        pub restir_history: u32 = 20, in 1..=64, unit "times ris_candidates", source "Bitterli et al. 2020, section 5";
        /// Neighbours whose samples `sampler=restir-di` reuses.
        pub restir_spatial: u32 = 3, in 0..=8, source "Bitterli et al. 2020, section 4.1";
        /// How far neighbours of `sampler=restir-di` are at most.
        pub restir_radius: f32 = 30.0, in 1.0..=128.0, unit "pixels", source "Bitterli et al. 2020, section 5";
        /// How `sampler=restir-di` weights the samples that it reuses; `one-over-m` is biased.
        pub restir_weights: RestirWeights = RestirWeights::Pairwise, source "Lin et al. 2022, section 5";
        /// Which shadow rays `sampler=restir-di` traces; `final` is biased.
        pub restir_visibility: RestirVisibility = RestirVisibility::None, source "Bitterli et al. 2020, section 4.3" => structural;
        /// Candidates of a sample of `sampler=nee-at`, of which the estimate of their light chooses one; 1: the first is taken.
        pub nee_at_candidates: u32 = 8, in 1..=16;
        /// Share of the candidates that are drawn from what the pixel's tile has learned, once it has learned much.
        pub nee_at_narrow: f32 = 0.8, in 0.0..=0.95;
        /// Share of the other candidates that are drawn uniformly from all lights; the rest by power.
        pub nee_at_uniform: f32 = 0.0, in 0.0..=1.0;
        /// Share of a tile's proxies that come from anywhere in every frame: half of them by power, half from the lists of any tiles.
        pub nee_at_global_share: f32 = 0.0625, in 0.0..=1.0;
        /// Share of its other proxies that are kept from the last frame.
        pub nee_at_history: f32 = 0.75, in 0.0..=0.95;
        /// Which probability of a light `sampler=nee-at` puts into the weights of multiple importance sampling.
        pub nee_at_pdf: NeeAtPdf = NeeAtPdf::Exact => structural;
        /// Whether `sampler=nee-at` also learns from the rays in directions that a surface reflects, with `environment_rays=list`: such a ray
        /// may find a part of the sky that no light sample has found.
        pub nee_at_bsdf_feedback: bool = false;
        /// Whether the lists of clusters (`cluster-cdf`, `cluster-stats`, and `ris` and `restir-di` with `ris_source=cluster`) leave out lights
        /// that rays, when the lists are built, do not find from the cluster; what is left out by mistake keeps a small probability.
        pub list_visibility: ListVisibility = ListVisibility::Off => structural;
        /// Whether pixels that have last frame's random seed take its light sample again (gradient pixels of a denoiser); not with
        /// `sampler=restir-di` and `nee-at`.
        pub replay: bool = false, source "Schied, Peters and Dachsbacher 2018, section 4" => structural;
    }
}

impl DirectParams {
    /// What [`LightTables::prepare`](pt_light_sampling::LightTables::prepare) takes.
    pub fn sampler_choice(&self) -> Option<SamplerChoice> {
        let Self { sampler, ris_source, list_visibility, statistics_table, .. } = *self;
        let Self { statistics_frames, statistics_interval, .. } = *self;
        let environment_listed = self.is_environment_listed();
        let merged = self.rays == LightRays::Merged;
        merged.then_some(SamplerChoice {
            sampler,
            ris_source,
            list_visibility,
            statistics_table,
            statistics_frames,
            statistics_interval,
            environment_listed,
        })
    }

    /// Whether the environment is among the lights that the sampler picks from.
    pub(crate) fn is_environment_listed(&self) -> bool {
        self.rays == LightRays::Merged && self.environment_rays == EnvironmentRays::List
    }

    /// Whether gradient pixels take their light sample of the last frame again: `replay` is on, and the sampler can do it. If so,
    /// [`LightTables::keep_last_frame`](pt_light_sampling::LightTables::keep_last_frame) is asked for before the tables are prepared.
    pub fn replays(&self) -> bool {
        self.replay && (self.rays == LightRays::PerKind || self.sampler.replays())
    }

    /// Whether the stage keeps reservoirs.
    pub(crate) fn is_restir(&self) -> bool {
        self.rays == LightRays::Merged && self.sampler == LightSampler::RestirDi
    }

    /// The kernel's push constants.
    pub fn push(&self, texture_lod_bias: f32) -> DirectPush {
        let bit = |on: bool, kind: u32| if on { kind } else { 0 };
        let merged = self.rays == LightRays::Merged;
        DirectPush {
            counts: 0,
            choices: 0,
            nee_at_tiles: 0,
            nee_at_feedback: 0,
            shadow_rays: 0,
            kinds: bit(self.sun, KIND_SUN)
                | bit(self.positional, KIND_POSITIONAL)
                | bit(self.emissive, KIND_EMISSIVE)
                | bit(merged, KIND_LOCAL)
                | bit(self.environment, KIND_ENVIRONMENT),
            mask: match self.glass_shadows {
                GlassShadows::Stopped => MASK_OPAQUE | MASK_TRANSMISSIVE,
                _ => MASK_OPAQUE,
            },
            glass_shadows: self.glass_shadows.code(),
            mixed: u32::from(self.partial_metal == PartialMetal::MixedParameters),
            reflection_roughness: self.reflection_roughness,
            lod_scale: texture_lod_bias.exp2(),
            samples: self.samples,
            ris_candidates: self.ris_candidates,
            ris_stratified: u32::from(self.ris_stratified),
            restir_history: if self.restir_temporal { self.restir_history } else { 0 },
            restir_spatial: self.restir_spatial,
            restir_radius: self.restir_radius,
            restir_weights: self.restir_weights.code(),
            restir_visibility: self.restir_visibility.code(),
            nee_at_candidates: self.nee_at_candidates,
            light_sample: 0,
            ray_columns: 0,
            emission_share: EmissionShare::LightSamples.code(),
            nee_at_bsdf_feedback: u32::from(self.nee_at_bsdf_feedback),
            environment_shares: pack_unorm2x16(self.cosine_share, self.portal_share),
        }
    }
}
