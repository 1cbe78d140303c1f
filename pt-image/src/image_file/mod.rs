//! Images on disk: multi-layer EXR, 8-bit sRGB PNG and JPEG, and a reader of all supported kinds into linear RGB.
//!
//! Row 0 is the top. All writes go through [`crate::atomic_file`], and the same content gives the same bytes.

mod chromaticities;
mod exr_file;
mod exr_read;
mod hdr_file;
mod jpeg_file;
mod linear;
mod png_file;
mod srgb;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use half::f16;

pub use exr_read::is_cube_map;
pub use jpeg_file::write_jpeg;
pub use linear::{ImageState, LinearImage, PictureFile};
pub use png_file::{PixelLayout, write_png, write_png_pq};
pub use srgb::{srgb_decode, srgb_encode, srgb_encode_8bit};

use crate::atomic_file::{FileError, check_writable};

/// The largest width and height, in pixels, of any image that is rendered, written or read.
/// Vulkan 1.3 devices in use offer 2D images up to 16384 on a side; a larger request is a slip of the keyboard.
pub const MAX_IMAGE_SIDE: u32 = 16384;

/// Metadata key that tells scene-linear radiance (value `scene`, also meant when the key is absent) from
/// tone-mapped linear values for a display (value `display`, nominal range 0 to 1).
pub const IMAGE_STATE_KEY: &str = "imageState";

/// Why an image could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum ImageFileError {
    /// The file system refused.
    #[error(transparent)]
    File(#[from] FileError),
    /// Width or height outside 1 to [`MAX_IMAGE_SIDE`].
    #[error("image size {width}x{height} is out of range, each side must be 1 to {MAX_IMAGE_SIDE} pixels")]
    Size {
        /// Width asked for, pixels.
        width: u64,
        /// Height asked for, pixels.
        height: u64,
    },
    /// The extension does not name a kind of image that is supported here.
    #[error("{}: {}, use one of: {expected}", path.display(), extension_problem(path, extension))]
    Extension {
        /// The file.
        path: PathBuf,
        /// What follows the last dot of its name, empty without one.
        extension: String,
        /// The supported extensions.
        expected: &'static str,
    },
    /// The content is damaged or of a kind that is not supported.
    #[error("cannot read {}: {reason}", path.display())]
    Decode {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The image in memory breaks a rule of the file format.
    #[error("cannot write {}: {reason}", path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// Which rule.
        reason: String,
    },
}

/// Checks a size against 1 to [`MAX_IMAGE_SIDE`].
///
/// # Errors
/// [`ImageFileError::Size`].
pub fn check_size(width: u64, height: u64) -> Result<(), ImageFileError> {
    let allowed = 1..=u64::from(MAX_IMAGE_SIDE);
    if allowed.contains(&width) && allowed.contains(&height) {
        Ok(())
    } else {
        Err(ImageFileError::Size { width, height })
    }
}

/// Checks that `bytes` bytes can hold an image if each stands for `most` samples at most: a short file with a large header is no
/// reason to set memory aside.
fn check_room([width, height]: [usize; 2], channels: usize, bytes: u64, most: u64) -> Result<(), String> {
    let samples = (width as u64).saturating_mul(height as u64).saturating_mul(channels as u64);
    if samples > bytes.saturating_mul(most) {
        return Err(format!("{width}x{height} pixels cannot be in {bytes} bytes; the file is cut short"));
    }
    Ok(())
}

/// Width and height in pixels, each 1 to [`MAX_IMAGE_SIDE`]; parsed from `WIDTHxHEIGHT`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageSize {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl From<ImageSize> for [u32; 2] {
    fn from(size: ImageSize) -> Self {
        [size.width, size.height]
    }
}

impl FromStr for ImageSize {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let side = |text: &str| text.parse::<u64>().ok();
        let (width, height) = text
            .split_once('x')
            .and_then(|(width, height)| Some((side(width)?, side(height)?)))
            .ok_or("expected WIDTHxHEIGHT, for example 1280x720")?;
        check_size(width, height).map_err(|error| error.to_string())?;
        Ok(Self { width: width as u32, height: height as u32 })
    }
}

/// The kinds of image file that are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputFormat {
    /// 8 bits, sRGB.
    Png,
    /// 8 bits, sRGB, with loss.
    Jpeg,
    /// Linear floating point, any number of layers.
    Exr,
}

impl OutputFormat {
    /// The kind that the extension of `path` names, in either case.
    ///
    /// # Errors
    /// [`ImageFileError::Extension`].
    pub fn of(path: &Path) -> Result<Self, ImageFileError> {
        match extension(path).as_str() {
            "png" => Ok(Self::Png),
            "jpg" | "jpeg" => Ok(Self::Jpeg),
            "exr" => Ok(Self::Exr),
            other => Err(ImageFileError::Extension {
                path: path.into(),
                extension: other.into(),
                expected: "png, jpg, exr",
            }),
        }
    }
}

/// Checks before rendering that an image can be written to `path`: known extension, folder there and writable,
/// not a directory. Returns the format to write.
///
/// # Errors
/// [`ImageFileError`] as the write itself would report it.
pub fn check_output(path: &Path) -> Result<OutputFormat, ImageFileError> {
    let format = OutputFormat::of(path)?;
    check_writable(path)?;
    Ok(format)
}

/// What is wrong with the extension of an image.
fn extension_problem(path: &Path, extension: &str) -> String {
    match extension {
        "" if path.is_dir() => "is a folder; give the name of an image".into(),
        "" => "the name has no extension that says the kind of image".into(),
        _ => format!("unknown image extension \"{extension}\""),
    }
}

/// Lower-case extension, empty without one.
fn extension(path: &Path) -> String {
    path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// The samples of one channel, row by row from the top, width x height of them.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// 16-bit floating point.
    F16(Vec<f16>),
    /// 32-bit floating point.
    F32(Vec<f32>),
    /// 32-bit unsigned integers (identifiers, packed fields).
    U32(Vec<u32>),
}

impl Samples {
    /// Number of samples.
    pub fn len(&self) -> usize {
        match self {
            Self::F16(samples) => samples.len(),
            Self::F32(samples) => samples.len(),
            Self::U32(samples) => samples.len(),
        }
    }

    /// True without samples.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The samples as f32; integers above 2^24 are rounded.
    pub fn to_f32(&self) -> Vec<f32> {
        match self {
            Self::F16(samples) => samples.iter().map(|sample| sample.to_f32()).collect(),
            Self::F32(samples) => samples.clone(),
            Self::U32(samples) => samples.iter().map(|&sample| sample as f32).collect(),
        }
    }
}

/// One named plane of samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name within the layer (`R`, `X`, ...), without a dot.
    pub name: String,
    /// The values.
    pub samples: Samples,
}

/// Channels that belong together. In the file its channels are called `layer.channel`, those of the unnamed
/// layer just `channel`, so that any viewer shows the unnamed layer's R, G, B.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Name, empty for the main layer; may contain dots.
    pub name: String,
    /// The channels.
    pub channels: Vec<Channel>,
}

impl Layer {
    /// The channel of this name.
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// A layer of f32 channels from interleaved pixels of `stride` values each, of which the first
    /// `channels.len()` are taken (RGBA read back from a GPU image as a layer of X, Y, Z: stride 4, 3 names).
    ///
    /// # Panics
    /// When `stride` is smaller than the number of channels.
    pub fn from_interleaved(name: &str, channels: &[&str], stride: usize, values: &[f32]) -> Self {
        assert!(stride >= channels.len(), "{} channels do not fit a stride of {stride}", channels.len());
        let plane = |index: usize| values.chunks_exact(stride).map(|pixel| pixel[index]).collect();
        let channels = channels
            .iter()
            .enumerate()
            .map(|(index, &name)| Channel { name: name.into(), samples: Samples::F32(plane(index)) })
            .collect();
        Self { name: name.into(), channels }
    }
}

/// An image of any number of layers and channels, all of one size, with text attributes.
#[derive(Clone, Debug, PartialEq)]
pub struct LayeredImage {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The layers. Files keep channels sorted by full name, so reading returns them in that order.
    pub layers: Vec<Layer>,
    /// Text attributes (camera, seed, parameters, device, driver, version ...), stored in the header of an EXR
    /// as string attributes called `pt.KEY`; the prefix keeps them clear of the names that OpenEXR reserves.
    pub metadata: BTreeMap<String, String>,
}

impl LayeredImage {
    /// An image without layers.
    ///
    /// # Errors
    /// [`ImageFileError::Size`].
    pub fn new(width: u32, height: u32) -> Result<Self, ImageFileError> {
        check_size(width.into(), height.into())?;
        Ok(Self { width, height, layers: Vec::new(), metadata: BTreeMap::new() })
    }

    /// The layer of this name (empty: the main layer).
    pub fn layer(&self, name: &str) -> Option<&Layer> {
        self.layers.iter().find(|layer| layer.name == name)
    }

    /// The samples of `channel` in `layer`.
    pub fn channel(&self, layer: &str, channel: &str) -> Option<&Samples> {
        self.layer(layer)?.channel(channel).map(|channel| &channel.samples)
    }

    /// Writes a single-part scan-line EXR, ZIP compressed (lossless), atomically. The same content gives the same
    /// bytes: no time stamps, blocks in increasing order, header attributes sorted by name.
    ///
    /// # Errors
    /// [`ImageFileError`]; nothing is left under `path` unless the file is complete.
    pub fn write_exr(&self, path: &Path) -> Result<(), ImageFileError> {
        let bytes =
            exr_file::encode(self).map_err(|reason| ImageFileError::Encode { path: path.into(), reason })?;
        Ok(crate::atomic_file::write_atomic(path, &bytes)?)
    }

    /// The text attributes of an EXR alone, from its headers; empty for a file that is none.
    pub fn read_metadata(path: &Path) -> BTreeMap<String, String> {
        let bytes = if extension(path) == "exr" { crate::atomic_file::read(path).ok() } else { None };
        bytes.and_then(|bytes| exr_read::decode_metadata(&bytes)).unwrap_or_default()
    }

    /// Reads the display window of an EXR: all flat parts at their largest resolution. Pixels outside of the data window are 0.
    /// In a multi-part file the name of the part becomes the front of the layer name. Of the attributes only `pt.*` are kept, and
    /// the values stay as they are in the file; [`LinearImage`] converts them.
    ///
    /// # Errors
    /// [`ImageFileError`]: not there, damaged, deep data, subsampled channels, parts of different sizes, too large.
    pub fn read_exr(path: &Path) -> Result<Self, ImageFileError> {
        exr_read::decode(&crate::atomic_file::read(path)?)
            .map(|decoded| decoded.image)
            .map_err(|reason| ImageFileError::Decode { path: path.into(), reason })
    }
}

/// Images of different sizes as named parts of one EXR: its bytes, as [`LayeredImage::write_exr`] writes a single one. A single image
/// becomes a single-part file.
///
/// # Errors
/// What is wrong with the images.
pub fn encode_exr_parts(parts: &[(String, LayeredImage)]) -> Result<Vec<u8>, String> {
    match parts {
        [(_, image)] => exr_file::encode(image),
        _ => exr_file::encode_parts(parts),
    }
}

/// The parts of an EXR from its bytes, each with its name; a single-part file has one without a name.
///
/// # Errors
/// What is wrong with the file.
pub fn decode_exr_parts(bytes: &[u8]) -> Result<Vec<(String, LayeredImage)>, String> {
    exr_read::decode_parts(bytes)
}
