//! Study files.

use crate::error::StudyError;
use crate::file_reader::{Reader, above_zero, backend, camera, measured, metric, positive, size};
use crate::keys;
use crate::toml_reader::Source;
use pt_core::settings::{Knob, close_to};
use pt_image::metrics::SequenceMetric;
use std::ops::Range;
use std::path::{Path, PathBuf};

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
    /// Cameras by name or index; empty text: the scene's first.
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

/// Which picture of a frame is measured, and of its ground truth alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeasureAt {
    /// Linear radiance before bloom and exposure.
    Radiance,
    /// The picture as shown, as linear display values: after bloom, exposure, tone curve and FSR 1. The ground truth is shown with the same
    /// knobs, and metered by itself.
    Display,
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

impl Study {
    /// Reads a study file; `knobs`: all that there are, `stages`: those that a ledger can feed with ground truth.
    ///
    /// # Errors
    /// The place of what is wrong, and what is expected.
    pub fn read(path: &Path, knobs: &[Knob], stages: &[&str]) -> Result<Self, StudyError> {
        let bytes = pt_image::atomic_file::read(path)?;
        let text = String::from_utf8(bytes)
            .map_err(|_| StudyError::folder(path, "is not UTF-8 text; a study is a TOML file"))?;
        Self::parse(path, text, knobs, stages)
    }

    /// As [`Study::read`], of the text of the file at `path`.
    ///
    /// # Errors
    /// As [`Study::read`].
    pub fn parse(path: &Path, text: String, knobs: &[Knob], stages: &[&str]) -> Result<Self, StudyError> {
        let source = Source { path, text: &text };
        let root = source.parse()?;
        let table = source.table(root.get_ref(), "a study", keys::STUDY)?;
        let required = |key: &str| {
            table
                .get(key)
                .ok_or_else(|| source.error(0..0, format!("the study has no {key}; add {key} = ...")))
        };
        let reader = Reader { source, knobs };
        required("scenes")?;
        required("metrics")?;
        let frames = table.read("frames", positive)?.unwrap_or(16);
        let measure_at = table
            .one_of("measure_at", &[("radiance", MeasureAt::Radiance), ("display", MeasureAt::Display)])?
            .unwrap_or(MeasureAt::Radiance);
        let set = table.read("set", |_, value| reader.settings(value, true))?.unwrap_or_default();
        let axes = reader.axes(&table, &set)?;
        let name = path.file_stem().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let seeds = match table.get("seeds") {
            Some(value) if value.get_ref().is_integer() => (0..u64::from(positive(source, value)?)).collect(),
            Some(_) => table.read_list("seeds", Source::number)?.unwrap_or_default(),
            None => (0..5).collect(),
        };
        let study = Self {
            path: path.into(),
            name: table.read("name", Source::string)?.unwrap_or(name),
            question: table.read("question", Source::string)?.unwrap_or_default(),
            scenes: table.read_list("scenes", Source::string)?.unwrap_or_default(),
            cameras: table.read_list("cameras", camera)?.unwrap_or_else(|| vec![String::new()]),
            sizes: table.read_list("sizes", size)?.unwrap_or_else(|| vec![[640, 360]]),
            backends: table.read_list("backends", backend)?.unwrap_or_else(|| vec!["auto".into()]),
            seeds,
            frames,
            measure: table
                .read("measure", |source, value| measured(source, value, frames))?
                .unwrap_or(frames - 1..frames),
            time: table.read("time", Source::float)?.unwrap_or(0.0),
            fps: table.read("fps", |source, value| above_zero(source, value))?.unwrap_or(60.0),
            accumulate: table.read("accumulate", Source::boolean)?.unwrap_or(false),
            against: reader.against(&table)?,
            measure_at,
            metrics: table
                .read_list("metrics", |source, value| metric(source, value, measure_at))?
                .unwrap_or_default(),
            set,
            axes,
            design: table
                .one_of("design", &[("all", Design::All), ("one-at-a-time", Design::OneAtATime)])?
                .unwrap_or(Design::All),
            baseline: table.read("baseline", Source::string)?,
            pairing: table
                .one_of("pairing", &[("independent", Pairing::Independent), ("seed", Pairing::Seed)])?
                .unwrap_or(Pairing::Independent),
            images: table
                .one_of(
                    "images",
                    &[("none", Images::None), ("first-seed", Images::FirstSeed), ("all", Images::All)],
                )?
                .unwrap_or(Images::FirstSeed),
            ledger: reader.ledger(&table, stages, measure_at)?,
            text: String::new(),
        };
        reader.check_unique(&table, &study)?;
        let variants = study.variants();
        if let (Some(baseline), Some(place)) = (&study.baseline, table.get("baseline"))
            && !variants.iter().any(|variant| variant.name == *baseline)
        {
            let names: Vec<&str> = variants.iter().map(|variant| variant.name.as_str()).collect();
            let closest = close_to(baseline, names.iter().copied());
            let some = names[..names.len().min(12)].join(", ");
            let rest = if names.len() > 12 { ", ..." } else { "" };
            return Err(source.error(
                place.span(),
                format!("no variant is called {baseline:?}{closest} (there are {some}{rest})"),
            ));
        }
        Ok(Self { text, ..study })
    }

    /// An error at entry `index` of the list `key`, such as `cameras`, for what only the program can check.
    pub fn error_at(&self, key: &str, index: usize, reason: impl Into<String>) -> StudyError {
        Source { path: &self.path, text: &self.text }.error_at(key, index, reason)
    }
}
