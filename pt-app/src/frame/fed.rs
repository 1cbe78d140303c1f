//! Frames whose light is fed with ground truth: the mean of many runs of the lighting stages on the same surfaces.

use super::{FullFrame, Moment, Oracle};
use crate::params::FrameParams;
use crate::session::Session;
use pt_core::{Frame, Recorder, Result, SceneResources, StageInputs};
use pt_shaders::channels::{COLOR_HF, COLOR_LF_COCG, COLOR_LF_SH, COLOR_SPEC, ChannelId};
use pt_shaders::records::FrameRecord;

/// When a frame is rendered, and with which random numbers.
#[derive(Clone, Copy, Debug)]
pub struct FrameTime {
    /// Scene time, seconds.
    pub time: f64,
    /// Scene time of the frame before.
    pub previous: f64,
    /// Seed of the random numbers.
    pub seed: u32,
    /// See [`Moment::time_step`].
    pub time_step: Option<f32>,
}

impl FullFrame {
    /// Renders one frame. Without stages that are fed with noise-free light it is [`FullFrame::record`] in one submission; with them the lighting
    /// stages run many times with different random numbers, and later stages get the mean of their output. Surfaces and all other random
    /// decisions are those of the frame.
    ///
    /// # Errors
    /// As [`FullFrame::record`].
    pub fn render(
        &mut self,
        recorder: &mut Recorder,
        session: &mut Session,
        at: FrameTime,
        params: &FrameParams,
    ) -> Result<()> {
        let camera = session.camera.at(at.time);
        let mut frame = recorder.begin()?;
        session.update(&mut frame, at.time, at.previous)?;
        if !self.oracles.as_ref().is_some_and(|oracles| oracles.feeds_light()) {
            self.record(&mut frame, &session.gpu, &camera, at.seed, at.time_step, params)?;
            return frame.submit();
        }
        let index = self.moment.map_or(0, |moment| moment.record.frame_index + 1);
        let moment = self.next_moment(&camera, index, at.seed, at.time_step, params);
        self.begin_images(params);
        self.begin_stages(&mut frame, moment, params)?;
        self.surfaces(&mut frame, &self.first_plane(Some(&session.gpu)), params)?;
        frame.submit()?;
        self.light(recorder, &session.gpu, &moment, params)?;
        let mut frame = recorder.begin()?;
        self.uniforms.upload(&mut frame, &moment.record)?;
        let inputs = self.inputs(Some(&session.gpu));
        self.flat_frame(&mut frame, &inputs, params)?;
        self.show(&mut frame, &inputs, moment, params)?;
        frame.submit()
    }

    /// The lighting stages, each once or fed.
    fn light(
        &self,
        recorder: &mut Recorder,
        scene: &dyn SceneResources,
        moment: &Moment,
        params: &FrameParams,
    ) -> Result<()> {
        let (Some(traced), Some(oracles)) = (&self.traced, &self.oracles) else { return Ok(()) };
        let runs = |stage| if oracles.is_fed(stage) { oracles.runs() } else { 1 };
        let lod_bias = params.gbuffer.texture_lod_bias + params.post.mip_bias();
        let inputs = self.inputs(Some(scene));
        let direct = Mean { writes: &[COLOR_HF, COLOR_SPEC], updates: &[], runs: runs(Oracle::Lights) };
        direct.of(self, recorder, &moment.record, |frame| {
            traced.direct.record(frame, &inputs, &params.lights, lod_bias)
        })?;
        let Some(stage) = &traced.indirect else { return Ok(()) };
        let indirect = Mean {
            writes: &[COLOR_LF_SH, COLOR_LF_COCG],
            updates: &[COLOR_SPEC],
            runs: runs(Oracle::Indirect),
        };
        indirect.of(self, recorder, &moment.record, |frame| {
            stage.record(frame, &inputs, &params.indirect, lod_bias)
        })
    }
}

/// The mean of a stage's output over runs with different seeds.
struct Mean<'a> {
    writes: &'a [ChannelId],
    /// Read and written in place: each run begins with the same content.
    updates: &'a [ChannelId],
    runs: u32,
}

impl Mean<'_> {
    fn of(
        &self,
        full: &FullFrame,
        recorder: &mut Recorder,
        record: &FrameRecord,
        stage: impl Fn(&mut Frame<'_>) -> Result<()>,
    ) -> Result<()> {
        let mut run = |record: &FrameRecord| {
            let mut frame = recorder.begin()?;
            full.uniforms.upload(&mut frame, record)?;
            stage(&mut frame)?;
            frame.submit()
        };
        if self.runs == 1 {
            return run(record);
        }
        let read = |id: &ChannelId| full.images.current(*id).read_f32();
        let before = self.updates.iter().map(read).collect::<Result<Vec<_>>>()?;
        let outputs: Vec<ChannelId> = self.writes.iter().chain(self.updates).copied().collect();
        let mut sums: Vec<Vec<f64>> = vec![Vec::new(); outputs.len()];
        for number in 1..=self.runs {
            for (id, content) in self.updates.iter().zip(&before) {
                full.images.current(*id).write_f32(content)?;
            }
            let seed = record.seed.wrapping_add(number.wrapping_mul(0x9e37_79b9));
            run(&FrameRecord { seed, ..*record })?;
            for (sum, id) in sums.iter_mut().zip(&outputs) {
                let values = read(id)?;
                sum.resize(values.len(), 0.0);
                sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += f64::from(value));
            }
        }
        for (sum, id) in sums.iter().zip(&outputs) {
            let mean: Vec<f32> = sum.iter().map(|sum| (sum / f64::from(self.runs)) as f32).collect();
            full.images.current(*id).write_f32(&mean)?;
        }
        Ok(())
    }
}

impl FullFrame {
    /// What the stages get.
    pub(super) fn inputs<'a>(&'a self, scene: Option<&'a dyn SceneResources>) -> StageInputs<'a> {
        StageInputs { scene, uniforms: Some(&self.uniforms), images: &self.images }
    }
}
