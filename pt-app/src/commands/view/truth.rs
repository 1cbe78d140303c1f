//! The ground truth of what the frame shows, path traced a little more after each frame.

use super::looking::Codes;
use crate::args::CameraArgs;
use crate::frame::{FullFrame, ShownTruth};
use crate::ground_truth::{SEED, radiance};
use crate::params::FrameParams;
use crate::session::{Session, fold_seed};
use anyhow::Result;
use pt_core::Device;
use pt_core::trace::TraceBackend;
use pt_image::image_file::{ImageState, LinearImage, srgb_encode_8bit};
use pt_image::metrics::{Metric, compare, heatmap};
use pt_reference::{LightTypes, Progressive, ReferenceParams};
use pt_scene::{Camera, Scene};
use pt_shaders::records::FrameRecord;
use pt_view::protocol::{TruthState, TruthView};
use std::time::{Duration, Instant};

/// FLIP at the upper end of the scale of differences.
pub(super) const MOST_FLIP: f32 = 0.5;
/// Frames wait for a step.
const STEP: Duration = Duration::from_millis(30);
/// Between two looks at the samples so far: reading them back and comparing takes time from the frames.
const INTERVAL: Duration = Duration::from_millis(500);
/// Samples a pixel after which it rests.
const MOST_SAMPLES: u32 = 1 << 16;

/// All that the ground truth depends on.
#[derive(Clone, PartialEq)]
struct Seen {
    record: FrameRecord,
    time: f64,
    params: ReferenceParams,
}

/// A render of the ground truth that goes on.
struct Tracing {
    session: Session,
    render: Progressive,
    seen: Seen,
}

/// The ground truth, in a session of its own: the frame does not depend on whether it is traced.
pub(super) struct Truth {
    device: Device,
    backend: TraceBackend,
    tracing: Option<Tracing>,
    /// How the frame is shown, and what shows the truth so.
    shown: Option<(FrameParams, ShownTruth)>,
    looked_at: Option<Instant>,
    view: TruthView,
    state: TruthState,
}

impl Truth {
    /// Nothing is traced yet.
    pub(super) fn new(device: &Device, backend: TraceBackend) -> Self {
        let device = device.clone();
        let (view, state) = (TruthView::Off, TruthState::default());
        Self { device, backend, tracing: None, shown: None, looked_at: None, view, state }
    }

    /// How far it is.
    pub(super) fn state(&self) -> TruthState {
        self.state
    }

    /// Traces some samples of what `camera` sees at `time`, from the beginning if it sees something else than before. Returns a picture from time to time.
    ///
    /// # Errors
    /// When the device fails.
    pub(super) fn advance(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        time: f64,
        full: &FullFrame,
        params: &FrameParams,
        view: TruthView,
    ) -> Result<Option<Codes>> {
        let size = full.images().output_size();
        let record = FullFrame::view(camera, size, params);
        let record = FrameRecord { seed: fold_seed(SEED), frame_index: 0, ..record };
        let seen = Seen { record, time, params: reference_params(params) };
        if self.tracing.as_ref().is_none_or(|tracing| tracing.seen != seen) {
            self.begin(scene, seen)?;
        }
        let Some(Tracing { session, render, .. }) = &mut self.tracing else { return Ok(None) };
        let Session { scene, gpu, lights, .. } = session;
        render.step(scene, gpu, lights, MOST_SAMPLES)?;
        if std::mem::replace(&mut self.view, view) != view {
            self.looked_at = None;
        }
        if self.looked_at.is_some_and(|looked| looked.elapsed() < INTERVAL) {
            return Ok(None);
        }
        let codes = self.look(full, params, view)?;
        self.looked_at = Some(Instant::now());
        Ok(Some(codes))
    }

    fn begin(&mut self, scene: &Scene, seen: Seen) -> Result<()> {
        // Another time moves the scene; another view of it does not.
        let kept = self.tracing.take().filter(|tracing| tracing.seen.time == seen.time);
        let mut session = match kept {
            Some(tracing) => tracing.session,
            None => {
                let mut scene = scene.clone();
                scene.set_time(seen.time, seen.time);
                Session::on(&self.device, self.backend, &CameraArgs::default(), scene)?
            }
        };
        let Session { device, scene, gpu, lights, .. } = &mut session;
        seen.params.prepare_lights(device, scene, gpu, lights)?;
        let render = Progressive::new(device, gpu, lights, seen.record, seen.params.clone(), None, 0)?
            .with_step_time(STEP);
        self.tracing = Some(Tracing { session, render, seen });
        self.looked_at = None;
        self.state = TruthState::default();
        Ok(())
    }

    /// The picture of the samples so far, and the errors of the frame.
    fn look(&mut self, full: &FullFrame, params: &FrameParams, view: TruthView) -> Result<Codes> {
        let Some(Tracing { render, .. }) = &self.tracing else {
            return Ok(Codes { size: [0; 2], texels: Vec::new() });
        };
        let samples = render.next_sample();
        let estimate = render.state()?.estimate(samples);
        let truth = radiance(&estimate);
        let size = full.images().output_size();
        let post_is_same = |(made_for, _): &(FrameParams, ShownTruth)| made_for.post == params.post;
        if !self.shown.as_ref().is_some_and(post_is_same) {
            self.shown = Some((params.clone(), ShownTruth::new(&self.device, size, params)?));
        }
        let Some((_, shown)) = &mut self.shown else { return Ok(Codes { size, texels: Vec::new() }) };
        // Without a time step the eye is adapted at once.
        let picture = shown.picture_of(&truth, None)?;
        let flip = compare(&full.picture()?, &picture, &[Metric::Flip]).ok().and_then(|mut all| all.pop());
        let frame = frame_radiance(full)?;
        let rel_mse = compare(&frame, &truth, &[Metric::RelMse]).ok().and_then(|mut all| all.pop());
        self.state = TruthState {
            samples,
            relative_error: (samples > 1).then(|| estimate.relative_error()),
            flip: flip.as_ref().map(|flip| flip.value),
            rel_mse: rel_mse.map(|error| error.value),
        };
        let rgb = match (view, flip) {
            (TruthView::Difference, Some(flip)) => heatmap(&flip.map, MOST_FLIP),
            _ => picture.pixels.iter().flatten().map(|&value| srgb_encode_8bit(value)).collect(),
        };
        let texels = rgb.chunks_exact(3).flat_map(|c| [c[0], c[1], c[2], 255]).collect();
        Ok(Codes { size, texels })
    }
}

/// The knobs of the frame that the ground truth shares: which light there is, and in what medium.
fn reference_params(params: &FrameParams) -> ReferenceParams {
    let lights = &params.lights;
    let light_types = LightTypes {
        sun: lights.sun,
        positional: lights.positional,
        emissive: lights.emissive,
        environment: lights.environment,
    };
    let background = params.denoise.background;
    ReferenceParams { light_types, medium: params.medium(), background, ..ReferenceParams::default() }
}

fn frame_radiance(full: &FullFrame) -> Result<LinearImage> {
    let image = full.radiance();
    let [width, height] = image.extent();
    let pixels = image.read_f32()?.chunks_exact(4).map(|c| [c[0], c[1], c[2]]).collect();
    Ok(LinearImage { width, height, pixels, state: ImageState::SceneReferred })
}
