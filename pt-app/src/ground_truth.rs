//! Path traces the ground truth of a frame.

use crate::args::CameraArgs;
use crate::session::{Session, fold_seed};
use anyhow::Result;
use pt_core::Device;
use pt_core::trace::TraceBackend;
use pt_image::image_file::{ImageState, LinearImage};
use pt_reference::{Estimate, EstimateFile, Identity, Progressive, ReferenceParams};
use pt_scene::Scene;
use pt_shaders::records::FrameRecord;

/// Seed of ground truth: no seed of a frame gives the same random numbers in practice.
pub(crate) const SEED: u64 = 0x7275_7468_5f6f_6672;

/// The view that is path traced.
pub struct TruthOf<'a> {
    /// The scene; it is moved to `time`.
    pub scene: &'a Scene,
    /// Its camera.
    pub camera: &'a CameraArgs,
    /// Scene time, seconds.
    pub time: f64,
    /// The cameras and the size of the frame.
    pub record: FrameRecord,
}

/// A view that was path traced.
pub struct PathTraced {
    /// The estimate from all samples.
    pub file: EstimateFile,
    /// Radiance from the first half of the samples; `None` of a single sample. It differs from the whole by an error of the same variance as the
    /// whole has itself: with the means A and B of both halves, the whole is (A + B) / 2 and the difference (A - B) / 2.
    pub half: Option<LinearImage>,
}

/// Path traces a view, in a session of its own: what else is rendered does not depend on whether this was called.
///
/// # Errors
/// A device that can't do it.
pub fn path_trace(
    device: &Device,
    backend: TraceBackend,
    view: &TruthOf<'_>,
    params: &ReferenceParams,
) -> Result<PathTraced> {
    let mut scene = view.scene.clone();
    scene.set_time(view.time, view.time);
    let mut session = Session::on(device, backend, view.camera, scene)?;
    let Session { device, scene, gpu, lights, .. } = &mut session;
    params.prepare_lights(device, scene, gpu, lights)?;
    let record = FrameRecord { seed: fold_seed(SEED), frame_index: 0, ..view.record };
    let spp = params.spp;
    let mut render = Progressive::new(device, gpu, lights, record, params.clone(), None, 0)?;
    let mut half = None;
    for end in [spp / 2, spp] {
        while render.next_sample() < end {
            render.step(scene, gpu, lights, end)?;
        }
        if (1..spp).contains(&end) {
            half = Some(radiance(&render.state()?.estimate(end)));
        }
    }
    let identity = Identity::default().with("scene", &scene.name).with("time", view.time);
    let estimate = render.state()?.estimate(spp);
    let ranges = std::iter::once(0..spp).collect();
    let file = EstimateFile { estimate, ranges, background: params.background, identity };
    Ok(PathTraced { file, half })
}

/// The radiance of an estimate.
pub fn radiance(estimate: &Estimate) -> LinearImage {
    let [width, height] = estimate.size;
    let pixels = estimate.pixels.iter().map(|pixel| pixel.mean.to_array()).collect();
    LinearImage { width, height, pixels, state: ImageState::SceneReferred }
}
