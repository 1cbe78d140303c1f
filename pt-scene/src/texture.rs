use std::borrow::Cow;

use crate::mips::{MipLevel, decode_texel, decode_texel_16, mips, narrow_mips};
use crate::usage::TextureUsage;
pub use pt_core::texture::BlockFormat;

/// Longest side of a texture that is accepted, texels.
pub const MAX_TEXTURE_SIDE: u32 = 16384;

/// Addressing of texture coordinates outside 0..1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The texture tiles.
    #[default]
    Repeat,
    /// Every other tile is mirrored.
    MirroredRepeat,
    /// Clamped to the border texel.
    ClampToEdge,
}

/// How a texture is read between texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// The nearest texel.
    Nearest,
    /// Linear interpolation.
    #[default]
    Linear,
}

/// How a texture is read between mip levels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MipFilter {
    /// Only the finest level is read.
    Off,
    /// The nearest level.
    Nearest,
    /// Linear interpolation between levels.
    #[default]
    Linear,
}

/// Addressing and filtering of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sampler {
    /// Along the width.
    pub wrap_u: Wrap,
    /// Along the height.
    pub wrap_v: Wrap,
    /// When magnified.
    pub mag: Filter,
    /// When minified.
    pub min: Filter,
    /// Between mip levels.
    pub mip: MipFilter,
}

/// The content of a texture.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// The finest level, `width` x `height` x 4 bytes.
    Rgba8(Vec<u8>),
    /// The finest level with 16 bits per channel, `width` x `height` x 4 codes in the encoding that the usage asks for. Only for images
    /// that 8 bits do not hold: it takes twice the memory.
    Rgba16(Vec<u16>),
    /// Compressed mip levels from the finest on, each as long as [`BlockFormat::level_bytes`] says.
    Blocks {
        /// How they are compressed.
        format: BlockFormat,
        /// At least one.
        levels: Vec<Vec<u8>>,
    },
}

/// An image with its sampler. Row 0 is the top (v = 0).
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Name from the file, for messages.
    pub name: String,
    /// Texels in a row, >= 1.
    pub width: u32,
    /// Rows, >= 1.
    pub height: u32,
    /// What the texels mean.
    pub usage: TextureUsage,
    /// The texels.
    pub texels: Texels,
    /// Addressing and filtering.
    pub sampler: Sampler,
}

impl Texture {
    /// An uncompressed texture with the default sampler; `texels` are `width` x `height` x 4 bytes.
    pub fn rgba8(name: &str, [width, height]: [u32; 2], usage: TextureUsage, texels: Vec<u8>) -> Self {
        let (texels, sampler) = (Texels::Rgba8(texels), Sampler::default());
        Self { name: name.into(), width, height, usage, texels, sampler }
    }

    /// As [`Texture::rgba8`], with 16 bits per channel.
    pub fn rgba16(name: &str, extent: [u32; 2], usage: TextureUsage, texels: Vec<u16>) -> Self {
        Self { texels: Texels::Rgba16(texels), ..Self::rgba8(name, extent, usage, Vec::new()) }
    }

    /// The linear RGBA value of one texel of the finest level. A compressed texture decodes a whole block for it; to read many
    /// texels use [`Texture::decoded`] first.
    pub fn texel(&self, x: u32, y: u32) -> [f32; 4] {
        let index = y as usize * self.width as usize + x as usize;
        match &self.texels {
            Texels::Rgba8(texels) => decode_texel(self.usage, texels.as_chunks().0[index]),
            Texels::Rgba16(texels) => decode_texel_16(self.usage, texels.as_chunks().0[index]),
            Texels::Blocks { format, levels } => {
                let across = self.width.div_ceil(4) as usize;
                let at = ((y / 4) as usize * across + (x / 4) as usize) * format.block_bytes();
                let block = format.decode_block(&levels[0][at..at + format.block_bytes()]);
                decode_texel(self.usage, block[(4 * (y % 4) + x % 4) as usize])
            }
        }
    }

    /// The texture without compression; a compressed one is decoded (its finest level only).
    pub fn decoded(&self) -> Cow<'_, Self> {
        let Texels::Blocks { format, levels } = &self.texels else { return Cow::Borrowed(self) };
        let texels = Texels::Rgba8(format.decode([self.width, self.height], &levels[0]));
        Cow::Owned(Self { name: self.name.clone(), texels, ..*self })
    }

    /// Bytes of the texels as they are held.
    pub fn bytes(&self) -> usize {
        match &self.texels {
            Texels::Rgba8(texels) => texels.len(),
            Texels::Rgba16(texels) => size_of_val(&texels[..]),
            Texels::Blocks { levels, .. } => levels.iter().map(Vec::len).sum(),
        }
    }

    /// What the texture takes with its mips when it is not compressed: two channels per texel for normal maps, else four, of one byte or, with 16
    /// bits per channel, two.
    pub fn uncompressed_bytes(&self) -> u64 {
        let channels = if self.usage == TextureUsage::Normal { 2 } else { 4 };
        let texel = if self.is_16_bit() { 2 * channels } else { channels };
        let side = |side: u32, level: usize| u64::from((side >> level).max(1));
        (0..self.full_level_count()).map(|i| texel * side(self.width, i) * side(self.height, i)).sum()
    }

    /// Whether its texels have 16 bits per channel.
    pub fn is_16_bit(&self) -> bool {
        matches!(self.texels, Texels::Rgba16(_))
    }

    /// Number of levels of a whole mip chain, down to 1x1.
    pub fn full_level_count(&self) -> usize {
        self.width.max(self.height).max(1).ilog2() as usize + 1
    }

    pub(crate) fn check(&self) -> Result<(), String> {
        let fits = |bytes: usize, expected: usize| {
            if bytes == expected {
                Ok(())
            } else {
                Err(format!("{bytes} bytes for {}x{}", self.width, self.height))
            }
        };
        if self.width == 0 || self.height == 0 {
            return Err("it has no texels".into());
        }
        match &self.texels {
            Texels::Rgba8(_) => fits(self.bytes(), self.width as usize * self.height as usize * 4),
            Texels::Rgba16(_) => fits(self.bytes(), self.width as usize * self.height as usize * 8),
            Texels::Blocks { levels, .. } if levels.is_empty() || levels.len() > self.full_level_count() => {
                Err(format!("{} mip levels", levels.len()))
            }
            Texels::Blocks { format, levels } => levels.iter().enumerate().try_for_each(|(i, level)| {
                let extent = [self.width, self.height].map(|side| (side >> i).max(1));
                fits(level.len(), format.level_bytes(extent))
            }),
        }
    }

    /// The whole mip chain with 8 bits per channel and without compression, from the finest level to 1x1. Each level halves both sides, rounding
    /// down, by an exact area average of linear values: the mean is kept for sizes that are no power of two as well.
    /// Rounding to 8 bits happens once per level and does not add up. [`TextureUsage`] says what is averaged. A
    /// compressed texture gives the levels that it has.
    pub fn mips(&self) -> Vec<MipLevel<'_>> {
        match &self.texels {
            Texels::Rgba8(texels) => mips(self.usage, [self.width, self.height], texels),
            Texels::Rgba16(texels) => narrow_mips(self.usage, [self.width, self.height], texels),
            Texels::Blocks { format, levels } => {
                let levels = levels.iter().enumerate().map(|(i, level)| {
                    let [width, height] = [self.width, self.height].map(|side| (side >> i).max(1));
                    MipLevel { width, height, texels: format.decode([width, height], level).into() }
                });
                levels.collect()
            }
        }
    }
}
