//! What can be asked of a frame.

use super::planes::MorePlanes;
use super::{FrameStage, FullFrame, Moment};
use pt_core::{Buffer, ChannelImages, Image, Result};
use pt_image::image_file::{ImageState, LinearImage, srgb_decode};
use pt_post::{ExposureRecord, Metered};
use pt_shaders::channels::DISPLAY;

impl FullFrame {
    /// All images, as the last frame left them.
    pub fn images(&self) -> &ChannelImages {
        &self.images
    }

    /// The images of each plane, those of the first one are [`FullFrame::images`]. Without `gbuffer.decomposition=planes`, or glass, there is one plane.
    pub fn planes(&self) -> Vec<&ChannelImages> {
        let more = self.more_planes.iter().flat_map(MorePlanes::images);
        std::iter::once(&self.images).chain(more).collect()
    }

    /// All images, to load histories into.
    pub fn images_mut(&mut self) -> &mut ChannelImages {
        &mut self.images
    }

    /// Buffers that carry state to the next frame, besides the images.
    pub fn state(&self) -> Vec<&Buffer> {
        self.post.state()
    }

    /// The picture as linear scene radiance, before bloom and exposure. With FSR 1 it has the size of the frame.
    pub fn radiance(&self) -> &Image {
        self.post.resolved(&self.images)
    }

    /// The picture as linear values of an sRGB display, 0 to 1; waits for it.
    ///
    /// # Errors
    /// When the device fails.
    pub fn picture(&self) -> Result<LinearImage> {
        let codes = self.images.current(DISPLAY);
        let [width, height] = codes.extent();
        let decoded = |code: &[f32]| [code[0], code[1], code[2]].map(srgb_decode);
        let pixels = codes.read_f32()?.chunks_exact(4).map(decoded).collect();
        Ok(LinearImage { width, height, pixels, state: ImageState::DisplayReferred })
    }

    /// With a transparent background: straight radiance and alpha of [`FullFrame::radiance`], which is premultiplied.
    pub fn matte(&self) -> Option<&Image> {
        self.post.matte(&self.images)
    }

    /// The stage of each pass of the last frame, those before its stages included.
    pub fn pass_stages(&self) -> Vec<FrameStage> {
        self.pass_stages.borrow().clone()
    }

    /// Parameters of the last frame; `None` before the first.
    pub fn moment(&self) -> Option<&Moment> {
        self.moment.as_ref()
    }

    /// The exposure that the last frame was shown with; waits for it.
    ///
    /// # Errors
    /// When the device fails.
    pub fn exposure(&self) -> Result<ExposureRecord> {
        self.post.exposure().read()
    }

    /// Exposure and tone curve that the last frame was shown with; waits for it.
    ///
    /// # Errors
    /// When the device fails.
    pub fn metered(&self) -> Result<Metered> {
        self.post.exposure().metered()
    }
}
