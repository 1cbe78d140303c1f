//! Knobs of the reference path tracer.

use crate::records::{Heuristic, PathLights, Strategy};
use pt_core::{Device, Result, knobs};
use pt_light_sampling::{LightTables, SamplerChoice};
use pt_scene::Scene;
use pt_scene::gpu::GpuScene;
use pt_shaders::records::{Background, Culling, LightSampler, SamplerKind};

knobs! {
    /// Which light counts.
    #[derive(Copy)]
    pub struct LightTypes {
        /// Whether directional lights count.
        pub sun: bool = true => structural;
        /// Whether point and spot lights count.
        pub positional: bool = true => structural;
        /// Whether the emission of surfaces counts, unlit materials included.
        pub emissive: bool = true => structural;
        /// Whether the environment counts.
        pub environment: bool = true => structural;
    }
}

knobs! {
    /// A homogeneous medium between the camera and what its rays find, as the frame's god rays have it.
    #[derive(Copy)]
    pub struct MediumParams {
        /// Extinction of the medium; 0: there is none.
        pub density: f32 = 0.0, in 0.0..=10.0, unit "1/m" => structural;
        /// Share of the light taken away that is scattered, once; the rest is absorbed.
        pub albedo: f32 = 0.9, in 0.0..=1.0 => structural;
        /// Mean cosine of the scattering angle.
        pub anisotropy: f32 = 0.6, in -0.99..=0.99, source "Henyey and Greenstein 1941" => structural;
        /// Distance from the camera at which the medium ends; the sky is behind it.
        pub max_distance: f32 = 100.0, in 1e-3..=1e6, unit "m" => structural;
    }
}

knobs! {
    /// Knobs of the reference path tracer. The defaults are unbiased.
    pub struct ReferenceParams {
        /// Maximum number of scattering events after the first hit: 0 is direct light only, none is no limit.
        pub max_bounces: Option<u32> = None, in 0..=u32::MAX;
        /// Scattering events before Russian roulette begins; survival is the largest component of the throughput, kept in 0.05 to 0.95.
        pub roulette_start: u32 = 3, in 0..=u32::MAX, source "Arvo and Kirk 1990";
        /// Kinds of light that are included.
        pub light_types: LightTypes;
        /// A medium that scatters sunlight.
        pub medium: MediumParams;
        /// Which rays go through the back faces of single-sided materials.
        pub culling: Culling = Culling::Camera, source "glTF 2.0, section 3.9.6" => structural;
        /// What is seen where a camera ray meets no surface.
        pub background: Background = Background::Environment => structural;
        /// Weights of multiple importance sampling.
        pub heuristic: Heuristic = Heuristic::Power, source "Veach 1997, section 9.2.2";
        /// Sampling strategies: both, or one alone, to see what the other one contributes.
        pub strategy: Strategy = Strategy::Both, source "Veach 1997, section 9.2";
        /// How light sampling picks a light; all choices have the same mean, and differ in noise where there are many lights; where there are not two to choose
        /// from, all are per-kind.
        pub lights: PathLights = PathLights::LightBvh, source "Conty Estevez and Kulla 2018" => structural;
        /// Where random numbers come from.
        pub sampler: SamplerKind = SamplerKind::Sobol => structural;
        /// Samples per pixel; the sampler `blue-noise` is made for this number.
        pub spp: u32 = 64, in 1..=u32::MAX;
        /// Whether the light of multiple scattering between microfacets is added, which the single-scattering BSDF loses; without, the BSDF
        /// is that of glTF 2.0, appendix B.
        pub energy_compensation: bool = false, source "Kulla and Conty 2017" => structural;
        /// BIASED: textures are filtered over the footprint of a ray cone, as in the real-time stages; otherwise their finest level is read.
        pub ray_cones: bool = false, source "Akenine-Möller et al. 2021" => structural;
        /// BIASED: largest radiance of a sample, per channel, against fireflies; 0 is no limit.
        pub clamp: f32 = 0.0, in 0.0..=f32::MAX, unit "radiance";
    }
}

impl PathLights {
    fn sampler(self) -> Option<LightSampler> {
        match self {
            Self::PerKind => None,
            Self::Uniform => Some(LightSampler::Uniform),
            Self::Power => Some(LightSampler::Power),
            Self::ClusterCdf => Some(LightSampler::ClusterCdf),
            Self::LightBvh => Some(LightSampler::LightBvh),
        }
    }
}

impl ReferenceParams {
    /// The sampler of local lights (triangles, points, spots) as one kind. `None`: kinds are kept apart, as asked for, because there are not two lights to
    /// choose from, or because `light_types` leaves out some of them, which the sampler would pick in vain.
    pub(crate) fn light_sampler(&self, lights: &LightTables) -> Option<LightSampler> {
        let (lists, types) = (lights.lists(), self.light_types);
        let has_positional = lists.lights.len() > lists.sun_count as usize;
        let all_count =
            (types.emissive || lists.emissives.is_empty()) && (types.positional || !has_positional);
        self.lights.sampler().filter(|_| lists.local.len() > 1 && all_count)
    }

    /// Makes the tables that the choice of lights reads, none where it needs none; before a path tracer is made.
    ///
    /// # Errors
    /// When the device has no memory left.
    pub fn prepare_lights(
        &self,
        device: &Device,
        scene: &Scene,
        gpu: &mut GpuScene,
        lights: &mut LightTables,
    ) -> Result<()> {
        let choice = self.light_sampler(lights).map(SamplerChoice::from);
        lights.prepare(device, scene, gpu, choice)
    }
}
