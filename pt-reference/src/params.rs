use crate::oracle::sampler::SamplerKind;
use pt_core::settings::{InvalidValue, Validate, check_range};
use serde::{Deserialize, Serialize};

/// How shares are given to light sampling and BSDF sampling (Veach 1997, section 9.2.2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Heuristic {
    /// In proportion to the densities.
    Balance,
    /// In proportion to their squares.
    #[default]
    Power,
}

/// Which strategies look for light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Strategy {
    /// Light sampling and BSDF sampling, combined by the heuristic.
    #[default]
    Both,
    /// Light sampling; BSDF sampling only where it alone can find the light (delta lobes, unlisted emission).
    Lights,
    /// BSDF sampling; light sampling only of delta lights.
    Bsdf,
}

/// Which light counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LightTypes {
    /// Directional lights.
    pub sun: bool,
    /// Point and spot lights.
    pub positional: bool,
    /// Emission of surfaces, unlit materials included.
    pub emissive: bool,
    /// The environment.
    pub environment: bool,
}

impl Default for LightTypes {
    fn default() -> Self {
        Self { sun: true, positional: true, emissive: true, environment: true }
    }
}

/// Knobs of the reference path tracer. The defaults are unbiased.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReferenceParams {
    /// Scattering events after the first hit, at most; 0: direct light only. Default 4294967295, that is no limit.
    pub max_bounces: u32,
    /// Scattering events before Russian roulette begins; survival is the largest component of the throughput, kept in
    /// 0.05 to 0.95. Default 3.
    pub roulette_start: u32,
    /// Light that counts. Default: all.
    pub light_types: LightTypes,
    /// Weights of multiple importance sampling. Default power.
    pub heuristic: Heuristic,
    /// Strategies that look for light. Default both.
    pub strategy: Strategy,
    /// Source of random numbers. Default sobol.
    pub sampler: SamplerKind,
    /// Samples that a pixel gets in all, for the blue-noise sampler, which spreads the error of that many; 1 or more,
    /// default 1.
    pub spp: u32,
    /// Give back what microfacet models without interreflection lose. Default false: the BSDF is that of glTF 2.0,
    /// appendix B.
    pub energy_compensation: bool,
    /// Filter textures over the footprint of a ray cone, as real-time stages do; biased. Default false: they are read at their
    /// finest level.
    pub ray_cones: bool,
    /// Largest radiance of a sample, per channel; biased. 0 or more, default 0: no limit.
    pub clamp: f32,
}

impl Default for ReferenceParams {
    fn default() -> Self {
        Self {
            max_bounces: u32::MAX,
            roulette_start: 3,
            light_types: LightTypes::default(),
            heuristic: Heuristic::default(),
            strategy: Strategy::default(),
            sampler: SamplerKind::default(),
            spp: 1,
            energy_compensation: false,
            ray_cones: false,
            clamp: 0.0,
        }
    }
}

impl Validate for ReferenceParams {
    fn validate(&self) -> Result<(), InvalidValue> {
        check_range("spp", self.spp, 1..=u32::MAX, "samples")?;
        check_range("clamp", self.clamp, 0.0..=f32::MAX, "radiance")
    }
}
