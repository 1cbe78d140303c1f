//! Stages whose output is replaced by ground truth, to see what error the stages after them add.

use super::FullFrame;
use pt_core::split::to_split;
use pt_core::{Device, Error, Frame, Image, Result, Substitute};
use pt_image::image_file::LinearImage;
use pt_shaders::channels::{COLOR, FLAT_COLOR, Format};
use pt_shaders::named_enum;

named_enum! {
    /// Stages whose output can be replaced by ground truth, in the order of the frame.
    pub enum Oracle {
        /// The composite of the denoised light: what is left is the error of interleave and anti-aliasing.
        Denoise = "denoise",
        /// The flat frame: what is left is the error of anti-aliasing.
        Interleave = "interleave",
        /// The anti-aliased frame: what is left is its rounding to half floats.
        Taa = "taa",
    }
}

/// The replaced stages of a frame. Ground truth is the radiance of whole pixels, so that anti-aliasing is told that a fed frame was sampled in the
/// middle of its pixels.
pub struct Oracles {
    on: Vec<Oracle>,
    full: Substitute,
    half: Substitute,
    /// Ground truth in the order of the fields.
    split: Image,
    /// Ground truth in the order of the picture.
    flat: Image,
}

impl Oracles {
    /// The names of all stages.
    pub fn names() -> Vec<&'static str> {
        use pt_shaders::NamedEnum;
        Oracle::NAMED.iter().map(|value| value.name).collect()
    }

    /// Replaces the output of the stages `on` in a frame.
    ///
    /// # Errors
    /// A frame that lacks a stage, or that is smaller than its picture; a device that refuses.
    pub fn new(device: &Device, frame: &FullFrame, on: &[Oracle]) -> Result<Self> {
        if on.contains(&Oracle::Taa) && !frame.post.has_taa() {
            return Err(Error::Unsupported(
                "the frame has no taa to feed with ground truth; post.taa.enabled=true switches it on".into(),
            ));
        }
        let size = frame.images.size();
        if frame.radiance().extent() != size {
            return Err(Error::Unsupported(
                "a frame that is upscaled cannot be fed with ground truth; post.upscale=none".into(),
            ));
        }
        let image = |name, extent| Image::new(device, name, Format::Rgba32F, extent);
        Ok(Self {
            on: on.to_vec(),
            full: Substitute::new(device, Format::Rgba32F)?,
            half: Substitute::new(device, Format::Rgba16F)?,
            split: image("ground truth, split", pt_core::split::split_size(size))?,
            flat: image("ground truth", size)?,
        })
    }

    /// Sets the ground truth of the next frame; waits for the device.
    ///
    /// # Errors
    /// Another size than the frame's; a device that fails.
    pub fn set_truth(&self, truth: &LinearImage) -> Result<()> {
        let size = [truth.width, truth.height];
        if size != self.flat.extent() {
            return Err(Error::Unsupported("the ground truth has not the size of the frame".into()));
        }
        let texels: Vec<[f32; 4]> = truth.pixels.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect();
        self.flat.write_f32(texels.as_flattened())?;
        self.split.write_f32(to_split(&texels, size, [0.0; 4]).as_flattened())
    }

    /// Whether the colour that anti-aliasing reads is ground truth.
    pub(super) fn feeds_taa(&self) -> bool {
        self.on.iter().any(|stage| *stage != Oracle::Taa)
    }

    pub(super) fn after_composite(&self, frame: &mut Frame<'_>, full: &FullFrame) -> Result<()> {
        self.feed(frame, Oracle::Denoise, &self.full, &self.split, full.images.current(COLOR))
    }

    pub(super) fn after_interleave(&self, frame: &mut Frame<'_>, full: &FullFrame) -> Result<()> {
        self.feed(frame, Oracle::Interleave, &self.full, &self.flat, full.images.current(FLAT_COLOR))
    }

    pub(super) fn after_taa(&self, frame: &mut Frame<'_>, resolved: &Image) -> Result<()> {
        self.feed(frame, Oracle::Taa, &self.half, &self.flat, resolved)
    }

    fn feed(
        &self,
        frame: &mut Frame<'_>,
        stage: Oracle,
        pass: &Substitute,
        truth: &Image,
        target: &Image,
    ) -> Result<()> {
        if !self.on.contains(&stage) {
            return Ok(());
        }
        pass.record(frame, &format!("ground truth of {}", stage.name()), truth, target)
    }
}
