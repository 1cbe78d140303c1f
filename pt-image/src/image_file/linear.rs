//! Any supported image file as linear RGB.

use std::io::Cursor;
use std::path::Path;

use glam::{DMat3, Vec3};
use image::{ImageFormat, ImageReader, Limits};

use super::hdr_file::{self, Picture};
use super::{
    IMAGE_STATE_KEY, ImageFileError, Layer, LayeredImage, MAX_IMAGE_SIDE, check_size, exr_read, extension,
    srgb_decode,
};

/// Extensions of the files that are read, as messages list them.
const EXTENSIONS: &str = "png, jpg, jpeg, hdr, exr";

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

/// Everything in the file of a picture, decoded once.
#[derive(Clone, Debug)]
pub struct PictureFile {
    /// The picture.
    pub picture: LinearImage,
    /// What the reader did to the values of the picture, one sentence each.
    pub notices: Vec<String>,
    /// What [`LayeredImage::read_exr`] reads; `None` for a file that is no EXR.
    pub layers: Option<LayeredImage>,
}

impl PictureFile {
    /// Reads an image file, as [`LinearImage::decode`] does.
    ///
    /// # Errors
    /// As [`LinearImage::read`].
    pub fn read(path: &Path) -> Result<Self, ImageFileError> {
        let extension = extension(path);
        if !EXTENSIONS.split(", ").any(|known| known == extension) {
            return Err(ImageFileError::Extension { path: path.into(), extension, expected: EXTENSIONS });
        }
        Self::decode(&crate::atomic_file::read(path)?)
            .map_err(|reason| ImageFileError::Decode { path: path.into(), reason })
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        let flat = |picture, notices| Ok(Self { picture, notices, layers: None });
        match bytes {
            [] => Err("the file is empty".into()),
            [0x76, 0x2f, 0x31, 0x01, ..] => decode_exr(bytes),
            [0x89, b'P', b'N', b'G', ..] => flat(decode_srgb(bytes, ImageFormat::Png)?, Vec::new()),
            [0xff, 0xd8, ..] => flat(decode_srgb(bytes, ImageFormat::Jpeg)?, Vec::new()),
            _ if hdr_file::is_hdr(bytes) => {
                let Picture { width, height, pixels, notices } = hdr_file::decode(bytes)?;
                flat(LinearImage { width, height, pixels, state: ImageState::SceneReferred }, notices)
            }
            _ => Err("is none of PNG, JPEG, Radiance HDR and OpenEXR".into()),
        }
    }
}

impl LinearImage {
    /// Reads an image file, as [`LinearImage::decode`] does.
    ///
    /// # Errors
    /// [`ImageFileError`]: not there, unknown extension, damaged, or larger than [`MAX_IMAGE_SIDE`].
    pub fn read(path: &Path) -> Result<Self, ImageFileError> {
        Ok(PictureFile::read(path)?.picture)
    }

    /// Reads PNG, JPEG (both taken as sRGB; alpha is dropped), Radiance HDR or EXR, told apart by content, and what the reader did
    /// to the values, one sentence each. Memory is bounded by a multiple of the length of `bytes`.
    ///
    /// * EXR: the display window of the main layer; a layer of luminance alone is grey. Values of other primaries
    ///   than Rec. 709 (`chromaticities`) are converted, white to white. With `whiteLuminance` values become cd/m2.
    /// * Radiance HDR: values are divided by EXPOSURE and COLORCORR; PRIMARIES and CIE XYZ are converted.
    ///
    /// # Errors
    /// What is wrong with the content, or what of it is not supported.
    pub fn decode(bytes: &[u8]) -> Result<(Self, Vec<String>), String> {
        PictureFile::decode(bytes).map(|file| (file.picture, file.notices))
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
}

/// The last parts of the names under which programs store the finished picture beside other layers, the likeliest first:
/// Blender, Nuke, others.
const MAIN_LAYERS: [&str; 4] = ["combined", "rgba", "rgb", "beauty"];

/// Of the layers that `has_picture` finds a picture in: the unnamed one, the only one, or the one that is called as programs call the
/// finished picture (Blender's `Composite` goes before its `ViewLayer`). `Ok(None)` when there is none.
///
/// # Errors
/// The names of the layers, when several are as good.
fn main_layer(
    image: &LayeredImage,
    has_picture: impl Fn(&Layer) -> bool,
) -> Result<Option<&Layer>, Vec<&str>> {
    let found: Vec<&Layer> = image.layers.iter().filter(|layer| has_picture(layer)).collect();
    let unnamed = found.iter().find(|layer| layer.name.is_empty());
    if let (Some(layer), _) | (None, [layer]) = (unnamed, found.as_slice()) {
        return Ok(Some(layer));
    }
    for main in MAIN_LAYERS {
        let last = |name: &str| name.rsplit('.').next().is_some_and(|last| last.eq_ignore_ascii_case(main));
        let mut named = found.iter().filter(|layer| last(&layer.name));
        match (named.next(), named.next()) {
            (Some(layer), None) => return Ok(Some(layer)),
            (Some(_), Some(_)) => {
                let composite = found.iter().find(|layer| layer.name == "Composite.Combined");
                return composite.map(|layer| Some(*layer)).ok_or_else(|| names(&found));
            }
            _ => {}
        }
    }
    if found.is_empty() { Ok(None) } else { Err(names(&found)) }
}

fn names<'a>(layers: &[&'a Layer]) -> Vec<&'a str> {
    layers.iter().map(|layer| layer.name.as_str()).collect()
}

/// The three planes of the main layer; a picture of luminance alone has the same one three times.
fn main_planes(image: &LayeredImage) -> Result<[Vec<f32>; 3], String> {
    let has = |layer: &Layer, names: &[&str]| names.iter().all(|name| layer.channel(name).is_some());
    let several = |names: Vec<&str>| format!("more than one layer has a picture ({})", names.join(", "));
    if let Some(layer) = main_layer(image, |layer| has(layer, &["R", "G", "B"])).map_err(several)? {
        let plane = |name| layer.channel(name).map_or(Vec::new(), |channel| channel.samples.to_f32());
        return Ok(["R", "G", "B"].map(plane));
    }
    // X, Y and Z together are positions or directions.
    let grey = |layer: &Layer| has(layer, &["Y"]) && !has(layer, &["X"]) && !has(layer, &["Z"]);
    let luminance = main_layer(image, grey).map_err(several)?;
    let Some(layer) = luminance else {
        let channels = image.layers.iter().flat_map(|layer| {
            layer.channels.iter().map(|channel| match layer.name.as_str() {
                "" => channel.name.clone(),
                name => format!("{name}.{}", channel.name),
            })
        });
        let channels: Vec<_> = channels.collect();
        return Err(format!("no layer has channels R, G, B or Y (channels: {})", channels.join(", ")));
    };
    if has(layer, &["RY"]) || has(layer, &["BY"]) {
        return Err(
            "it is stored as luminance and chroma (channels Y, RY, BY), which is not supported".into()
        );
    }
    let plane = layer.channel("Y").map_or(Vec::new(), |channel| channel.samples.to_f32());
    Ok([plane.clone(), plane.clone(), plane])
}

fn decode_exr(bytes: &[u8]) -> Result<PictureFile, String> {
    let decoded = exr_read::decode(bytes)?;
    let image = &decoded.image;
    let [red, green, blue] = main_planes(image)?;
    let mut pixels: Vec<_> = red.into_iter().zip(green).zip(blue).map(|((r, g), b)| [r, g, b]).collect();
    let mut notices: Vec<String> = decoded.windows.into_iter().collect();
    let to_rec_709 = match decoded.chromaticities {
        Some(chromaticities) => chromaticities.to_rec_709().map_err(|what| format!("its header: {what}"))?,
        None => None,
    };
    if to_rec_709.is_some() {
        notices.push("converted from the chromaticities in its header to Rec. 709 primaries".into());
    }
    let luminance = decoded.white_luminance.unwrap_or(1.0);
    if !(luminance.is_finite() && luminance > 0.0) {
        return Err(format!("the attribute whiteLuminance {luminance} is not above 0 and finite"));
    }
    if luminance != 1.0 {
        notices.push(format!("values are scaled to cd/m2 by the whiteLuminance {luminance} in its header"));
    }
    if to_rec_709.is_some() || luminance != 1.0 {
        let matrix = to_rec_709.unwrap_or(DMat3::IDENTITY) * f64::from(luminance);
        // An infinite channel would make the others undefined; such pixels stay as they are.
        for pixel in pixels.iter_mut().filter(|pixel| pixel.iter().all(|value| value.is_finite())) {
            *pixel = (matrix * Vec3::from_array(*pixel).as_dvec3()).as_vec3().to_array();
        }
    }
    let state = match image.metadata.get(IMAGE_STATE_KEY).map(String::as_str) {
        Some("display") => ImageState::DisplayReferred,
        _ => ImageState::SceneReferred,
    };
    let picture = LinearImage { width: image.width, height: image.height, pixels, state };
    Ok(PictureFile { picture, notices, layers: Some(decoded.image) })
}

fn decode_srgb(bytes: &[u8], format: ImageFormat) -> Result<LinearImage, String> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::no_limits();
    limits.max_image_width = Some(MAX_IMAGE_SIDE);
    limits.max_image_height = Some(MAX_IMAGE_SIDE);
    reader.limits(limits);
    let image = reader.decode().map_err(|error| error.to_string())?;
    let (width, height) = (image.width(), image.height());
    check_size(width.into(), height.into()).map_err(|error| error.to_string())?;
    let pixels = image.into_rgb32f().pixels().map(|pixel| pixel.0.map(srgb_decode)).collect();
    Ok(LinearImage { width, height, pixels, state: ImageState::DisplayReferred })
}
