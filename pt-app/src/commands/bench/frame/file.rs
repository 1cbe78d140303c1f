//! The JSON file of a benchmark: every time of every pass.

use crate::frame::FrameStage;
use anyhow::{Context, Result, bail, ensure};
use pt_core::harness::Spread;
use pt_core::trace::RayKind;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Version of the file; another one is refused.
pub const FORMAT: u32 = 1;

/// What `pt bench frame`, `stage` and `all` write.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct BenchFile {
    /// [`FORMAT`]
    pub format: u32,
    /// The command.
    pub command: String,
    /// Version of the program.
    pub version: String,
    /// Device.
    pub device: String,
    /// Driver and its version.
    pub driver: String,
    /// Trace backend.
    pub backend: String,
    /// Name of the scene.
    pub scene: String,
    /// Hash of the scene's content.
    pub fingerprint: String,
    /// The camera, in words.
    pub camera: String,
    /// Size of the picture.
    pub size: [u32; 2],
    /// Size of the frame before upscaling.
    pub frame_size: [u32; 2],
    /// Seed of the random numbers.
    pub seed: u64,
    /// Frames at the start of each round that do not count.
    pub warm_up: u32,
    /// Frames of a round that count.
    pub frames: u32,
    /// Rounds of each run that the file holds: one, or those that `--append` has added.
    pub rounds: Vec<u32>,
    /// Profile that the knobs begin with.
    pub profile: Option<String>,
    /// Knobs that were set.
    pub set: Vec<String>,
    /// What the passes are compared with; absent with `--times-only`.
    pub yardsticks: Option<Yardsticks>,
    /// What was measured, one after the other.
    pub parts: Vec<Part>,
}

impl BenchFile {
    /// Reads a file.
    ///
    /// # Errors
    /// A file that can't be read, is no benchmark, or of another version.
    pub fn read(path: &Path) -> Result<Self> {
        let name = path.display();
        let text = std::fs::read(path).with_context(|| format!("cannot read {name}"))?;
        let Ok(Version { format }) = serde_json::from_slice(&text) else {
            bail!("{name}: is no benchmark; give a file that pt bench frame, stage or all wrote with --json");
        };
        ensure!(
            format == FORMAT,
            "{name}: has version {format} of the file, this program reads {FORMAT}; measure again"
        );
        serde_json::from_slice(&text).map_err(|error| {
            let (line, column) = (error.line(), error.column());
            anyhow::anyhow!("{name}: is damaged at line {line}, column {column}; measure again")
        })
    }

    /// What differs between two runs that are to be of one benchmark; `None`: they are.
    pub fn difference(&self, other: &Self) -> Option<String> {
        let size = |[width, height]: [u32; 2]| format!("{width}x{height}");
        let parts =
            |file: &Self| file.parts.iter().map(|part| part.name.clone()).collect::<Vec<_>>().join(", ");
        let entries = [
            ("scene", self.scene.clone(), other.scene.clone()),
            ("content of the scene", self.fingerprint.clone(), other.fingerprint.clone()),
            ("camera", self.camera.clone(), other.camera.clone()),
            ("size", size(self.size), size(other.size)),
            ("device", self.device.clone(), other.device.clone()),
            ("backend", self.backend.clone(), other.backend.clone()),
            ("seed", self.seed.to_string(), other.seed.to_string()),
            ("number of frames in a round", self.frames.to_string(), other.frames.to_string()),
            ("benchmark", parts(self), parts(other)),
        ];
        let (what, here, there) = entries.into_iter().find(|(_, here, there)| here != there)?;
        Some(format!("the {what} is {here} and {there}"))
    }

    /// The runs of `earlier`, then this one.
    ///
    /// # Errors
    /// Runs of different benchmarks, knobs, versions or drivers.
    pub fn behind(mut self, earlier: Self) -> Result<Self> {
        if let Some(difference) = earlier.difference(&self) {
            bail!("{difference}");
        }
        let said = |file: &Self| {
            [
                file.version.clone(),
                file.driver.clone(),
                format!("{} {}", file.profile.as_deref().unwrap_or("default"), file.set.join(" ")),
            ]
        };
        for ((what, here), there) in
            ["version", "driver", "choice of knobs"].iter().zip(said(&earlier)).zip(said(&self))
        {
            ensure!(here == there, "the {what} is {here} and {there}");
        }
        let rounds_before = earlier.rounds.iter().sum::<u32>() as usize;
        self.rounds.splice(0..0, earlier.rounds);
        for (part, before) in self.parts.iter_mut().zip(earlier.parts) {
            part.time.put_behind(before.time.ms);
            for pass in &mut part.passes {
                let same = before.passes.iter().find(|earlier| earlier.pass == pass.pass);
                pass.time.put_behind(
                    same.map_or_else(|| vec![Vec::new(); rounds_before], |pass| pass.time.ms.clone()),
                );
            }
        }
        self.yardsticks = self.yardsticks.or(earlier.yardsticks);
        Ok(self)
    }

    /// Times by what makes independent samples: the runs, or the rounds of the only run.
    pub fn batches(&self, times: &Times) -> Vec<Vec<f64>> {
        if let [_] = self.rounds[..] {
            return times.ms.clone();
        }
        let mut rounds = times.ms.iter();
        self.rounds
            .iter()
            .map(|&count| rounds.by_ref().take(count as usize).flatten().copied().collect())
            .collect()
    }
}

/// The part of a file that every version has.
#[derive(Deserialize)]
struct Version {
    format: u32,
}

/// Speeds of the device.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Yardsticks {
    /// 10^9 bytes that a copy reads and writes a second.
    pub copy_gb_per_s: f64,
    /// The copy that was the fastest.
    pub copy: String,
    /// Million rays a second of each kind that the passes trace, as `pt bench trace` measures them.
    pub mrays_per_s: Vec<(RayKind, f64)>,
}

/// The frame, or a stage of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Part {
    /// `frame`, or the stage.
    pub name: String,
    /// How it ran.
    pub how: How,
    /// Time of all of its passes in a frame: the whole frame from the first timestamp to the last, of a stage the sum of its passes.
    pub time: Times,
    /// Sums of the passes of each stage; only of the frame.
    pub stages: Vec<StageRow>,
    /// The passes, in the order of the frame.
    pub passes: Vec<PassRecord>,
}

/// How a part was run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum How {
    /// Within the frame.
    Frame,
    /// On the images of one recorded frame, without the stages before it and without rays.
    Replay,
}

/// Times in milliseconds.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Times {
    /// Median over all frames.
    pub median_ms: f64,
    /// 95 % of the frames take less.
    pub p95_ms: f64,
    /// All of them by round, in the order of the frames.
    pub ms: Vec<Vec<f64>>,
}

impl Times {
    /// Of the times of each round.
    pub fn of(ms: Vec<Vec<f64>>) -> Self {
        let Spread { median_ms, p95_ms } = Spread::of(ms.concat());
        Self { median_ms, p95_ms, ms }
    }

    /// Adds the rounds of earlier runs.
    fn put_behind(&mut self, mut earlier: Vec<Vec<f64>>) {
        earlier.append(&mut self.ms);
        *self = Self::of(earlier);
    }
}

/// The passes of a stage together.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct StageRow {
    /// The stage.
    pub stage: FrameStage,
    /// Median of the sum, milliseconds.
    pub median_ms: f64,
    /// 95th percentile of the sum, milliseconds.
    pub p95_ms: f64,
}

/// A pass.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PassRecord {
    /// Its name, as `pt passes` prints it; the second of the same name in a frame has a number.
    pub pass: String,
    /// The stage that it belongs to.
    pub stage: FrameStage,
    /// Its times; of a pass that some frames have not, those of the frames that have it.
    #[serde(flatten)]
    pub time: Times,
    /// Bytes that it moves if it touches every texel and every entry of its buffers once, as `pt passes` counts them.
    pub bytes: u64,
    /// Whether it moves fewer than that.
    pub bytes_are_upper_bound: bool,
    /// The rays that it traces.
    pub rays: Option<Rays>,
}

/// Rays of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rays {
    /// The kind whose measured rate they are compared with.
    pub kind: RayKind,
    /// Number in a frame.
    pub count: u64,
    /// Whether it traces fewer than that.
    pub is_upper_bound: bool,
}

impl PassRecord {
    /// 10^9 bytes a second at the median time; `None` if the bytes are an upper bound or the time is too short for the clock.
    pub fn gb_per_s(&self) -> Option<f64> {
        let known = !self.bytes_are_upper_bound && self.bytes > 0 && self.time.median_ms > 0.0;
        known.then(|| self.bytes as f64 / self.time.median_ms * 1e-6)
    }

    /// Million rays a second at the median time; `None` as for [`PassRecord::gb_per_s`].
    pub fn mrays_per_s(&self) -> Option<f64> {
        let rays = self.rays.filter(|rays| !rays.is_upper_bound && rays.count > 0)?;
        (self.time.median_ms > 0.0).then(|| rays.count as f64 / self.time.median_ms * 1e-3)
    }
}

impl Yardsticks {
    /// Share of the copy bandwidth that a pass reaches.
    pub fn share_of_copy(&self, pass: &PassRecord) -> Option<f64> {
        pass.gb_per_s().filter(|_| self.copy_gb_per_s > 0.0).map(|rate| rate / self.copy_gb_per_s)
    }

    /// Share of the rate of its kind of rays that a pass reaches.
    pub fn share_of_rays(&self, pass: &PassRecord) -> Option<f64> {
        let kind = pass.rays?.kind;
        let (_, measured) = self.mrays_per_s.iter().find(|(of, rate)| *of == kind && *rate > 0.0)?;
        pass.mrays_per_s().map(|rate| rate / measured)
    }
}
