//! The finished picture as a file.

use crate::images::MATTE;
use crate::records::Encoding;
use pt_core::ChannelImages;
use pt_image::image_file::{
    ImageFileError, Layer, LayeredImage, OutputFormat, PixelLayout, srgb_decode, write_jpeg, write_png,
    write_png_pq,
};
use pt_shaders::channels::{ChannelId, DISPLAY, DISPLAY_HDR};
use std::path::{Path, PathBuf};

/// Why a picture could not be written.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The device failed.
    #[error(transparent)]
    Device(#[from] pt_core::Error),
    /// The file could not be written.
    #[error(transparent)]
    File(#[from] ImageFileError),
    /// The kind of file cannot hold the codes.
    #[error("{}: {problem}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What it cannot hold, and what can.
        problem: &'static str,
    },
}

impl Encoding {
    /// The channel that holds the picture.
    pub fn channel(self) -> ChannelId {
        if self.is_hdr() { DISPLAY_HDR } else { DISPLAY }
    }

    /// Checks before any work that a picture of this encoding can go to `path`: PNG holds sRGB and PQ codes, JPEG sRGB codes, EXR the linear
    /// display values of sRGB and scRGB.
    ///
    /// # Errors
    /// An extension that is unknown or cannot hold the codes.
    pub fn check_file(self, path: &Path) -> Result<OutputFormat, PictureError> {
        let problem = |problem| Err(PictureError::Format { path: path.into(), problem });
        match (OutputFormat::of(path)?, self) {
            (OutputFormat::Png, Self::Scrgb) => {
                problem("a png cannot hold scRGB; write exr, or ask for encoding pq")
            }
            (OutputFormat::Jpeg, Self::Pq | Self::Scrgb) => {
                problem("a jpg holds sRGB codes only; write PQ codes to a png and scRGB to an exr")
            }
            (OutputFormat::Exr, Self::Pq) => problem("PQ codes go to a png; for exr ask for encoding scrgb"),
            (format, _) => Ok(format),
        }
    }
}

/// Writes the picture as a PNG, tagged with what its codes mean (sRGB chunk; cICP chunk for PQ), or as a JPEG, as the extension says. A PNG
/// of a frame with a transparent background has straight alpha.
///
/// # Errors
/// A device that fails, scRGB, a file that can't be written.
pub fn write_picture(path: &Path, images: &ChannelImages, encoding: Encoding) -> Result<(), PictureError> {
    let format = encoding.check_file(path)?;
    let [width, height] = images.output_size();
    let image = images.current(encoding.channel());
    if encoding.is_hdr() {
        let codes = image.read_f32()?;
        let to_16_bits = |v: &f32| (v.clamp(0.0, 1.0) * 65535.0).round() as u16;
        let rgb: Vec<u16> = codes.chunks_exact(4).flat_map(|c| &c[..3]).map(to_16_bits).collect();
        return Ok(write_png_pq(path, width, height, &rgb)?);
    }
    let rgba = image.read()?;
    if format == OutputFormat::Png && has_alpha(images) {
        return Ok(write_png(path, width, height, PixelLayout::Rgba, &rgba)?);
    }
    let rgb: Vec<u8> = rgba.chunks_exact(4).flat_map(|c| [c[0], c[1], c[2]]).collect();
    if format == OutputFormat::Jpeg {
        return Ok(write_jpeg(path, width, height, &rgb)?);
    }
    Ok(write_png(path, width, height, PixelLayout::Rgb, &rgb)?)
}

/// Whether the frame has a transparent background.
fn has_alpha(images: &ChannelImages) -> bool {
    images.ids().any(|id| id == MATTE)
}

/// The picture as the main layer of an EXR: linear display values, for scRGB with 1 = 80 cd/m2; premultiplied where the background is
/// transparent.
///
/// # Errors
/// A device that fails, a size out of range.
pub fn picture_layers(images: &ChannelImages, encoding: Encoding) -> Result<LayeredImage, PictureError> {
    let [width, height] = images.output_size();
    let mut values = images.current(encoding.channel()).read_f32()?;
    if encoding == Encoding::Srgb {
        // Alpha is linear.
        values.chunks_exact_mut(4).flat_map(|c| &mut c[..3]).for_each(|v| *v = srgb_decode(*v));
    }
    let mut names = vec!["R", "G", "B"];
    if has_alpha(images) {
        names.push("A");
        values.chunks_exact_mut(4).for_each(|c| (0..3).for_each(|i| c[i] *= c[3]));
    }
    let mut file = LayeredImage::new(width, height)?;
    file.layers.push(Layer::from_interleaved("", &names, 4, &values));
    file.metadata.insert(pt_image::image_file::IMAGE_STATE_KEY.into(), "display".into());
    Ok(file)
}
