//! Recorded frames: images of the frame as layers of EXR files, both ways, and folders of frames in sequence.
//!
//! A capture of one frame is a [`LayeredImage`] with one layer per channel, named as in the channel table, in flat scan-line
//! order. A column of the table says how texels are stored ([`pt_shaders::channels::Stored`]). Loading a layer restores the texels
//! that it was written from, with two limits: texels of a split image of odd width that have no flat pixel are not recorded and
//! become zero; NaN becomes NaN, perhaps with other bits.
//!
//! Metadata: text under the keys of [`keys`]; readers need none of them.

pub mod folder;
mod layer;
pub mod sidecar;

pub use layer::{CaptureError, layer_of, load_image, read_layer, read_pixel, write_layer};

use crate::channels::ChannelImages;
use crate::device::Device;
use crate::plan::{FramePlan, StageIo};
use crate::sizes::FrameSizes;
use pt_image::image_file::LayeredImage;

/// Metadata of a capture. In the file they are string attributes called `pt.KEY`.
pub mod keys {
    pub use pt_image::image_file::IMAGE_STATE_KEY as IMAGE_STATE;
    /// Name of the scene.
    pub const SCENE: &str = "scene";
    /// The camera, in words that are the same for the same view.
    pub const CAMERA: &str = "camera";
    /// The environment: size, rotation, intensity, and a hash of its content.
    pub const ENVIRONMENT: &str = "environment";
    /// Which light the image carries: direct light only, or how many bounces.
    pub const LIGHT: &str = "light";
    /// Time of the first frame in the scene's animation, seconds.
    pub const TIME: &str = "time";
    /// Number of frames rendered; the last one is recorded.
    pub const FRAMES: &str = "frames";
    /// `true`: the main layer is the mean of the frames.
    pub const ACCUMULATE: &str = "accumulate";
    /// Seed of the random numbers.
    pub const SEED: &str = "seed";
    /// All knobs, as JSON.
    pub const PARAMS: &str = "params";
    /// Exposure value at ISO 100 that the last frame was shown with.
    pub const EV100: &str = "ev100";
    /// Factor that took scene radiance to exposed values for the last frame, compensation included.
    pub const EXPOSURE: &str = "exposure";
    /// Where in its pixels the last frame was sampled, from the centre, pixels: `x,y`.
    pub const JITTER: &str = "jitter";
    /// Vulkan device.
    pub const DEVICE: &str = "device";
    /// Driver's name and version.
    pub const DRIVER: &str = "driver";
    /// Trace backend that was asked for.
    pub const BACKEND: &str = "backend";
    /// Version of the program that wrote the file.
    pub const VERSION: &str = "version";
}

/// Allocates the images of stages for the frame in `capture`, and loads the images that they read from its layers.
///
/// # Errors
/// A layer or component that is missing, or a device that refuses.
pub fn load(
    device: &Device,
    capture: &LayeredImage,
    stages: &[StageIo],
) -> Result<ChannelImages, CaptureError> {
    let sizes = FrameSizes::same([capture.width, capture.height]);
    let images = ChannelImages::alone(device, sizes, stages)?;
    for id in FramePlan::new(sizes).missing(stages) {
        load_image(&images, id, capture)?;
    }
    Ok(images)
}
