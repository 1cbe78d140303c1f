//! Mip chains into blocks: block_compression, a port of Intel's ISPC texture compressor to plain Rust.

use block_compression::encode::compress_rgba8;
use block_compression::{BC7Settings, CompressionVariant};
use rayon::prelude::*;

use crate::baked_folder::Quality;
use crate::dds::DdsTexture;
use pt_scene::{BlockFormat, MipLevel, Texture, TextureUsage};

/// Rows of blocks that are one piece of work.
const BAND: usize = 8;

/// Compresses a texture that is not compressed, with its mips; with the PSNR of its finest level.
pub(crate) fn encode(texture: &Texture, quality: Quality) -> (DdsTexture, f64) {
    let mips = texture.mips();
    let opaque = mips[0].texels.chunks_exact(4).all(|t| t[3] == 255);
    let (format, variant, channels) = match (texture.usage, opaque) {
        (TextureUsage::Normal, _) => (BlockFormat::Bc5, CompressionVariant::BC5, 2),
        (_, true) => (BlockFormat::Bc7, CompressionVariant::BC7(settings(quality, true)), 3),
        (_, false) => (BlockFormat::Bc7, CompressionVariant::BC7(settings(quality, false)), 4),
    };
    let levels: Vec<_> = mips.iter().map(|level| compress(variant, format, level)).collect();
    let (width, height) = (texture.width, texture.height);
    let decoded = format.decode([width, height], &levels[0]);
    let psnr = psnr(&mips[0].texels, &decoded, channels);
    (DdsTexture { width, height, format, srgb: texture.usage.is_srgb(), levels }, psnr)
}

fn settings(quality: Quality, opaque: bool) -> BC7Settings {
    match (quality, opaque) {
        (Quality::Fast, true) => BC7Settings::opaque_very_fast(),
        (Quality::Fast, false) => BC7Settings::alpha_very_fast(),
        (Quality::Best, true) => BC7Settings::opaque_basic(),
        (Quality::Best, false) => BC7Settings::alpha_basic(),
    }
}

fn compress(variant: CompressionVariant, format: BlockFormat, level: &MipLevel<'_>) -> Vec<u8> {
    let across = level.width.div_ceil(4) as usize;
    let mut out = vec![0; format.level_bytes([level.width, level.height])];
    out.par_chunks_mut(BAND * across * format.block_bytes()).enumerate().for_each(|(band, out)| {
        let rows = 4 * (out.len() / (across * format.block_bytes()));
        let padded = padded_rows(level, 4 * BAND * band, rows);
        let width = 4 * across as u32;
        compress_rgba8(variant, &padded, out, width, rows as u32, 4 * width);
    });
    out
}

/// `rows` rows from `first` on, the border repeated to whole blocks.
fn padded_rows(level: &MipLevel<'_>, first: usize, rows: usize) -> Vec<u8> {
    let (w, h) = (level.width as usize, level.height as usize);
    let mut out = Vec::with_capacity(w.div_ceil(4) * 16 * rows);
    for y in first..first + rows {
        let row = &level.texels[y.min(h - 1) * w * 4..][..w * 4];
        out.extend_from_slice(row);
        (w..w.div_ceil(4) * 4).for_each(|_| out.extend_from_slice(&row[w * 4 - 4..]));
    }
    out
}

/// In dB over the first `channels` of each RGBA texel.
fn psnr(a: &[u8], b: &[u8], channels: usize) -> f64 {
    let square = |(x, y): (&u8, &u8)| u64::from(x.abs_diff(*y)).pow(2);
    let sum: u64 = a
        .chunks_exact(4)
        .zip(b.chunks_exact(4))
        .map(|(a, b)| a[..channels].iter().zip(&b[..channels]).map(square).sum::<u64>())
        .sum();
    let mse = sum as f64 / (a.len() / 4 * channels) as f64;
    10.0 * (255.0 * 255.0 / mse).log10()
}
