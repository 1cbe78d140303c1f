//! The ground truth as it would be shown.

use super::{FullFrame, Moment, Stage};
use crate::params::FrameParams;
use pt_core::{Device, Recorder, Result};
use pt_image::image_file::LinearImage;
use pt_post::{Metered, Upscale};
use pt_scene::Camera;
use pt_shaders::channels::FLAT_COLOR;
use pt_shaders::glam::Vec3;
use pt_shaders::records::FrameRecord;

/// Shows ground truth as a frame is shown: the same bloom, exposure, tone curve and dither, without anti-aliasing and upscaling. It is metered by
/// itself, and the eye adapts to it over the frames that it is given.
pub struct ShownTruth {
    full: FullFrame,
    recorder: Recorder,
    params: FrameParams,
    /// Some view: the stages from here on look at no camera.
    view: FrameRecord,
}

impl ShownTruth {
    /// For pictures of `size` pixels, which frames of `params` stand beside.
    ///
    /// # Errors
    /// When the device refuses.
    pub fn new(device: &Device, size: [u32; 2], params: &FrameParams) -> Result<Self> {
        let mut params = params.clone();
        params.post.taa.enabled = false;
        params.post.fsr.sharpen = false;
        (params.post.upscale, params.post.render_scale) = (Upscale::None, 1.0);
        let full = FullFrame::starting_at(device, Stage::Post, size, false, &params)?;
        let view = FullFrame::view(&Camera::look_at("", Vec3::ZERO, Vec3::NEG_Z, 1.0), size, &params);
        Ok(Self { full, recorder: Recorder::new(device)?, params, view })
    }

    /// Shows the ground truth of the next frame; waits for the device. `time_step`: see [`Moment::time_step`].
    ///
    /// # Errors
    /// When the device fails.
    pub fn show(&mut self, truth: &LinearImage, time_step: Option<f32>) -> Result<()> {
        let texels: Vec<[f32; 4]> = truth.pixels.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect();
        let moment = Moment { record: self.view, jitter: [0.0; 2], time_step };
        let mut frame = self.recorder.begin()?;
        self.full.replay(&mut frame, moment, &self.params, |images, _| {
            images.current(FLAT_COLOR).write_f32(texels.as_flattened())
        })?;
        frame.submit()?;
        self.recorder.finish().map(drop)
    }

    /// What the last ground truth was shown with.
    ///
    /// # Errors
    /// When the device fails.
    pub fn metered(&self) -> Result<Metered> {
        self.full.metered()
    }

    /// Shows the ground truth of the next frame, as [`ShownTruth::show`], and returns the picture: linear display values.
    ///
    /// # Errors
    /// When the device fails.
    pub fn picture_of(&mut self, truth: &LinearImage, time_step: Option<f32>) -> Result<LinearImage> {
        self.show(truth, time_step)?;
        self.full.picture()
    }
}
