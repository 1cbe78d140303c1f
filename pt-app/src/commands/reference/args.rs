//! What `pt reference` takes.

use crate::args::values::positive_f64;
use crate::args::{CameraArgs, DeviceArgs, SceneArgs};
use clap::{Args, ValueEnum};
use pt_image::image_file::ImageSize;
use pt_reference::{Heuristic, LightTypes, ReferenceParams, SamplerKind, Strategy};
use std::ops::Range;
use std::path::PathBuf;
use std::str::FromStr;

/// Samples of a pixel unless told otherwise.
const DEFAULT_SPP: u32 = 64;

/// `pt reference`
#[derive(Clone, Debug, Args)]
pub struct ReferenceArgs {
    /// Image to write: an EXR with the layers radiance (unnamed), variance (of the mean), albedo, normal, depth, motion, coverage.
    /// Beside it NAME_0016spp.{hdr,alb,nrm}.exr as Open Image Denoise takes them.
    #[arg(short, long, value_name = "OUT.exr", help_heading = "Output")]
    pub output: PathBuf,
    /// Write OUT.exr alone.
    #[arg(long, help_heading = "Output")]
    pub no_aov: bool,
    /// Keep the state of the render in this file while it runs, so that --resume can go on with it.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub checkpoint: Option<PathBuf>,
    /// Seconds between checkpoints.
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = clap::value_parser!(f64), help_heading = "Output")]
    pub checkpoint_interval: f64,
    /// Go on from the checkpoint, if it is there: the image gets the same bits as without the interruption.
    #[arg(long, requires = "checkpoint", help_heading = "Output")]
    pub resume: bool,

    /// What is rendered.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The view.
    #[command(flatten)]
    pub camera: CameraArgs,

    /// Image size in pixels, each side 1 to 16384.
    #[arg(long, value_name = "WxH", default_value = "1280x720", help_heading = "Image")]
    pub size: ImageSize,
    /// Samples of each pixel [default: 64]; with --spp-range those of the whole render, which --sampler blue-noise needs to know.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Image")]
    pub spp: Option<u32>,
    /// Only the samples with these indices, for `pt merge`: slices of one render, done anywhere, join to the whole.
    #[arg(long, value_name = "A..B", help_heading = "Image")]
    pub spp_range: Option<SampleRange>,
    /// Stop after this many seconds of rendering, with the samples there are.
    #[arg(long, value_name = "S", value_parser = positive_f64, help_heading = "Image")]
    pub time_limit: Option<f64>,
    /// Seed of all random numbers; another seed gives independent noise.
    #[arg(long, value_name = "S", default_value_t = 0, help_heading = "Image")]
    pub seed: u64,
    /// Part of the image that is worked on at a time [default: whole rows, up to 2 Mpixels]
    #[arg(long, value_name = "WxH", help_heading = "Image")]
    pub tile: Option<ImageSize>,

    /// Scattering events after the first hit, at most; 0: direct light only [default: no limit, Russian roulette ends paths]
    #[arg(long, value_name = "B", help_heading = "Light transport")]
    pub max_bounces: Option<u32>,
    /// Scattering events before Russian roulette begins.
    #[arg(long, value_name = "B", default_value_t = 3, help_heading = "Light transport")]
    pub roulette_start: u32,
    /// Light that counts: any of sun, positional, emissive, environment.
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_enum, help_heading = "Light transport")]
    pub light_types: Vec<LightType>,
    /// Weights of multiple importance sampling.
    #[arg(long, value_enum, default_value_t = HeuristicName::Power, help_heading = "Light transport")]
    pub heuristic: HeuristicName,
    /// Which strategies look for light: one alone shows what the other one is good for.
    #[arg(long, value_enum, default_value_t = StrategyName::Both, help_heading = "Light transport")]
    pub strategy: StrategyName,
    /// Where random numbers come from.
    #[arg(long, value_enum, default_value_t = SamplerName::Sobol, help_heading = "Light transport")]
    pub sampler: SamplerName,
    /// Give back what rough metals lose between their microfacets; without it the BSDF is that of glTF 2.0, appendix B.
    #[arg(long, help_heading = "Light transport")]
    pub energy_compensation: bool,
    /// BIASED: filter textures over the footprint of a ray cone, as the real-time stages do [default: read at their finest level]
    #[arg(long, help_heading = "Light transport")]
    pub ray_cones: bool,
    /// BIASED: largest radiance of a sample, per channel, against fireflies [default: no limit]
    #[arg(long, value_name = "X", value_parser = positive_f64, help_heading = "Light transport")]
    pub clamp: Option<f64>,

    /// Where it runs.
    #[command(flatten)]
    pub device: DeviceArgs,
}

impl ReferenceArgs {
    /// The knobs of the path tracer.
    pub fn params(&self) -> ReferenceParams {
        let on = |kind| self.light_types.is_empty() || self.light_types.contains(&kind);
        let defaults = ReferenceParams::default();
        ReferenceParams {
            max_bounces: self.max_bounces.unwrap_or(defaults.max_bounces),
            roulette_start: self.roulette_start,
            light_types: LightTypes {
                sun: on(LightType::Sun),
                positional: on(LightType::Positional),
                emissive: on(LightType::Emissive),
                environment: on(LightType::Environment),
            },
            heuristic: match self.heuristic {
                HeuristicName::Balance => Heuristic::Balance,
                HeuristicName::Power => Heuristic::Power,
            },
            strategy: match self.strategy {
                StrategyName::Both => Strategy::Both,
                StrategyName::Lights => Strategy::Lights,
                StrategyName::Bsdf => Strategy::Bsdf,
            },
            spp: if self.sampler == SamplerName::BlueNoise {
                self.spp.unwrap_or(self.samples().end)
            } else {
                1
            },
            sampler: match self.sampler {
                SamplerName::Sobol => SamplerKind::Sobol,
                SamplerName::BlueNoise => SamplerKind::BlueNoise,
                SamplerName::Pcg => SamplerKind::Pcg,
            },
            energy_compensation: self.energy_compensation,
            ray_cones: self.ray_cones,
            clamp: self.clamp.map_or(defaults.clamp, |clamp| clamp as f32),
        }
    }

    /// Indices of the samples asked for.
    pub fn samples(&self) -> Range<u32> {
        self.spp_range.as_ref().map_or(0..self.spp.unwrap_or(DEFAULT_SPP), |range| range.0.clone())
    }
}

/// Sample indices `A..B`, not empty.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SampleRange(pub Range<u32>);

impl FromStr for SampleRange {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let range =
            text.split_once("..").and_then(|(a, b)| Some(a.trim().parse().ok()?..b.trim().parse().ok()?));
        match range {
            Some(range) if range.start < range.end => Ok(Self(range)),
            Some(_) => Err("the range is empty".into()),
            None => Err("expected A..B, sample indices from 0, B excluded".into()),
        }
    }
}

/// Kinds of light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LightType {
    /// Directional lights.
    Sun,
    /// Point and spot lights.
    Positional,
    /// Surfaces that emit, unlit materials included.
    Emissive,
    /// The environment.
    Environment,
}

/// Weights of multiple importance sampling.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum HeuristicName {
    /// In proportion to the densities.
    Balance,
    /// In proportion to their squares.
    Power,
}

/// Strategies that look for light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StrategyName {
    /// Both, weighted.
    Both,
    /// Light sampling.
    Lights,
    /// BSDF sampling.
    Bsdf,
}

/// Sources of random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SamplerName {
    /// Owen-scrambled Sobol points.
    Sobol,
    /// The same with the error spread over pixels as blue noise.
    BlueNoise,
    /// Independent numbers.
    Pcg,
}
