//! The command line: what each command takes, with ranges checked before any work begins.

use std::path::PathBuf;
use std::str::FromStr;

use crate::bench_post::BenchPostArgs;
use crate::cli_reference::{MergeArgs, ReferenceArgs};
use crate::output::Output;
use crate::post_args::PostArgs;
pub use crate::scene_args::{LoadArgs, SceneArgs};
use clap::{Args, Parser, Subcommand, ValueEnum};
use pt_core::atomic_file::check_writable;
use pt_core::image_file::{ImageSize, OutputFormat};
use pt_core::metrics::Metric;

/// Research workbench for real-time path tracing.
#[derive(Debug, Parser)]
#[command(name = "pt", version, about, after_help = EXIT_CODES)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXIT_CODES: &str = "Exit codes: 0 done, 1 a check failed, 2 wrong usage or environment.";

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Devices, drivers, trace backends and what `auto` chooses.
    Info(InfoArgs),
    /// The built-in scenes, or what is in a scene.
    Scenes(ScenesArgs),
    /// The passes of the frame in order: what each reads, writes and moves.
    Passes(PassesArgs),
    /// Measure.
    Bench(BenchArgs),
    /// Render frames of a scene.
    Render(Box<RenderArgs>),
    /// Ground truth: path trace a scene without bias.
    Reference(Box<ReferenceArgs>),
    /// Join slices of one render of `pt reference`.
    Merge(MergeArgs),
    /// Compress a scene's textures ahead of time, for `pt render --baked`.
    Bake(BakeArgs),
    /// Measure an image against its reference.
    Compare(CompareArgs),
    /// Put many images on one sheet, with their names.
    Sheet(SheetArgs),
}

/// `pt scenes`
#[derive(Clone, Debug, Args)]
#[command(mut_group("LoadArgs", |options| options.requires("stats")))]
pub struct ScenesArgs {
    /// Say what is in this scene: a glTF or GLB file, or the name of a built-in scene.
    #[arg(long, value_name = "SCENE")]
    pub stats: Option<String>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
    /// Number of clusters to divide the scene into, 1 to 4096.
    #[arg(long, value_name = "N", default_value_t = pt_scene::Clusters::DEFAULT as u32, value_parser = clap::value_parser!(u32).range(1..=pt_scene::Clusters::MAX as i64), requires = "stats")]
    pub clusters: u32,
    /// How the scene is read.
    #[command(flatten)]
    pub load: LoadArgs,
}

/// `pt sheet`
#[derive(Clone, Debug, Args)]
pub struct SheetArgs {
    /// PNG, JPEG, EXR or HDR images; a .txt file becomes a tile with its text.
    #[arg(required = true)]
    pub images: Vec<PathBuf>,
    /// Sheet to write.
    #[arg(short, long, value_name = "OUT.png")]
    pub output: PathBuf,
    /// Tiles in a row [default: as square a sheet as can be]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub columns: Option<u32>,
    /// Size of a tile without its label, pixels.
    #[arg(long, value_name = "WxH", default_value = "256x192")]
    pub tile: ImageSize,
}

/// `pt info`
#[derive(Clone, Debug, Args)]
pub struct InfoArgs {
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
    /// Only this Vulkan device, by index or part of its name [default: all]
    #[arg(long, value_name = "D")]
    pub device: Option<String>,
}

/// `pt passes`
#[derive(Clone, Debug, Args)]
pub struct PassesArgs {
    /// Print JSON instead of a table.
    #[arg(long)]
    pub json: bool,
    /// Image size that extents and bytes are given for.
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    pub size: ImageSize,
    /// glTF or GLB file, or the name of a built-in scene: animated ones have passes of their own.
    #[arg(long, value_name = "S", default_value = "cornell")]
    pub scene: String,
    /// With the pass that averages frames.
    #[arg(long)]
    pub accumulate: bool,
    /// Set one parameter; may be repeated.
    #[arg(long = "set", value_name = "stage.key=value", value_parser = assignment)]
    pub set: Vec<String>,
    /// How rays are traced.
    #[arg(long, value_name = "B", value_enum, default_value_t = BackendChoice::Compute)]
    pub backend: BackendChoice,
    /// Vulkan device, by index or part of its name.
    #[arg(long, value_name = "D")]
    pub device: Option<String>,
}

/// `pt bake`
#[derive(Clone, Debug, Args)]
pub struct BakeArgs {
    /// glTF or GLB file.
    pub scene: PathBuf,
    /// Folder for the DDS files; made when it is not there, may serve several scenes.
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// How long the encoder searches; best takes three times as long and is some 2 dB better on hard images.
    #[arg(long, value_name = "Q", value_enum, default_value_t = QualityChoice::Fast)]
    pub quality: QualityChoice,
    /// Most texels that an image may have.
    #[arg(long, value_name = "N", default_value_t = pt_scene::DEFAULT_MAX_TEXTURE_PIXELS)]
    pub max_texture_pixels: u64,
    /// Print JSON instead of a table.
    #[arg(long)]
    pub json: bool,
}

/// How long the encoder searches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum QualityChoice {
    /// A third of the time.
    Fast,
    /// Better on hard images.
    Best,
}

/// `pt bench`
#[derive(Clone, Debug, Args)]
pub struct BenchArgs {
    /// What to measure.
    #[command(subcommand)]
    pub command: BenchCommand,
}

/// The benchmarks.
#[derive(Clone, Debug, Subcommand)]
pub enum BenchCommand {
    /// Rays per second of every trace backend, on the same primary, bounce and shadow rays.
    Trace(BenchTraceArgs),
    /// GPU time, bytes and share of the copy bandwidth of every pass from the interleave to the picture.
    Post(BenchPostArgs),
    /// Paths and rays per second of the reference path tracer, beside the CPU tracing as many rays.
    Path(Box<BenchPathArgs>),
}

/// `pt bench path`
#[derive(Clone, Debug, Args)]
pub struct BenchPathArgs {
    /// What is rendered.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The view.
    #[command(flatten)]
    pub camera: CameraArgs,
    /// Also write the result to this JSON file.
    #[arg(long, value_name = "F")]
    pub json: Option<PathBuf>,
    /// Image size.
    #[arg(long, value_name = "WxH", default_value = "320x180")]
    pub size: ImageSize,
    /// Samples of each pixel in a timed window.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: u32,
    /// Scattering events after the first hit, at most.
    #[arg(long, value_name = "B", default_value_t = 8)]
    pub max_bounces: u32,
    /// Scattering events before Russian roulette begins.
    #[arg(long, value_name = "K", default_value_t = pt_reference::ReferenceParams::default().roulette_start)]
    pub roulette_start: u32,
    /// Timed windows; the median counts.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    pub windows: u32,
    /// Where it runs.
    #[command(flatten)]
    pub device: DeviceArgs,
}

/// `pt bench trace`
#[derive(Clone, Debug, Args)]
pub struct BenchTraceArgs {
    /// glTF or GLB file, or the name of a built-in scene.
    pub scene: String,
    /// Also write the rows to this JSON file.
    #[arg(long, value_name = "F")]
    pub json: Option<PathBuf>,
    /// Image size of the primary rays; every kind has as many rays [default: 3840x2160, on a CPU 640x360]
    #[arg(long, value_name = "WxH")]
    pub size: Option<ImageSize>,
    /// Timed windows, one after the other; the best counts.
    #[arg(long, value_name = "N", default_value_t = 7, value_parser = clap::value_parser!(u32).range(1..))]
    pub windows: u32,
    /// Seed of the random directions.
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u32,
    /// Vulkan device, by index or part of its name [default: a discrete GPU before the CPU]
    #[arg(long, value_name = "D")]
    pub device: Option<String>,
}

/// Degrees.
const DEFAULT_VFOV: f32 = 50.0;

/// The view.
#[derive(Clone, Debug, Args)]
pub struct CameraArgs {
    /// Camera of the scene, by name or by index from 0 [default: the first, or one that frames the scene]
    #[arg(long, value_name = "NAME|INDEX", conflicts_with = "look", help_heading = "Camera")]
    pub camera: Option<CameraChoice>,
    /// Eye and target point instead of a camera of the scene, scene units, +Y up.
    #[arg(long, value_name = "EX,EY,EZ,TX,TY,TZ", allow_hyphen_values = true, help_heading = "Camera")]
    pub look: Option<LookAt>,
    /// Vertical field of view of --look, degrees, between 0 and 180.
    #[arg(long, value_name = "DEG", default_value_t = DEFAULT_VFOV, value_parser = field_of_view, allow_negative_numbers = true, requires = "look", help_heading = "Camera")]
    pub vfov: f32,
}

impl Default for CameraArgs {
    fn default() -> Self {
        Self { camera: None, look: None, vfov: DEFAULT_VFOV }
    }
}

/// Where it runs.
#[derive(Clone, Debug, Args)]
pub struct DeviceArgs {
    /// How rays are traced; auto measures and leaves compute for what is clearly faster.
    #[arg(long, value_name = "B", value_enum, default_value_t = BackendChoice::Auto, help_heading = "Device")]
    pub backend: BackendChoice,
    /// Vulkan device, by index or part of its name [default: a discrete GPU before the CPU]
    #[arg(long, value_name = "D", help_heading = "Device")]
    pub device: Option<String>,
    /// Run with the Vulkan validation layers; any message is an error.
    #[arg(long, help_heading = "Device")]
    pub validation: bool,
}

/// `pt render`
#[derive(Clone, Debug, Args)]
pub struct RenderArgs {
    /// Image to write: PNG (tone-mapped, sRGB) or EXR (linear scene radiance before exposure); may be repeated. A run of # in the name
    /// stands for the number of the frame, from 0, and every frame is written.
    #[arg(short, long, value_name = "OUT.{png,exr}", required = true, help_heading = "Output")]
    pub output: Vec<PathBuf>,
    /// Further channels for an EXR: all, or a list of names.
    #[arg(long, value_name = "all|A,B", help_heading = "Output")]
    pub aov: Option<AovSelection>,
    /// Write GPU times per pass and the counters of allocations and pipelines to this JSON file.
    #[arg(long, value_name = "F.json", help_heading = "Output")]
    pub timings: Option<PathBuf>,

    /// What is rendered.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The view.
    #[command(flatten)]
    pub camera: CameraArgs,

    /// Image size in pixels, each side 1 to 16384.
    #[arg(long, value_name = "WxH", default_value = "1280x720", help_heading = "Frame")]
    pub size: ImageSize,
    /// Frames to render; the last one is written, or all of them (see --output).
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..), help_heading = "Frame")]
    pub frames: u32,
    /// Write the mean of all frames instead of the last one.
    #[arg(long, help_heading = "Frame")]
    pub accumulate: bool,
    /// Seed of all random numbers; another seed gives independent noise.
    #[arg(long, value_name = "S", default_value_t = 0, help_heading = "Frame")]
    pub seed: u64,
    /// What happens to the frame after it is traced.
    #[command(flatten)]
    pub post: PostArgs,
    /// Parameters to start from: the name of a built-in profile or a TOML file.
    #[arg(long, value_name = "NAME|FILE", help_heading = "Frame")]
    pub profile: Option<String>,
    /// Set one parameter, after the profile; may be repeated.
    #[arg(long = "set", value_name = "stage.key=value", value_parser = assignment, help_heading = "Frame")]
    pub set: Vec<String>,

    /// Where it runs.
    #[command(flatten)]
    pub device: DeviceArgs,
}

impl RenderArgs {
    /// Checks all outputs before rendering begins.
    ///
    /// # Errors
    /// An unknown extension, a folder that is missing or not writable, a directory, AOVs without an EXR.
    pub fn check_outputs(&self) -> anyhow::Result<Vec<Output>> {
        let outputs: Vec<_> = self.output.iter().map(|path| Output::new(path)).collect::<Result<_, _>>()?;
        if self.aov.is_some() && outputs.iter().all(|output| output.format() != OutputFormat::Exr) {
            anyhow::bail!("--aov needs an EXR output, {} is a PNG", self.output[0].display());
        }
        if let Some(timings) = &self.timings {
            check_writable(timings)?;
        }
        Ok(outputs)
    }
}

/// `pt compare`
#[derive(Clone, Debug, Args)]
pub struct CompareArgs {
    /// The image: PNG, JPEG, HDR or EXR.
    pub a: PathBuf,
    /// Its reference, of the same size.
    pub b: PathBuf,
    /// What to measure; the formulas are printed with the values. Besides the defaults there is z-test, for EXR files
    /// with the variance of the mean in a layer `variance`.
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "relmse,mse,psnr,ssim,flip,hdr-flip,energy"
    )]
    pub metric: Vec<MetricName>,
    /// Only this rectangle, cut out before measuring; x and y count from the top left pixel.
    #[arg(long, value_name = "x,y,w,h")]
    pub region: Option<Region>,
    /// False-colour map of the per-pixel error of the first metric, dark (0) to bright.
    #[arg(long, value_name = "F.png")]
    pub heatmap: Option<PathBuf>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
    /// Fail (exit code 1) when the metric is above the value; may be repeated.
    #[arg(long, value_name = "METRIC=VALUE", help_heading = "Checks")]
    pub max: Vec<Limit>,
    /// Fail (exit code 1) when the metric is below the value (psnr, ssim, energy, z-test); may be repeated.
    #[arg(long, value_name = "METRIC=VALUE", help_heading = "Checks")]
    pub min: Vec<Limit>,
}

/// A [`Metric`] by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MetricName(pub Metric);

impl std::fmt::Display for MetricName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.0.name())
    }
}

impl FromStr for MetricName {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        text.parse().map(Self).map_err(|error: pt_core::metrics::MetricError| error.to_string())
    }
}

/// How rays are traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BackendChoice {
    /// The fastest on this device and scene.
    Auto,
    /// Own BVH in compute kernels, on every device.
    Compute,
    /// VK_KHR_ray_query.
    RayQuery,
    /// VK_KHR_ray_tracing_pipeline.
    RtPipeline,
}

/// A camera of the scene: digits are an index from 0, anything else a name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CameraChoice {
    /// Index from 0.
    Index(usize),
    /// Name.
    Name(String),
}

impl FromStr for CameraChoice {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse() {
            Ok(index) => Ok(Self::Index(index)),
            Err(_) if text.is_empty() => Err("expected a name or an index from 0".into()),
            Err(_) => Ok(Self::Name(text.into())),
        }
    }
}

/// A view from one point to another, scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LookAt {
    /// Where the camera is.
    pub eye: [f32; 3],
    /// What it looks at; never equal to `eye`.
    pub target: [f32; 3],
}

impl FromStr for LookAt {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let [ex, ey, ez, tx, ty, tz] = numbers(text, "six finite numbers EX,EY,EZ,TX,TY,TZ", finite)?;
        let (eye, target) = ([ex, ey, ez], [tx, ty, tz]);
        if eye == target {
            return Err("eye and target are the same point".into());
        }
        Ok(Self { eye, target })
    }
}

/// A rectangle of pixels, not empty.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// First column.
    pub x: u32,
    /// First row, from the top.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl FromStr for Region {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let parse = |text: &str| text.parse::<u32>().map_err(|error| error.to_string());
        let [x, y, width, height] = numbers(text, "four whole numbers x,y,w,h", parse)?;
        if width == 0 || height == 0 {
            return Err(format!("the region is empty ({width}x{height} pixels)"));
        }
        Ok(Self { x, y, width, height })
    }
}

/// A bound on a metric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// The metric.
    pub metric: Metric,
    /// The last value that passes; not NaN.
    pub value: f64,
}

impl FromStr for Limit {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let (name, value) = text.split_once('=').ok_or("expected METRIC=VALUE, for example relmse=0.001")?;
        let MetricName(metric) = name.parse()?;
        match value.parse::<f64>() {
            Ok(value) if !value.is_nan() => Ok(Self { metric, value }),
            _ => Err(format!("{value:?} is not a number")),
        }
    }
}

/// Which channels besides the image go into an EXR.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AovSelection {
    /// Every channel there is.
    All,
    /// These, in this order.
    Named(Vec<String>),
}

impl FromStr for AovSelection {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        if text == "all" {
            return Ok(Self::All);
        }
        let names: Vec<_> = text.split(',').map(|name| name.trim().to_owned()).collect();
        if names.iter().any(String::is_empty) {
            return Err("expected all, or names separated by commas".into());
        }
        Ok(Self::Named(names))
    }
}

fn numbers<T, const N: usize>(
    text: &str,
    expected: &str,
    parse: impl Fn(&str) -> Result<T, String>,
) -> Result<[T; N], String> {
    let values: Result<Vec<T>, String> = text.split(',').map(|part| parse(part.trim())).collect();
    values.ok().and_then(|values| values.try_into().ok()).ok_or_else(|| format!("expected {expected}"))
}

pub(crate) fn finite_f64(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(|| "expected a finite number".into())
}

pub(crate) fn finite(text: &str) -> Result<f32, String> {
    text.parse().ok().filter(|value: &f32| value.is_finite()).ok_or_else(|| "expected a finite number".into())
}

pub(crate) fn not_negative(text: &str) -> Result<f32, String> {
    finite(text).ok().filter(|&value| value >= 0.0).ok_or_else(|| "expected a number of 0 or more".into())
}

pub(crate) fn positive_f64(text: &str) -> Result<f64, String> {
    finite_f64(text).ok().filter(|&value| value > 0.0).ok_or_else(|| "expected a number above 0".into())
}

fn field_of_view(text: &str) -> Result<f32, String> {
    finite(text)
        .ok()
        .filter(|&value| value > 0.0 && value < 180.0)
        .ok_or_else(|| "expected degrees between 0 and 180, both excluded".into())
}

/// Only the form; keys and types are checked against the parameters.
fn assignment(text: &str) -> Result<String, String> {
    match text.split_once('=') {
        Some((key, _)) if !key.trim().is_empty() => Ok(text.into()),
        _ => Err("expected stage.key=value".into()),
    }
}
