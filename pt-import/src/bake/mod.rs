//! Textures compressed ahead of time: BC7 for colour and data, BC5 for normal maps, each a DDS file with its mips.
//!
//! A file is named by a hash of the image file, of what the texture is used for and of the encoder, so that a folder serves
//! any number of scenes, a changed image is baked anew, and an unchanged one is skipped. Its content carries a
//! checksum.

mod encode;

use std::path::Path;

use crate::baked_folder::{BakedFile, BakedFolder, Quality};
use crate::dds::DdsTexture;
use crate::options::LoadOptions;
use crate::scene_images;
use pt_scene::Texels;
use pt_scene::{SceneError, Texture, TextureUsage};

/// What became of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Written for the first time.
    Baked,
    /// There already, with the quality asked for.
    Unchanged,
    /// Written anew because the file that was there is damaged or was baked with another quality.
    Rebuilt,
    /// The image is compressed as it is; nothing to bake.
    AlreadyCompressed,
}

/// A texture that went through [`bake`].
#[derive(Clone, Debug, PartialEq)]
pub struct BakedTexture {
    /// Name from the scene.
    pub name: String,
    /// The use of the texture.
    pub usage: TextureUsage,
    /// Width and height.
    pub extent: [u32; 2],
    /// What became of it.
    pub outcome: Outcome,
    /// Name of the DDS file in the folder.
    pub file: String,
    /// Bytes with mips on a device without compression.
    pub bytes_before: u64,
    /// Bytes with mips compressed.
    pub bytes_after: u64,
    /// Peak signal-to-noise ratio of the finest level in dB over the channels that count, of the encoded (not linear)
    /// values with 8 bits; `None` unless it was encoded now.
    pub psnr: Option<f64>,
}

/// Compresses the textures of a glTF scene into `folder`, which is created when it is not there. Of the options those count that
/// limit images and say where they may lie. `done` is called after each texture with their number and the total.
///
/// # Errors
/// A scene that can't be read, an image that can't be decoded, a folder that can't be written. Files that are complete stay.
pub fn bake(
    scene: &Path,
    folder: &Path,
    quality: Quality,
    options: &LoadOptions,
    mut done: impl FnMut(usize, usize),
) -> Result<Vec<BakedTexture>, SceneError> {
    let folder = BakedFolder::create(folder)?;
    scene_images::with_images(scene, options, |images| {
        let mut report = Vec::with_capacity(images.len());
        for index in 0..images.len() {
            report.push(one(images, index, &folder, quality, options.max_texture_pixels)?);
            done(index + 1, images.len());
        }
        Ok(report)
    })
}

fn one(
    images: &scene_images::Images<'_>,
    index: usize,
    folder: &BakedFolder,
    quality: Quality,
    max_texture_pixels: u64,
) -> Result<BakedTexture, SceneError> {
    let (label, bytes) = images.file(index)?;
    let usage = images.usage(index);
    let invalid = |what| images.invalid(index, &label, what);
    let extent = scene_images::image_size(&bytes, max_texture_pixels).map_err(invalid)?;
    let known = folder.lookup(&bytes, usage);
    let mut baked = BakedTexture {
        name: label.clone(),
        usage,
        extent,
        outcome: Outcome::Unchanged,
        file: BakedFolder::file_name(&bytes, usage),
        bytes_before: 0,
        bytes_after: 0,
        psnr: None,
    };
    if let Ok(Some(file)) = &known
        && file.quality == quality
        && [file.dds.width, file.dds.height] == extent
    {
        baked.count(file);
        return Ok(baked);
    }
    baked.outcome = if matches!(known, Ok(None)) { Outcome::Baked } else { Outcome::Rebuilt };
    let texture = scene_images::decode_texture(&label, &bytes, usage, max_texture_pixels).map_err(invalid)?;
    if let Texels::Blocks { format, levels } = &texture.texels {
        let levels = levels.clone();
        baked.outcome = Outcome::AlreadyCompressed;
        let dds = DdsTexture { width: extent[0], height: extent[1], format: *format, srgb: false, levels };
        baked.count(&BakedFile { dds, quality, is_16_bit: false });
        return Ok(baked);
    }
    let (dds, psnr) = encode::encode(&texture, quality);
    let file = BakedFile { dds, quality, is_16_bit: texture.is_16_bit() };
    folder.store(&baked.file, &file)?;
    baked.count(&file);
    baked.psnr = Some(psnr);
    Ok(baked)
}

impl BakedTexture {
    fn count(&mut self, file: &BakedFile) {
        self.bytes_after = file.dds.levels.iter().map(|level| level.len() as u64).sum();
        let like = if file.is_16_bit {
            Texture::rgba16("", self.extent, self.usage, Vec::new())
        } else {
            Texture::rgba8("", self.extent, self.usage, Vec::new())
        };
        self.bytes_before = like.uncompressed_bytes();
    }
}
