//! What a study file asks for, resolved: its variants with their knobs, and the cells to run.

use super::{StudyArgs, views};
use crate::args::LookAt;
use crate::frame::{Oracle, Oracles};
use crate::params::{
    FrameParams, ReferenceSettings, all_knobs, assignments, check_frame, resolve, resolve_reference,
};
use anyhow::{Context, Result, bail, ensure};
use pt_core::Device;
use pt_post::{Encoding, Upscale};
use pt_reference::ReferenceParams;
use pt_shaders::NamedEnum;
use pt_study::cell::{Cell, MANY_CELLS, Shard, Variant, filtered};
use pt_study::file::{Against, PROFILE, Setting, Study};
use pt_study::metric::{MeasureAt, record};
use pt_study::record::{AxisRecord, FORMAT, StudyRecord, VariantRecord};
use std::path::Path;

/// A study that is ready to run.
pub struct Plan {
    /// The study file.
    pub study: Study,
    /// Its variants.
    pub variants: Vec<Variant>,
    /// The knobs of each variant.
    pub params: Vec<FrameParams>,
    /// The knobs of the reference.
    pub reference: ReferenceParams,
    /// All cells that the filters keep.
    pub cells: Vec<Cell>,
    /// The part of them that is run.
    shard: Option<Shard>,
    /// The command, without what only concerns this run.
    command: String,
}

impl Plan {
    /// Reads the study file and checks all that can be checked without a device.
    ///
    /// # Errors
    /// What is wrong, and where.
    pub fn new(args: &StudyArgs) -> Result<Self> {
        let file = args.file.as_deref().context("no study file is given")?;
        let study = Study::read(file, &all_knobs(), &Oracles::names())?;
        let count = study.cell_count();
        ensure!(
            count < MANY_CELLS || args.yes,
            "{}: the study has {count} cells, which is a million or more; --yes runs them, shorter lists or --filter make fewer",
            file.display()
        );
        let variants = study.variants();
        ensure!(
            !variants.is_empty(),
            "{}: the study has more than {MANY_CELLS} variants; give shorter axes",
            file.display()
        );
        let resolved = |variant: &Variant| {
            let params = params_of(&study, &variant.set)?;
            check_frame(&params, study.accumulate)?;
            ensure!(
                study.measure_at == MeasureAt::Radiance || params.post.encoding == Encoding::Srgb,
                "measure_at = \"display\" measures pictures of sRGB displays, and post.encoding is {}",
                params.post.encoding.name()
            );
            ensure!(
                study.ledger.is_none() || params.post.upscale == Upscale::None,
                "ledger: a frame that is upscaled cannot be fed with ground truth; post.upscale = none"
            );
            let stages = study.ledger.iter().flat_map(|ledger| &ledger.stages);
            for stage in stages.filter_map(|name| Oracle::from_name(name).ok()) {
                if let Some(reason) = stage.cannot_be_fed(&params) {
                    bail!("ledger: {reason}");
                }
            }
            Ok(params)
        };
        let params = variants
            .iter()
            .map(|variant| {
                resolved(variant).with_context(|| format!("{}: variant {}", file.display(), variant.name))
            })
            .collect::<Result<Vec<_>>>()?;
        let of_reference: Vec<_> =
            study.set.iter().filter(|s| s.key.starts_with("reference.")).map(Setting::assignment).collect();
        let mut reference = resolve_reference(ReferenceSettings::default(), None, &of_reference)
            .with_context(|| format!("{}: set", file.display()))?
            .reference;
        if let Against::Reference { spp } = study.against {
            reference.spp = spp;
        }
        let cells = filtered(study.cells(&variants), &variants, &args.filter)?;
        views::check(&study, &cells)?;
        let command = command(file, args);
        Ok(Self { study, variants, params, reference, cells, shard: args.shard, command })
    }

    /// The cells of this run.
    pub fn shard(&self) -> &[Cell] {
        self.shard.map_or(&self.cells, |shard| shard.of(&self.cells))
    }

    /// As the result folder describes it.
    pub fn record(&self, device: &Device) -> StudyRecord {
        let study = &self.study;
        let info = device.info();
        let variant = |(variant, params): (&Variant, &FrameParams)| VariantRecord {
            name: variant.name.clone(),
            axes: variant.axes.clone(),
            set: assignments(params),
        };
        StudyRecord {
            format: FORMAT,
            name: study.name.clone(),
            question: study.question.clone(),
            file: study.text.clone(),
            command: self.command.clone(),
            version: env!("CARGO_PKG_VERSION").into(),
            revision: env!("PT_REVISION").into(),
            device: info.name.clone(),
            driver: info.driver_line(),
            metrics: study.metrics.iter().map(|&metric| record(metric, study.measure_at)).collect(),
            axes: study
                .axes
                .iter()
                .map(|axis| AxisRecord {
                    name: axis.name.clone(),
                    values: axis.values.iter().map(|value| value.name.clone()).collect(),
                })
                .collect(),
            baseline: study.baseline_name(&self.variants),
            variants: self.variants.iter().zip(&self.params).map(variant).collect(),
            cells: self.cells.len(),
        }
    }

    /// The command that renders the frames of a cell, up to the last one that is measured.
    pub fn cell_command(&self, cell: &Cell) -> String {
        let study = &self.study;
        let mut words = vec!["pt".into(), "render".into(), quoted(&views::scene_path(study, &cell.scene))];
        let mut add = |flag: &str, value: &str| words.extend([flag.to_owned(), quoted(value)]);
        if !cell.camera.is_empty() {
            let camera = &cell.camera;
            match camera.parse::<LookAt>() {
                Ok(_) => add("--look", camera),
                Err(_) if views::is_camera_path(camera) => {
                    add("--camera-path", &views::scene_path(study, camera));
                }
                Err(_) => add("--camera", camera),
            }
        }
        add("--size", &format!("{}x{}", cell.size[0], cell.size[1]));
        add("--backend", &cell.backend);
        add("--seed", &cell.random_seed.to_string());
        add("--frames", &study.measure.end.to_string());
        if study.time != 0.0 {
            add("--time", &study.time.to_string());
        }
        if study.fps != 60.0 {
            add("--fps", &study.fps.to_string());
        }
        if let Some(sky) = &study.sky {
            add("--sky", sky);
        }
        for set in assignments(&self.params[cell.variant]) {
            add("--set", &set);
        }
        if study.measure_at == MeasureAt::Display {
            add("--set", "post.output=display");
        }
        if study.accumulate {
            words.push("--accumulate".into());
        }
        words.extend(["-o".into(), "frame.exr".into()]);
        words.join(" ")
    }
}

/// Profile and knobs of a variant. The last profile counts, and knobs come after it.
fn params_of(study: &Study, set: &[Setting]) -> Result<FrameParams> {
    let profile = set.iter().rfind(|setting| setting.key == PROFILE).map(|setting| &setting.value);
    // A profile is a name, or a file beside the study file.
    let beside = profile.map(|name| study.path.parent().unwrap_or(Path::new("")).join(name));
    let profile = match (&beside, profile) {
        (Some(path), _) if path.is_file() => Some(path.to_string_lossy().into_owned()),
        (_, name) => name.cloned(),
    };
    let sets: Vec<_> = set.iter().filter(|setting| setting.key != PROFILE).map(Setting::assignment).collect();
    resolve(profile.as_deref(), &sets, study.accumulate)
}

fn command(file: &Path, args: &StudyArgs) -> String {
    let mut words = vec!["pt".into(), "study".into(), quoted(&file.to_string_lossy())];
    for filter in &args.filter {
        words.extend(["--filter".into(), quoted(&format!("{}={}", filter.key, filter.value))]);
    }
    if let Some(shard) = args.shard {
        words.extend(["--shard".into(), shard.to_string()]);
    }
    if args.yes {
        words.push("--yes".into());
    }
    words.extend(["-o".into(), "DIR".into()]);
    words.join(" ")
}

/// For a shell.
fn quoted(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "._-=/,:+".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        text.into()
    } else {
        format!("'{}'", text.replace('\'', "'\\''"))
    }
}
