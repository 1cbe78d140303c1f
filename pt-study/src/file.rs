//! Study files.

use crate::metric::MeasureAt;
use pt_image::metrics::SequenceMetric;
use std::ops::Range;
use std::path::PathBuf;

/// Key of the profile, which stands beside those of the knobs.
pub const PROFILE: &str = "profile";

/// Name of the axis of the named variants.
pub(crate) const VARIANT_AXIS: &str = "variant";

/// A study, as its file says it.
#[derive(Clone, Debug)]
pub struct Study {
    /// The file.
    pub path: PathBuf,
    /// Its text.
    pub text: String,
    /// Name of the study.
    pub name: String,
    /// The question that it answers.
    pub question: String,
    /// Scenes, as given: names of built-in scenes, or glTF files beside the study file.
    pub scenes: Vec<String>,
    /// Cameras by name, index, view or file; empty text: the scene's first.
    pub cameras: Vec<String>,
    /// Sizes of the picture, pixels.
    pub sizes: Vec<[u32; 2]>,
    /// Trace backends.
    pub backends: Vec<String>,
    /// Seeds.
    pub seeds: Vec<u64>,
    /// Frames that each cell renders.
    pub frames: u32,
    /// The frames that are measured.
    pub measure: Range<u32>,
    /// Scene time of the first frame, seconds.
    pub time: f64,
    /// Frames per second of scene time.
    pub fps: f64,
    /// Physical sky in place of the scenes' environment, as `--sky` takes it.
    pub sky: Option<String>,
    /// Whether the frames are averaged.
    pub accumulate: bool,
    /// The ground truth.
    pub against: Against,
    /// Which picture is measured.
    pub measure_at: MeasureAt,
    /// Metrics.
    pub metrics: Vec<SequenceMetric>,
    /// Knobs that all variants have.
    pub set: Vec<Setting>,
    /// The axes of the variants; named variants are an axis of their own.
    pub axes: Vec<Axis>,
    /// Which combinations of the axes are variants.
    pub design: Design,
    /// Name of the baseline; `None`: the first variant.
    pub baseline: Option<String>,
    /// Which random numbers variants see.
    pub pairing: Pairing,
    /// Of which cells pictures are kept.
    pub images: Images,
    /// Whether and how the error is split over stages.
    pub ledger: Option<Ledger>,
}

/// The ground truth of a study.
#[derive(Clone, Debug, PartialEq)]
pub enum Against {
    /// Path traced with this many samples per pixel.
    Reference {
        /// Samples per pixel.
        spp: u32,
    },
    /// The recorded references of a capture.
    Capture(PathBuf),
}

/// A knob, the profile, or a knob of the reference with its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Key.
    pub key: String,
    /// Value as text.
    pub value: String,
}

impl Setting {
    /// As `--set` takes it.
    pub fn assignment(&self) -> String {
        format!("{}={}", self.key, self.value)
    }
}

/// An axis of variants.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Its name: that of the knob, unless the file gives another.
    pub name: String,
    /// Its values.
    pub values: Vec<AxisValue>,
}

/// A value of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisValue {
    /// As text.
    pub name: String,
    /// What it sets; nothing on a placebo axis.
    pub set: Vec<Setting>,
}

/// Which combinations of the axes are variants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Design {
    /// All.
    All,
    /// The first values of all axes, and each other value with the first values of the other axes.
    OneAtATime,
}

/// Which random numbers variants see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pairing {
    /// Each variant has random numbers of its own for each seed.
    Independent,
    /// All variants have the same random numbers for the same seed (common random numbers).
    Seed,
}

/// Of which cells pictures are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Images {
    /// None.
    None,
    /// Those of the first seed.
    FirstSeed,
    /// All.
    All,
}

/// How the error is split over stages.
#[derive(Clone, Debug, PartialEq)]
pub struct Ledger {
    /// The metric that is split.
    pub metric: SequenceMetric,
    /// Names of the stages, checked by the program.
    pub stages: Vec<String>,
}
