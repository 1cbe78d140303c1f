//! Reads a study file.

use crate::error::StudyError;
use crate::file::{Design, Images, Pairing, Study};
use crate::file_reader::{Reader, above_zero, backend, camera, measured, metric, positive, size};
use crate::keys;
use crate::metric::MeasureAt;
use crate::toml_reader::Source;
use pt_core::settings::{Knob, close_to};
use std::path::Path;

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
            sky: table.read("sky", Source::string)?,
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
