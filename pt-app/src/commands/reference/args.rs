//! Arguments of `pt reference`.

use crate::args::flags::{Flag, FlagSet, Flags};
use crate::args::values::{assignment, not_negative_f64, positive_f64};
use crate::args::{CameraArgs, DeviceArgs, SceneArgs};
use crate::interrupt;
use crate::params::{ReferenceSettings, resolve_reference};
use anyhow::{Result, ensure};
use clap::Args;
use pt_core::settings::{Knob, Knobs};
use pt_image::image_file::ImageSize;
use pt_reference::{ReferenceParams, SamplerKind};
use std::ops::Range;
use std::path::PathBuf;
use std::str::FromStr;

/// `pt reference`
#[derive(Clone, Debug, Args)]
#[command(after_help = interrupt::HELP)]
pub struct ReferenceArgs {
    /// Image to write: an EXR with the layers radiance (unnamed), variance (of the mean), albedo, normal, depth, motion, coverage.
    /// Also writes NAME_0016spp.{hdr,alb,nrm}.exr, the input of Open Image Denoise.
    #[arg(short, long, value_name = "OUT.exr", help_heading = "Output")]
    pub output: PathBuf,
    /// Write only OUT.exr.
    #[arg(long, help_heading = "Output")]
    pub no_aov: bool,
    /// Save the state of the render to this file while it runs, so that --resume can continue it.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub checkpoint: Option<PathBuf>,
    /// Seconds between checkpoints.
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = not_negative_f64, allow_negative_numbers = true, help_heading = "Output")]
    pub checkpoint_interval: f64,
    /// Continue from the checkpoint if it exists. The image has the same bits as without the interruption.
    #[arg(long, requires = "checkpoint", help_heading = "Output")]
    pub resume: bool,

    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The camera.
    #[command(flatten)]
    pub camera: CameraArgs,

    /// Image size in pixels, each side 1 to 16384.
    #[arg(long, value_name = "WxH", default_value = "1280x720", help_heading = "Image")]
    pub size: ImageSize,
    /// Samples per pixel and background.
    #[command(flatten)]
    pub image: Flags<Image>,
    /// Only the samples A to B - 1: a slice of the render. `pt merge` joins slices, which may come from different machines.
    #[arg(long, value_name = "A..B", help_heading = "Image")]
    pub spp_range: Option<SampleRange>,
    /// Stop after this many seconds of rendering and write the samples so far.
    #[arg(long, value_name = "S", value_parser = positive_f64, help_heading = "Image")]
    pub time_limit: Option<f64>,
    /// Seed of all random numbers; another seed gives independent noise.
    #[arg(long, value_name = "S", default_value_t = 0, help_heading = "Image")]
    pub seed: u64,
    /// Size of the tiles that are rendered one after the other [default: whole rows, up to 2 Mpixels]
    #[arg(long, value_name = "WxH", help_heading = "Image")]
    pub tile: Option<ImageSize>,

    /// Light transport.
    #[command(flatten)]
    pub transport: Flags<Transport>,
    /// Initial values of the knobs: a TOML file with a table [reference].
    #[arg(long, value_name = "FILE", help_heading = "Light transport")]
    pub profile: Option<String>,
    /// Set one knob; overrides the profile and the flags above; may be repeated.
    #[arg(long = "set", value_name = "reference.key=value", value_parser = assignment, help_heading = "Light transport")]
    pub set: Vec<String>,

    /// Device and trace backend.
    #[command(flatten)]
    pub device: DeviceArgs,
}

/// The flags for samples and background.
pub struct Image;

impl FlagSet for Image {
    const HEADING: &'static str = "Image";
    const FLAGS: &'static [Flag] = &[
        Flag {
            note: "; with --spp-range those of the whole render",
            ..Flag::new("spp", "reference.spp", "N")
        },
        Flag {
            note: "; transparent writes alpha, and radiance premultiplied by it",
            ..Flag::new("background", "reference.background", "WHAT")
        },
    ];

    fn knobs() -> Vec<Knob> {
        ReferenceSettings::knobs()
    }
}

/// The flags for light transport.
pub struct Transport;

impl FlagSet for Transport {
    const HEADING: &'static str = "Light transport";
    const FLAGS: &'static [Flag] = &[
        Flag::new("max-bounces", "reference.max_bounces", "B"),
        Flag::new("roulette-start", "reference.roulette_start", "B"),
        Flag { note: "Kinds of light", ..Flag::new("light-types", "reference.light_types", "LIST") },
        Flag::new("heuristic", "reference.heuristic", "HEURISTIC"),
        Flag::new("strategy", "reference.strategy", "STRATEGY"),
        Flag::new("sampler", "reference.sampler", "SAMPLER"),
        Flag::new("energy-compensation", "reference.energy_compensation", ""),
        Flag::new("ray-cones", "reference.ray_cones", ""),
        Flag::new("clamp", "reference.clamp", "X"),
    ];

    fn knobs() -> Vec<Knob> {
        ReferenceSettings::knobs()
    }
}

impl ReferenceArgs {
    /// The knobs of the path tracer: those of the profile, then the flags, then the assignments.
    ///
    /// # Errors
    /// An unknown profile, key or value; a slice that goes beyond the samples; one of a render whose sampler needs to know all its samples,
    /// without their number.
    pub fn params(&self) -> Result<ReferenceParams> {
        let over = |base| {
            let sets = [&self.image.sets[..], &self.transport.sets, &self.set].concat();
            Ok::<_, anyhow::Error>(resolve_reference(base, self.profile.as_deref(), &sets)?.reference)
        };
        let default = ReferenceSettings::default();
        let params = over(default.clone())?;
        if let Some(SampleRange(range)) = &self.spp_range {
            // Another default shows through where nobody has said how many there are.
            let mut other = default;
            other.reference.spp += 1;
            let is_said = over(other)?.spp == params.spp;
            ensure!(
                is_said || params.sampler != SamplerKind::BlueNoise,
                "--sampler blue-noise with --spp-range needs --spp, the samples of the whole render"
            );
            ensure!(
                !is_said || range.end <= params.spp,
                "--spp-range {}..{} goes beyond the samples of the whole render, --spp {}",
                range.start,
                range.end,
                params.spp
            );
        }
        Ok(params)
    }

    /// Indices of the samples asked for.
    pub fn sample_range(&self, params: &ReferenceParams) -> Range<u32> {
        self.spp_range.as_ref().map_or(0..params.spp, |range| range.0.clone())
    }
}

/// Sample indices `A..B`, not empty.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SampleRange(pub Range<u32>);

impl FromStr for SampleRange {
    type Err = String;
    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let range =
            text.split_once("..").and_then(|(a, b)| Some(a.trim().parse().ok()?..b.trim().parse().ok()?));
        match range {
            Some(range) if range.start < range.end => Ok(Self(range)),
            Some(_) => Err("the range is empty".into()),
            None => Err("expected A..B, sample indices from 0, B excluded".into()),
        }
    }
}
