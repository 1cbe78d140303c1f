//! JPEG: 8 bits, sRGB by convention of JFIF.

use std::path::Path;

use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;

use super::{ImageFileError, check_size};
use crate::atomic_file::write_atomic;

/// 1 to 100; at 95 errors are rarely seen.
const QUALITY: u8 = 95;

/// Writes sRGB-encoded 8-bit pixels R, G, B, rows from the top, as a JPEG of quality 95, atomically. The same pixels give the same bytes.
///
/// # Errors
/// [`ImageFileError`]: size out of range, a number of bytes that does not fit it, or the file system.
pub fn write_jpeg(path: &Path, width: u32, height: u32, pixels: &[u8]) -> Result<(), ImageFileError> {
    check_size(width.into(), height.into())?;
    let expected = 3 * width as usize * height as usize;
    let wrong = |reason: String| ImageFileError::Encode { path: path.into(), reason };
    if pixels.len() != expected {
        return Err(wrong(format!("{} bytes of pixels, {width}x{height} need {expected}", pixels.len())));
    }
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, QUALITY)
        .encode(pixels, width, height, ExtendedColorType::Rgb8)
        .map_err(|error| wrong(error.to_string()))?;
    Ok(write_atomic(path, &bytes)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image_file::{LinearImage, srgb_encode_8bit};

    #[test]
    fn pixels_come_back_nearly_as_they_were() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jpg");
        let smooth: Vec<u8> = (0..48u32)
            .flat_map(|y| (0..64u32).flat_map(move |x| [4 * x, 5 * y, 128].map(|c| c as u8)))
            .collect();
        write_jpeg(&path, 64, 48, &smooth).unwrap();
        let image = LinearImage::read(&path).unwrap();
        assert_eq!((image.width, image.height), (64, 48));
        let found = image.pixels.iter().flatten().map(|&c| srgb_encode_8bit(c));
        let worst = found.zip(&smooth).map(|(a, &b)| a.abs_diff(b)).max().unwrap();
        // Quantization at quality 95 and 4:2:0 chroma of a ramp.
        assert!(worst <= 12, "{worst}");
        write_jpeg(&path, 64, 48, &smooth[1..]).unwrap_err();
    }
}
