//! Runs one cell: renders its frames and measures them.

use super::measure::Shot;
use super::pictures;
use super::plan::Plan;
use super::truth::{Truth, Truths, View};
use super::turn::Turn;
use super::views;
use crate::frame::{FrameTime, FullFrame, Oracle, Oracles, ShownTruth};
use crate::session::{Session, fold_seed};
use crate::timings::{pass_spreads, warm};
use anyhow::{Context, Result};
use pt_core::frame::FrameTiming;
use pt_core::harness::{Spread, raise_clock};
use pt_core::trace::TraceBackend;
use pt_core::{Device, Recorder};
use pt_scene::Scene;
use pt_shaders::NamedEnum;
use pt_study::cell::Cell;
use pt_study::file::Images;
use pt_study::folder::Finished;
use pt_study::ledger::split;
use pt_study::metric::MeasureAt;
use pt_study::record::{CellRecord, LedgerRecord, PassTime, TimingRecord};
use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Runs of the lighting stages whose mean a ledger takes for the ground truth of the light: 1/64 of the variance stays with the stages after them.
const LIGHT_RUNS: u32 = 64;

/// After a longer pause the clock of a GPU is raised before frames that are timed.
const LONGEST_PAUSE: Duration = Duration::from_millis(100);

/// Runs the cells of a plan, one after the other. No cell depends on those before it: each has a session of its own.
pub struct Runner<'a> {
    plan: &'a Plan,
    device: Device,
    turn: Turn,
    truths: Truths,
    folder: PathBuf,
    /// The scene that was used last, by its name.
    scene: Option<(String, Scene)>,
    /// What `auto` chose for each scene: it measures, which takes time.
    chosen: HashMap<String, TraceBackend>,
}

impl<'a> Runner<'a> {
    /// A runner that keeps references in `cache` and pictures in `folder`.
    ///
    /// # Errors
    /// As [`Truths::new`].
    pub fn new(plan: &'a Plan, device: &Device, cache: &Path, folder: &Path) -> Result<Self> {
        let truths = Truths::new(plan, device, cache)?;
        Ok(Self {
            plan,
            device: device.clone(),
            turn: Turn::of(device),
            truths,
            folder: folder.into(),
            scene: None,
            chosen: HashMap::new(),
        })
    }

    /// Renders and measures a cell.
    ///
    /// # Errors
    /// Scenes and cameras that are not there, a device that can't do it; the message names the cell.
    pub fn run(&mut self, cell: &Cell) -> Result<Finished> {
        self.measure(cell).with_context(|| format!("cell {}", cell.name))
    }

    fn measure(&mut self, cell: &Cell) -> Result<Finished> {
        let started = Instant::now();
        let mut session = self.session(cell)?;
        let Rendered { last, values, ledger: errors, reference_noise, timings } =
            self.render(cell, &mut session, &[])?;
        let ledger = self.ledger(cell, errors)?;
        let ledger = ledger.map(|ledger| LedgerRecord { reference_noise: mean(&reference_noise), ..ledger });
        let study = &self.plan.study;
        let frames: BTreeMap<String, Vec<Option<f64>>> = study
            .metrics
            .iter()
            .enumerate()
            .map(|(i, metric)| (metric.name().to_owned(), values.iter().map(|frame| frame[i]).collect()))
            .collect();
        let metrics = study
            .metrics
            .iter()
            .map(|metric| {
                // The first frame of all has none before it.
                let skipped = usize::from(metric.is_temporal() && study.measure.start == 0);
                let of_frames = frames[metric.name()].get(skipped..).unwrap_or_default();
                (metric.name().to_owned(), mean(of_frames))
            })
            .collect();
        let keeps_picture = match study.images {
            Images::None => false,
            Images::FirstSeed => study.seeds.first() == Some(&cell.seed),
            Images::All => true,
        };
        let images = match &last {
            Some(shot) if keeps_picture => pictures::write(&self.folder, cell, shot)?,
            _ => BTreeMap::new(),
        };
        session.check_validation()?;
        let record = CellRecord {
            cell: cell.name.clone(),
            variant: self.plan.variants[cell.variant].name.clone(),
            scene: cell.scene.clone(),
            camera: cell.camera.clone(),
            size: cell.size,
            backend: cell.backend.clone(),
            seed: cell.seed,
            metrics,
            frames,
            first_frame: study.measure.start,
            ledger,
            images,
            command: self.plan.cell_command(cell),
        };
        let timing = times(cell, &timings, &study.measure, started);
        Ok(Finished::new(record, timing)?)
    }

    /// Renders the cell again with each stage of the ledger fed with ground truth, together with those before it.
    fn ledger(&mut self, cell: &Cell, errors: Vec<Option<f64>>) -> Result<Option<LedgerRecord>> {
        let plan = self.plan;
        let Some(ledger) = &plan.study.ledger else { return Ok(None) };
        let stages: Vec<Oracle> =
            ledger.stages.iter().map(|name| Oracle::from_name(name)).collect::<Result<_, _>>()?;
        let params = &plan.params[cell.variant];
        let mut fed: Vec<(String, Vec<Option<f64>>)> = Vec::new();
        for (i, &stage) in stages.iter().enumerate() {
            let before = fed.last().map_or(&errors, |(_, errors)| errors).clone();
            // Light is fed together with the light before it. What comes before the other stages no longer matters when they are fed, but for the
            // tone map, which replaces no radiance. A stage that the frame does not have adds nothing.
            let is_light = matches!(stage, Oracle::Lights | Oracle::Indirect);
            let still_matters =
                |other: &Oracle| is_light || *other == stage || matches!(other, Oracle::Tonemap);
            let on: Vec<Oracle> = (stages[..=i].iter().copied())
                .filter(still_matters)
                .filter(|stage| stage.is_in(params))
                .collect();
            let found = if on.contains(&stage) {
                let mut session = self.session(cell)?;
                let found = self.render(cell, &mut session, &on)?;
                session.check_validation()?;
                found.ledger
            } else {
                before
            };
            fed.push((stage.name().to_owned(), found));
        }
        Ok(split(ledger.metric.name(), &errors, &fed))
    }

    /// The scene of a cell on the device, at its first time.
    fn session(&mut self, cell: &Cell) -> Result<Session> {
        let scene = match self.scene.take() {
            Some((name, scene)) if name == cell.scene => scene,
            _ => views::open(&self.plan.study, &cell.scene)?,
        };
        let asked = TraceBackend::from_name(&cell.backend)?;
        let backend =
            self.chosen.get(&cell.scene).copied().filter(|_| asked == TraceBackend::Auto).unwrap_or(asked);
        // The backend is chosen by measuring.
        if backend == TraceBackend::Auto {
            self.turn.take();
        } else {
            self.turn.share();
        }
        let session = Session::on(
            &self.device,
            backend,
            &views::camera_args(&self.plan.study, &cell.camera)?,
            scene.clone(),
        );
        self.scene = Some((cell.scene.clone(), scene));
        self.turn.release();
        let session = session?;
        if asked == TraceBackend::Auto {
            self.chosen.insert(cell.scene.clone(), session.gpu.backend());
        }
        if let Some((_, scene)) = &mut self.scene
            && scene.cameras.is_empty()
        {
            // The automatic camera, so that it is searched once.
            scene.cameras.push(session.camera.clone());
        }
        Ok(session)
    }

    /// Renders the frames of a cell, with the output of the stages `on` replaced by ground truth.
    fn render(&mut self, cell: &Cell, session: &mut Session, on: &[Oracle]) -> Result<Rendered> {
        let study = &self.plan.study;
        let params = &self.plan.params[cell.variant];
        let camera = views::camera_args(study, &cell.camera)?;
        let mut full = FullFrame::new(session, cell.size, study.accumulate, params)?;
        if !on.is_empty() {
            let oracles = Oracles::new(&self.device, &full, on, LIGHT_RUNS)?;
            full.feed(Some(oracles));
        }
        let seed = fold_seed(cell.random_seed);
        let time_step = (!study.accumulate).then_some((1.0 / study.fps) as f32);
        let temporal = study.metrics.iter().any(|metric| metric.is_temporal());
        // Temporal errors of the first measured frame need the one before it.
        let first_shot = study.measure.start.saturating_sub(u32::from(temporal));
        let show =
            |wanted: bool| wanted.then(|| ShownTruth::new(&self.device, cell.size, params)).transpose();
        let displays = study.measure_at == MeasureAt::Display;
        let (mut shown, mut shown_half) = (show(displays)?, show(displays && study.ledger.is_some())?);
        // The eye adapts to the truth over all frames.
        let always = shown.is_some() && time_step.is_some() && params.post.meters();
        let mut recorder = Recorder::new(&self.device)?;
        let mut previous = study.time;
        let mut rendered = Rendered {
            last: None,
            values: Vec::new(),
            ledger: Vec::new(),
            reference_noise: Vec::new(),
            timings: Vec::new(),
        };
        for index in 0..study.measure.end.max(study.frames) {
            self.turn.take();
            if index == 0 && self.turn.pause() > LONGEST_PAUSE {
                raise_clock(&self.device)?;
            }
            let time = study.time + if study.accumulate { 0.0 } else { f64::from(index) / study.fps };
            let is_shot = (first_shot..study.measure.end).contains(&index);
            let mut truth = None;
            if is_shot || always || full.oracles().is_some_and(|oracles| oracles.needs_truth()) {
                let record = FullFrame::view(&session.camera.at(time), cell.size, params);
                let (_, scene) = self.scene.as_ref().context("the scene of the cell is open")?;
                let view = View { session, camera: &camera, index, time, record };
                truth = Some(self.truths.of_frame(cell, scene, view)?);
            }
            if let (Some(oracles), Some(truth)) = (full.oracles(), &truth) {
                oracles.set_truth(&truth.image, time_step)?;
            }
            if let (Some(shown), Some(radiance)) = (&mut shown, &truth) {
                let picture = shown.picture_of(&radiance.image, time_step)?;
                let half = match (&mut shown_half, &radiance.half) {
                    (Some(shown), Some(half)) => Some(shown.picture_of(half, time_step)?),
                    _ => None,
                };
                truth = Some(Truth::of_picture(picture, half));
            }
            full.render(&mut recorder, session, FrameTime { time, previous, seed, time_step }, params)?;
            previous = time;
            let Some(truth) = truth.filter(|_| is_shot) else { continue };
            let shot = Shot::of(&full, truth, temporal, study.measure_at)?;
            // The device has finished. Measuring is work of the host.
            self.turn.release();
            if study.measure.contains(&index) {
                let before = rendered.last.as_ref();
                rendered.values.push(shot.measure(before, &study.metrics)?);
                if let Some(ledger) = &study.ledger {
                    rendered.ledger.extend(shot.measure(before, &[ledger.metric])?);
                    rendered.reference_noise.push(shot.reference_noise(ledger.metric));
                }
            }
            rendered.last = Some(shot);
        }
        rendered.timings = recorder.finish()?;
        self.turn.release();
        Ok(rendered)
    }
}

/// The frames of a cell.
struct Rendered {
    /// The last one that was measured.
    last: Option<Shot>,
    /// Of each measured frame, metric by metric.
    values: Vec<Vec<Option<f64>>>,
    /// Of each measured frame, the error that the ledger splits.
    ledger: Vec<Option<f64>>,
    /// The part of it that the noise of the reference has.
    reference_noise: Vec<Option<f64>>,
    timings: Vec<FrameTiming>,
}

/// The mean; `None` if a value is missing.
fn mean(values: &[Option<f64>]) -> Option<f64> {
    let sum = values.iter().copied().sum::<Option<f64>>()?;
    (!values.is_empty()).then(|| sum / values.len() as f64)
}

/// Times of the frames after warm-up and before the first measured one, if they are at least four: a device that waits while the host measures runs
/// slower after it. Otherwise all frames after warm-up.
fn times(cell: &Cell, timings: &[FrameTiming], measured: &Range<u32>, started: Instant) -> TimingRecord {
    let warm = warm(timings);
    let before = warm.partition_point(|timing| timing.frame < measured.start);
    let counted = if before >= 4 { &warm[..before] } else { warm };
    let frame = Spread::of(counted.iter().map(|timing| timing.gpu_ms).collect());
    let pass = |(pass, spread): (String, Spread)| PassTime {
        pass,
        median_ms: spread.median_ms,
        p95_ms: spread.p95_ms,
    };
    TimingRecord {
        cell: cell.name.clone(),
        gpu_ms: frame.median_ms,
        gpu_ms_p95: frame.p95_ms,
        passes: pass_spreads(counted).into_iter().map(pass).collect(),
        wall_s: started.elapsed().as_secs_f64(),
    }
}
