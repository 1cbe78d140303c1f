//! Records of a result folder.
//!
//! | file | content |
//! |---|---|
//! | `study.json` | [`StudyRecord`]: what was asked, on what it ran |
//! | `results.jsonl` | a [`CellRecord`] a line, in the order of the cells; the same command on the same device gives the same bytes |
//! | `timings.jsonl` | a [`TimingRecord`] a line, in the order of the cells; times differ from run to run |
//! | `images/` | pictures that cells name |
//! | `report.html` | the report |

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Version of the records; another one is refused.
pub const FORMAT: u32 = 1;

/// What a study asked and on what it ran.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StudyRecord {
    /// [`FORMAT`]
    pub format: u32,
    /// Name of the study.
    pub name: String,
    /// The question that the study answers, one sentence.
    pub question: String,
    /// The study file, whole.
    pub file: String,
    /// Command that runs the study again.
    pub command: String,
    /// Version of the program.
    pub version: String,
    /// Git revision of the program, with `-dirty` if there were changes; empty: not known.
    pub revision: String,
    /// Device.
    pub device: String,
    /// Driver and its version.
    pub driver: String,
    /// Metrics against the reference, in the order of the study file.
    pub metrics: Vec<MetricRecord>,
    /// Axes that variants differ in, with all their values as text, in the order of the study file.
    pub axes: Vec<AxisRecord>,
    /// Name of the variant that the others are compared with.
    pub baseline: String,
    /// All variants, in the order of the study file.
    pub variants: Vec<VariantRecord>,
    /// Number of cells.
    pub cells: usize,
}

/// A metric of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MetricRecord {
    /// Name, as in `pt compare --metric`.
    pub name: String,
    /// Formula in one line.
    pub formula: String,
    /// Value of a perfect picture: 0 for errors, 1 for ratios and SSIM.
    pub perfect: f64,
}

/// An axis of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AxisRecord {
    /// Key of a knob, or a name for several that change together.
    pub name: String,
    /// Values, as text.
    pub values: Vec<String>,
}

/// One combination of the values of the axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VariantRecord {
    /// Short name.
    pub name: String,
    /// Its value on each axis, by the axis' name.
    pub axes: BTreeMap<String, String>,
    /// Its knobs as `--set` takes them.
    pub set: Vec<String>,
}

/// The result of one cell: a variant on a scene with a camera, a size, a backend and a seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellRecord {
    /// Name, unique in the study, fit for a file name.
    pub cell: String,
    /// Name of the variant.
    pub variant: String,
    /// Scene, as given.
    pub scene: String,
    /// Camera, as given; empty: the scene's first.
    pub camera: String,
    /// Size of the picture, pixels.
    pub size: [u32; 2],
    /// Trace backend.
    pub backend: String,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Mean over the measured frames, by the metric's name; a value that is not finite is null.
    pub metrics: BTreeMap<String, Option<f64>>,
    /// Value of each measured frame, by the metric's name.
    pub frames: BTreeMap<String, Vec<Option<f64>>>,
    /// Number of the first measured frame.
    pub first_frame: u32,
    /// What each stage adds to the error, if the study asks for it.
    pub ledger: Option<LedgerRecord>,
    /// Paths of images in the folder: `picture`, `reference` (PNG, tone-mapped alike) and `error` (false colour), where kept.
    pub images: BTreeMap<String, String>,
    /// Command that renders the same picture.
    pub command: String,
}

/// The error split over stages: `total` is `parts` and `interaction` together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LedgerRecord {
    /// Metric that is split.
    pub metric: String,
    /// Error of the frame.
    pub total: f64,
    /// Stage, and what the error loses when the stage is fed with ground truth, in the order of the frame.
    pub parts: Vec<(String, f64)>,
    /// What the parts do not explain: total minus their sum.
    pub interaction: f64,
    /// The metric of a perfect frame, whose error is the noise of the reference alone; mean over the measured frames. It counts as error of the first
    /// stage whose ground truth is the reference itself, such as the denoiser. `None`: not known.
    #[serde(default)]
    pub reference_noise: Option<f64>,
    /// The same for each measured frame, in their order; empty within it.
    pub frames: Vec<LedgerRecord>,
}

/// Times of a cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimingRecord {
    /// Name of the cell.
    pub cell: String,
    /// GPU time of a frame, median over the frames after warm-up, milliseconds.
    pub gpu_ms: f64,
    /// 95th percentile of the same, milliseconds.
    pub gpu_ms_p95: f64,
    /// Times of the passes, in the order of the frame.
    pub passes: Vec<PassTime>,
    /// Time that the whole cell took, seconds.
    pub wall_s: f64,
}

/// Time of one pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PassTime {
    /// Name of the pass, as `pt passes` prints it.
    pub pass: String,
    /// Median, milliseconds.
    pub median_ms: f64,
    /// 95th percentile, milliseconds.
    pub p95_ms: f64,
}
