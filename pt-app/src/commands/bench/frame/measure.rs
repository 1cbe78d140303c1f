//! Rounds of frames, and what is known of their passes.

use super::file::{How, Part, PassRecord, Rays, StageRow, Times};
use crate::commands::bench::least_warm_up_s;
use crate::frame::{FrameStage, FullFrame, Stage};
use crate::params::FrameParams;
use crate::session::Session;
use anyhow::{Context, Result};
use pt_core::frame::{FrameTiming, PassInfo, PassRays};
use pt_core::harness::{Spread, WARM_UP};
use pt_core::trace::RayKind;
use pt_core::{Device, Frame, Recorder};
use pt_shaders::NamedEnum;
use std::time::Instant;

/// Seconds of scene time between frames.
const TIME_STEP: f64 = 1.0 / 60.0;

/// What to measure.
#[derive(Clone, Copy)]
pub(super) struct Plan<'a> {
    pub(super) size: [u32; 2],
    pub(super) frames: u32,
    pub(super) rounds: u32,
    pub(super) seed: u32,
    pub(super) params: &'a FrameParams,
}

/// The whole frame.
pub(super) struct Whole<'a> {
    full: FullFrame,
    plan: Plan<'a>,
}

impl<'a> Whole<'a> {
    pub(super) fn new(session: &mut Session, plan: Plan<'a>) -> Result<Self> {
        Ok(Self { full: FullFrame::new(session, plan.size, false, plan.params)?, plan })
    }

    pub(super) fn frame_size(&self) -> [u32; 2] {
        self.full.images().size()
    }

    fn record(&mut self, session: &mut Session, frame: &mut Frame<'_>) -> Result<Vec<FrameStage>> {
        let time = |index: u32| TIME_STEP * f64::from(index);
        let (now, before) = (time(frame.index()), time(frame.index().saturating_sub(1)));
        session.update(frame, now, before)?;
        let Plan { seed, params, .. } = self.plan;
        let camera = session.camera.at(now);
        self.full.record(frame, &session.gpu, &camera, seed, Some(TIME_STEP as f32), params)?;
        Ok(self.full.pass_stages())
    }

    /// Runs frames until the histories are full and the device is warm.
    pub(super) fn warm_up(&mut self, session: &mut Session) -> Result<()> {
        let device = session.device.clone();
        warm_up(&device, |frame| self.record(session, frame))
    }

    /// The passes of `stage` within the frame, or all.
    pub(super) fn measure(&mut self, session: &mut Session, stage: Option<FrameStage>) -> Result<Part> {
        self.warm_up(session)?;
        let device = session.device.clone();
        let mut samples = Samples::new(self.plan);
        for _ in 0..self.plan.rounds {
            self.full.reset_history();
            samples.round(&device, |frame| self.record(session, frame))?;
        }
        self.full.reset_history();
        let rays = self.count_rays(session)?;
        Ok(samples.part(stage, How::Frame, &rays))
    }

    /// Rays of the first frame that counts, in frames of their own.
    fn count_rays(&mut self, session: &mut Session) -> Result<Vec<PassRays>> {
        let mut recorder = Recorder::new(&session.device)?;
        for index in 0..=WARM_UP {
            if index == WARM_UP {
                recorder.count_rays()?;
            }
            let mut frame = recorder.begin()?;
            self.record(session, &mut frame)?;
            frame.submit()?;
        }
        Ok(recorder.ray_counts()?)
    }

    /// Whether a stage can run alone: of several planes it would be the part of one.
    pub(super) fn can_replay(&self, from: Stage) -> bool {
        from == Stage::Post || self.full.planes().len() == 1
    }

    /// A stage alone, on the images of the last frame.
    pub(super) fn replay(&self, session: &Session, stage: FrameStage) -> Result<Part> {
        let Plan { size, params, .. } = self.plan;
        let first = stage.replayed().with_context(|| format!("{} needs rays", stage.name()))?;
        let moment = *self.full.moment().context("no frame was recorded")?;
        let mut alone = FullFrame::starting_at(&session.device, first, size, false, params)?;
        // Images that are kept for the next frame exist twice; both get the content.
        let mut to_load = 2;
        let mut record = |frame: &mut Frame<'_>| -> Result<Vec<FrameStage>> {
            alone.replay(frame, moment, params, |images, given| -> pt_core::Result<()> {
                if to_load > 0 {
                    to_load -= 1;
                    for &id in given {
                        images.current(id).write(&self.full.images().current(id).read()?)?;
                    }
                }
                Ok(())
            })?;
            Ok(alone.pass_stages())
        };
        warm_up(&session.device, &mut record)?;
        let mut samples = Samples::new(self.plan);
        for _ in 0..self.plan.rounds {
            samples.round(&session.device, &mut record)?;
        }
        Ok(samples.part(Some(stage), How::Replay, &[]))
    }
}

fn warm_up(device: &Device, mut record: impl FnMut(&mut Frame<'_>) -> Result<Vec<FrameStage>>) -> Result<()> {
    let least = least_warm_up_s(device);
    let mut recorder = Recorder::new(device)?;
    let started = Instant::now();
    let mut frames = 0;
    while frames < WARM_UP || started.elapsed().as_secs_f64() < least {
        let mut frame = recorder.begin()?;
        record(&mut frame)?;
        frame.submit()?;
        frames += 1;
    }
    recorder.finish()?;
    Ok(())
}

/// Times of the passes by round.
struct Samples<'a> {
    plan: Plan<'a>,
    frame: Vec<Vec<f64>>,
    passes: Vec<PassSamples>,
}

/// Times of one pass.
struct PassSamples {
    name: String,
    stage: FrameStage,
    info: PassInfo,
    /// By round, each with the number of the frame in the round.
    ms: Vec<Vec<(usize, f64)>>,
}

impl<'a> Samples<'a> {
    fn new(plan: Plan<'a>) -> Self {
        Self { plan, frame: Vec::new(), passes: Vec::new() }
    }

    /// Records and times a round. `record` returns the stages of the passes.
    fn round(
        &mut self,
        device: &Device,
        mut record: impl FnMut(&mut Frame<'_>) -> Result<Vec<FrameStage>>,
    ) -> Result<()> {
        let mut recorder = Recorder::new(device)?;
        let mut described = Vec::new();
        for _ in 0..WARM_UP + self.plan.frames {
            let mut frame = recorder.begin()?;
            let stages = record(&mut frame)?;
            frame.submit()?;
            described.push((stages, recorder.pass_table().to_vec()));
        }
        let timings = recorder.finish()?;
        let first = timings.partition_point(|timing| timing.frame < WARM_UP);
        self.frame.push(timings[first..].iter().map(|frame| frame.gpu_ms).collect());
        for (index, timing) in timings[first..].iter().enumerate() {
            let (stages, table) = &described[timing.frame as usize];
            self.add(index, timing, stages, table);
        }
        Ok(())
    }

    fn add(&mut self, index: usize, timing: &FrameTiming, stages: &[FrameStage], table: &[PassInfo]) {
        let rounds = self.frame.len();
        let mut names: Vec<String> = Vec::new();
        for ((pass, info), stage) in timing.passes.iter().zip(table).zip(stages) {
            let again = timing.passes[..names.len()].iter().filter(|before| before.pass == pass.pass).count();
            let name = if again == 0 { pass.pass.clone() } else { format!("{} ({})", pass.pass, again + 1) };
            let place = self.passes.iter().position(|known| known.name == name).unwrap_or_else(|| {
                // A pass that only some frames have stands behind the one that it follows.
                let before =
                    names.last().and_then(|last| self.passes.iter().position(|known| known.name == *last));
                let place = before.map_or(0, |before| before + 1);
                let pass =
                    PassSamples { name: name.clone(), stage: *stage, info: info.clone(), ms: Vec::new() };
                self.passes.insert(place, pass);
                place
            });
            let samples = &mut self.passes[place];
            samples.ms.resize(rounds, Vec::new());
            samples.ms[rounds - 1].push((index, pass.ms));
            names.push(name);
        }
    }

    /// The result for a stage, or for the whole frame.
    fn part(mut self, stage: Option<FrameStage>, how: How, rays: &[PassRays]) -> Part {
        self.passes.retain(|pass| stage.is_none_or(|stage| pass.stage == stage));
        let time = match stage {
            None => Times::of(self.frame.clone()),
            Some(stage) => Times::of(self.sums(stage)),
        };
        let has_passes = |stage: &&FrameStage| self.passes.iter().any(|pass| pass.stage == **stage);
        let listed: Vec<_> = match stage {
            None => FrameStage::VALUES.iter().filter(has_passes).copied().collect(),
            Some(_) => Vec::new(),
        };
        let stages = listed.into_iter().map(|stage| {
            let Spread { median_ms, p95_ms } = Spread::of(self.sums(stage).concat());
            StageRow { stage, median_ms, p95_ms }
        });
        Part {
            name: stage.map_or("frame", NamedEnum::name).into(),
            how,
            time,
            stages: stages.collect(),
            passes: self.passes.iter().map(|pass| pass.record(rays)).collect(),
        }
    }

    /// Time of all passes of a stage, by round and frame.
    fn sums(&self, stage: FrameStage) -> Vec<Vec<f64>> {
        let mut sums: Vec<Vec<f64>> = self.frame.iter().map(|round| vec![0.0; round.len()]).collect();
        for pass in self.passes.iter().filter(|pass| pass.stage == stage) {
            for (sums, times) in sums.iter_mut().zip(&pass.ms) {
                times.iter().for_each(|(index, ms)| sums[*index] += ms);
            }
        }
        sums
    }
}

impl PassSamples {
    fn record(&self, rays: &[PassRays]) -> PassRecord {
        let counted = rays.iter().find(|of| of.pass == self.name);
        PassRecord {
            pass: self.name.clone(),
            stage: self.stage,
            time: Times::of(self.ms.iter().map(|round| round.iter().map(|(_, ms)| *ms).collect()).collect()),
            bytes: self.info.bytes,
            bytes_are_upper_bound: self.info.bytes_are_upper_bound,
            rays: counted.map(|of| Rays {
                kind: ray_kind(&of.pass),
                count: of.rays,
                is_upper_bound: of.is_upper_bound,
            }),
        }
    }
}

/// The kind of rays whose rate those of a pass are compared with.
fn ray_kind(pass: &str) -> RayKind {
    // Passes of the other planes say which.
    match pass.split(", plane ").next().unwrap_or(pass) {
        "primary rays" => RayKind::Primary,
        "shadow rays" => RayKind::Shadow,
        pass if pass.starts_with("bounce shadow rays") || pass.starts_with("bounce glass") => {
            RayKind::BounceShadow
        }
        _ => RayKind::Bounce,
    }
}
