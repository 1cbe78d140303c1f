//! Any supported image file as linear RGB.

use std::io::Cursor;
use std::path::Path;

use image::{DynamicImage, ImageFormat, ImageReader, Limits};

use super::{
    IMAGE_STATE_KEY, ImageFileError, Layer, LayeredImage, MAX_IMAGE_SIDE, check_size, extension, srgb_decode,
};

/// The meaning of the linear values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageState {
    /// Radiance (or anything proportional to it) before exposure and tone mapping: EXR and Radiance HDR files.
    SceneReferred,
    /// Light of a display, 0 to 1, after tone mapping: PNG and JPEG, decoded from sRGB, and EXR files whose
    /// metadata says so ([`IMAGE_STATE_KEY`]).
    DisplayReferred,
}

/// Linear RGB, Rec. 709 primaries.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearImage {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Rows from the top, width x height pixels.
    pub pixels: Vec<[f32; 3]>,
    /// The meaning of the values.
    pub state: ImageState,
}

impl LinearImage {
    /// Reads PNG, JPEG (both taken as sRGB; alpha is dropped), Radiance HDR or EXR (the R, G, B channels of the unnamed
    /// layer, or else of the only layer that has them).
    ///
    /// # Errors
    /// [`ImageFileError`]: not there, unknown extension, damaged, or larger than [`MAX_IMAGE_SIDE`].
    pub fn read(path: &Path) -> Result<Self, ImageFileError> {
        match extension(path).as_str() {
            "exr" => {
                Self::from_layers(&LayeredImage::read_exr(path)?).map_err(|reason| decode_error(path, reason))
            }
            "png" => read_with(path, ImageFormat::Png, ImageState::DisplayReferred),
            "jpg" | "jpeg" => read_with(path, ImageFormat::Jpeg, ImageState::DisplayReferred),
            "hdr" => read_with(path, ImageFormat::Hdr, ImageState::SceneReferred),
            other => Err(ImageFileError::Extension {
                path: path.into(),
                extension: other.into(),
                expected: "png, jpg, jpeg, hdr, exr",
            }),
        }
    }

    /// The rectangle of `width` x `height` pixels whose top left pixel is (`x`, `y`); `None` when it is empty or
    /// reaches outside.
    pub fn crop(&self, x: u32, y: u32, width: u32, height: u32) -> Option<Self> {
        let inside = |start: u32, length: u32, limit: u32| {
            length > 0 && start.checked_add(length).is_some_and(|end| end <= limit)
        };
        if !inside(x, width, self.width) || !inside(y, height, self.height) {
            return None;
        }
        let rows = self.pixels.chunks_exact(self.width as usize).skip(y as usize).take(height as usize);
        let pixels = rows.flat_map(|row| &row[x as usize..(x + width) as usize]).copied().collect();
        Some(Self { width, height, pixels, state: self.state })
    }

    fn from_layers(image: &LayeredImage) -> Result<Self, String> {
        let rgb = |layer: &Layer| -> Option<[Vec<f32>; 3]> {
            let plane = |name| image.channel(&layer.name, name).map(|samples| samples.to_f32());
            Some([plane("R")?, plane("G")?, plane("B")?])
        };
        let main = image.layer("").and_then(rgb);
        let mut others = image.layers.iter().filter_map(rgb);
        let [red, green, blue] = match (main, others.next(), others.next()) {
            (Some(main), ..) => main,
            (None, Some(only), None) => only,
            (None, first, _) => {
                let names: Vec<_> = image.layers.iter().map(|layer| format!("{:?}", layer.name)).collect();
                let count = if first.is_some() { "more than one layer" } else { "no layer" };
                return Err(format!("{count} has channels R, G, B (layers: {})", names.join(", ")));
            }
        };
        let pixels = red.into_iter().zip(green).zip(blue).map(|((r, g), b)| [r, g, b]).collect();
        let state = match image.metadata.get(IMAGE_STATE_KEY).map(String::as_str) {
            Some("display") => ImageState::DisplayReferred,
            _ => ImageState::SceneReferred,
        };
        Ok(Self { width: image.width, height: image.height, pixels, state })
    }
}

fn decode_error(path: &Path, reason: impl ToString) -> ImageFileError {
    ImageFileError::Decode { path: path.into(), reason: reason.to_string() }
}

fn read_with(path: &Path, format: ImageFormat, state: ImageState) -> Result<LinearImage, ImageFileError> {
    let bytes = crate::atomic_file::read(path)?;
    let mut reader = ImageReader::with_format(Cursor::new(&bytes), format);
    let mut limits = Limits::no_limits();
    limits.max_image_width = Some(MAX_IMAGE_SIDE);
    limits.max_image_height = Some(MAX_IMAGE_SIDE);
    reader.limits(limits);
    let image = reader.decode().map_err(|error| decode_error(path, error))?;
    check_size(image.width().into(), image.height().into())?;
    let (width, height) = (image.width(), image.height());
    let decode = match state {
        ImageState::DisplayReferred => srgb_decode,
        ImageState::SceneReferred => |value: f32| value,
    };
    let pixels = to_rgb32f(image).pixels().map(|pixel| pixel.0.map(decode)).collect();
    Ok(LinearImage { width, height, pixels, state })
}

fn to_rgb32f(image: DynamicImage) -> image::Rgb32FImage {
    match image {
        DynamicImage::ImageRgb32F(image) => image,
        other => other.into_rgb32f(),
    }
}
