//! The session with its frame, from the first frame on.

use crate::args::FrameArgs;
use crate::frame::{FrameTime, FullFrame};
use crate::params::FrameParams;
use crate::session::Session;
use anyhow::Result;
use pt_core::Recorder;
use pt_core::trace::TraceBackend;
use pt_scene::Camera;
use pt_view::protocol::PassTime;

/// A session and its frame. A new one renders the frames that `pt render` renders.
pub(super) struct Running {
    pub(super) session: Session,
    pub(super) full: FullFrame,
    recorder: Recorder,
}

/// Times of the passes of a frame.
#[derive(Clone, Debug, Default)]
pub(super) struct Times {
    pub(super) frame_ms: f64,
    pub(super) passes: Vec<PassTime>,
}

impl Running {
    /// The frame of a session that has rendered none.
    ///
    /// # Errors
    /// When the device refuses.
    pub(super) fn new(mut session: Session, args: &FrameArgs, params: &FrameParams) -> Result<Self> {
        let full = FullFrame::new(&mut session, args.output_size(), args.accumulate, params)?;
        let mut recorder = Recorder::new(&session.device)?;
        recorder.count_rays()?;
        Ok(Self { session, full, recorder })
    }

    /// All anew, with the scene at `time`: what earlier frames have left anywhere is gone.
    ///
    /// # Errors
    /// When the device refuses.
    pub(super) fn anew(
        self,
        args: &FrameArgs,
        params: &FrameParams,
        camera: Camera,
        time: f64,
    ) -> Result<Self> {
        let Self { session, full, recorder } = self;
        drop((full, recorder));
        let Session { device, mut scene, gpu, lights, .. } = session;
        let backend: TraceBackend = gpu.backend();
        drop((gpu, lights));
        scene.set_time(time, time);
        let mut session = Session::on(&device, backend, &args.camera, scene)?;
        session.camera = camera;
        Self::new(session, args, params)
    }

    /// The stages anew, for other structural knobs.
    ///
    /// # Errors
    /// When the device refuses.
    pub(super) fn remake(&mut self, args: &FrameArgs, params: &FrameParams) -> Result<()> {
        self.full = FullFrame::new(&mut self.session, args.output_size(), args.accumulate, params)?;
        Ok(())
    }

    /// Renders a frame and waits for it.
    ///
    /// # Errors
    /// When the device fails.
    pub(super) fn render(&mut self, at: FrameTime, params: &FrameParams) -> Result<Times> {
        self.full.render(&mut self.recorder, &mut self.session, at, params)?;
        let mut timings = self.recorder.finish()?;
        let rays = self.recorder.ray_counts()?;
        let Some(frame) = timings.pop() else { return Ok(Times::default()) };
        let table = self.recorder.pass_table();
        let pass = |(index, timing): (usize, pt_core::frame::PassTiming)| PassTime {
            rays: rays.iter().filter(|pass| pass.pass == timing.pass).map(|pass| pass.rays).sum(),
            bytes: table.get(index).map_or(0, |row| row.bytes),
            name: timing.pass,
            ms: timing.ms,
        };
        Ok(Times { frame_ms: frame.gpu_ms, passes: frame.passes.into_iter().enumerate().map(pass).collect() })
    }
}
