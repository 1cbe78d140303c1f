//! PNG: 8 bits tagged as sRGB, 16 bits tagged as PQ.

use std::path::Path;

use super::{ImageFileError, check_size};
use crate::atomic_file::write_atomic;

/// How the bytes of a pixel follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelLayout {
    /// Three bytes.
    Rgb,
    /// Four bytes, alpha not premultiplied and linear.
    Rgba,
}

impl PixelLayout {
    /// Bytes per pixel.
    pub fn bytes(self) -> usize {
        match self {
            Self::Rgb => 3,
            Self::Rgba => 4,
        }
    }
}

/// Writes sRGB-encoded 8-bit pixels, rows from the top, as a PNG with an sRGB chunk (perceptual intent), atomically.
/// The same pixels give the same bytes.
///
/// # Errors
/// [`ImageFileError`]: size out of range, a number of bytes that does not fit it, or the file system.
pub fn write_png(
    path: &Path,
    width: u32,
    height: u32,
    layout: PixelLayout,
    pixels: &[u8],
) -> Result<(), ImageFileError> {
    check_size(width.into(), height.into())?;
    let bytes = encode(width, height, layout, pixels)
        .map_err(|error| ImageFileError::Encode { path: path.into(), reason: error.to_string() })?;
    Ok(write_atomic(path, &bytes)?)
}

/// Writes PQ codes (SMPTE ST 2084) of Rec. 2020 primaries, 16 bits, R, G, B, rows from the top, as a PNG with a cICP chunk
/// that says so (ITU-T H.273: primaries 9, transfer 16, full range), atomically.
///
/// # Errors
/// As [`write_png`].
pub fn write_png_pq(path: &Path, width: u32, height: u32, codes: &[u16]) -> Result<(), ImageFileError> {
    check_size(width.into(), height.into())?;
    let mut bytes = Vec::new();
    let mut write = || {
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Sixteen);
        let mut writer = encoder.write_header()?;
        writer.write_chunk(png::chunk::ChunkType(*b"cICP"), &[9, 16, 0, 1])?;
        let big_endian: Vec<u8> = codes.iter().flat_map(|code| code.to_be_bytes()).collect();
        writer.write_image_data(&big_endian)?;
        writer.finish()
    };
    write().map_err(|error: png::EncodingError| ImageFileError::Encode {
        path: path.into(),
        reason: error.to_string(),
    })?;
    Ok(write_atomic(path, &bytes)?)
}

fn encode(
    width: u32,
    height: u32,
    layout: PixelLayout,
    pixels: &[u8],
) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(match layout {
        PixelLayout::Rgb => png::ColorType::Rgb,
        PixelLayout::Rgba => png::ColorType::Rgba,
    });
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    // The encoder reports a wrong number of bytes itself, with both numbers.
    writer.write_image_data(pixels)?;
    writer.finish()?;
    Ok(bytes)
}
