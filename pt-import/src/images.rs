//! Image files into texels. The kind of file is told by its content; sizes are checked from the header before anything
//! is decoded.

use std::io::Cursor;

use image::{DynamicImage, ImageDecoder, ImageFormat};

use crate::dds::DdsTexture;
#[cfg(feature = "codecs")]
use crate::ktx2;
use pt_scene::Texels;
use pt_scene::one_line;
use pt_scene::{MAX_TEXTURE_SIDE, TextureUsage};
use pt_scene::{decode_texel, decode_texel_16, encode_normal, encode_normal_16};

const KTX2_MAGIC: &[u8] = &[0xab, b'K', b'T', b'X', b' ', b'2', b'0', 0xbb, 0x0d, 0x0a, 0x1a, 0x0a];

/// An image file whose header has been read.
pub(crate) struct Header<'a> {
    pub width: u32,
    pub height: u32,
    bytes: &'a [u8],
    kind: Kind<'a>,
}

enum Kind<'a> {
    Pixels(Box<dyn ImageDecoder + 'a>),
    Dds,
    Ktx2,
}

impl<'a> Header<'a> {
    /// Reads the size of a PNG, JPEG, WebP, DDS or KTX2 file.
    pub fn read(bytes: &'a [u8]) -> Result<Self, String> {
        let word = |at: usize| {
            let word = bytes.get(at..at + 4).ok_or("the header is cut short")?;
            Ok::<u32, String>(u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
        };
        let (kind, width, height) = if bytes.starts_with(b"DDS ") {
            (Kind::Dds, word(16)?, word(12)?)
        } else if bytes.starts_with(KTX2_MAGIC) {
            (Kind::Ktx2, word(20)?, word(24)?)
        } else {
            let decoder = decoder(bytes)?;
            let (width, height) = decoder.dimensions();
            (Kind::Pixels(decoder), width, height)
        };
        if !(1..=MAX_TEXTURE_SIDE).contains(&width) || !(1..=MAX_TEXTURE_SIDE).contains(&height) {
            return Err(format!("{width}x{height} is outside 1x1 .. {MAX_TEXTURE_SIDE}x{MAX_TEXTURE_SIDE}"));
        }
        Ok(Self { width, height, bytes, kind })
    }

    /// Texels of the finest level.
    pub fn texel_count(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Whether the image may be decoded.
    pub fn check(&self, max_texels: u64) -> Result<(), String> {
        if self.texel_count() > max_texels {
            let (w, h) = (self.width, self.height);
            return Err(format!(
                "{w}x{h} texels are more than the limit of {max_texels}; see --max-texture-pixels"
            ));
        }
        Ok(())
    }

    /// Decodes the image. A normal map's texels become unit vectors.
    pub fn decode(self, usage: TextureUsage) -> Result<Texels, String> {
        let mut texels = match self.kind {
            Kind::Dds => {
                let DdsTexture { format, levels, .. } = DdsTexture::from_bytes(self.bytes)?;
                return Ok(Texels::Blocks { format, levels });
            }
            #[cfg(feature = "codecs")]
            Kind::Ktx2 => ktx2::transcode(self.bytes, self.width, self.height)?,
            #[cfg(not(feature = "codecs"))]
            Kind::Ktx2 => return Err("is a KTX2 file; the feature codecs of pt-import decodes it".into()),
            Kind::Pixels(decoder) => {
                let image = DynamicImage::from_decoder(BoxedDecoder(decoder))
                    .map_err(|e| one_line(&e.to_string()))?;
                if needs_16_bits(&image) {
                    let mut texels = image.into_rgba16().into_raw();
                    if usage == TextureUsage::Normal {
                        texels.as_chunks_mut().0.iter_mut().for_each(normalize_16);
                    }
                    return Ok(Texels::Rgba16(texels));
                }
                image.into_rgba8().into_raw()
            }
        };
        if usage == TextureUsage::Normal {
            texels.as_chunks_mut().0.iter_mut().for_each(normalize);
        }
        Ok(Texels::Rgba8(texels))
    }
}

/// `DynamicImage::from_decoder` wants a sized decoder.
struct BoxedDecoder<'a>(Box<dyn ImageDecoder + 'a>);

impl ImageDecoder for BoxedDecoder<'_> {
    fn dimensions(&self) -> (u32, u32) {
        self.0.dimensions()
    }
    fn color_type(&self) -> image::ColorType {
        self.0.color_type()
    }
    fn read_image(self, buf: &mut [u8]) -> image::ImageResult<()> {
        self.0.read_image_boxed(buf)
    }
    fn read_image_boxed(self: Box<Self>, buf: &mut [u8]) -> image::ImageResult<()> {
        self.0.read_image_boxed(buf)
    }
}

fn decoder<'a>(bytes: &'a [u8]) -> Result<Box<dyn ImageDecoder + 'a>, String> {
    let unknown = "is none of PNG, JPEG, WebP, DDS and KTX2";
    match image::guess_format(bytes).map_err(|_| unknown)? {
        ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP => {}
        other => return Err(format!("{other:?} images are not supported; it {unknown}")),
    }
    let mut reader = image::ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|e| one_line(&e.to_string()))?;
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MAX_TEXTURE_SIDE);
    limits.max_image_height = Some(MAX_TEXTURE_SIDE);
    // The budget of the scene's texels is checked by the caller, from the header.
    limits.max_alloc = Some(4 << 30);
    reader.limits(limits);
    Ok(Box::new(reader.into_decoder().map_err(|e| one_line(&e.to_string()))?))
}

/// Whether an image has 16 bits per channel that 8 bits do not hold. An 8-bit image in a 16-bit file has every byte twice.
fn needs_16_bits(image: &DynamicImage) -> bool {
    let samples = match image {
        DynamicImage::ImageLuma16(pixels) => pixels.as_raw(),
        DynamicImage::ImageLumaA16(pixels) => pixels.as_raw(),
        DynamicImage::ImageRgb16(pixels) => pixels.as_raw(),
        DynamicImage::ImageRgba16(pixels) => pixels.as_raw(),
        _ => return false,
    };
    samples.iter().any(|&sample| sample >> 8 != sample & 0xff)
}

/// Maps made by hand or by a lossy codec are off by more than rounding; those that are not stay as they are.
fn normalize(texel: &mut [u8; 4]) {
    // In units of 1/255, which are whole numbers: most texels are well and cost no more than this.
    let square: i32 = texel[..3].iter().map(|&t| (2 * i32::from(t) - 255).pow(2)).sum();
    if (square - 255 * 255).abs() > 255 * 255 / 50 {
        let [x, y, z, _] = decode_texel(TextureUsage::Normal, *texel).map(|t| 2.0 * t - 1.0);
        *texel = encode_normal([x, y, z]);
    }
}

/// As [`normalize`], with 16 bits per channel.
fn normalize_16(texel: &mut [u16; 4]) {
    let [x, y, z, _] = decode_texel_16(TextureUsage::Normal, *texel).map(|t| 2.0 * t - 1.0);
    if (x * x + y * y + z * z - 1.0).abs() > 1.0 / 50.0 {
        *texel = encode_normal_16([x, y, z]);
    }
}
