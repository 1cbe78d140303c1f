use std::borrow::Cow;
use std::sync::LazyLock;

pub use pt_core::texture::BlockFormat;

/// What happens to texture coordinates outside 0..1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The texture tiles.
    #[default]
    Repeat,
    /// Every other tile is mirrored.
    MirroredRepeat,
    /// The border texel goes on.
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

/// What a texture holds: decides how texels are decoded, how mips are made and how they are compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum TextureUsage {
    /// RGB is sRGB-encoded colour, alpha linear data of its own (or unused).
    Color,
    /// RGB is sRGB-encoded colour, alpha its linear coverage: mips weight colour by alpha.
    Cutout,
    /// Four linear values.
    Data,
    /// Tangent-space normal map: unit vectors, x and y as 2 t - 1 in R and G; z follows from them.
    Normal,
}

impl TextureUsage {
    /// Whether RGB is sRGB-encoded.
    pub fn is_srgb(self) -> bool {
        matches!(self, Self::Color | Self::Cutout)
    }
}

/// The content of a texture.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// The finest level, `width` x `height` x 4 bytes.
    Rgba8(Vec<u8>),
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

/// One level of a mip chain, in the encoding of its texture.
#[derive(Clone, Debug, PartialEq)]
pub struct MipLevel {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// RGBA8.
    pub texels: Vec<u8>,
}

/// Linear value 0..1 of an sRGB-encoded value 0..1 (IEC 61966-2-1).
pub fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// sRGB encoding 0..1 of a linear value 0..1 (IEC 61966-2-1).
pub fn srgb_from_linear(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

static SRGB_TABLE: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|i| linear_from_srgb(i as f32 / 255.0)));
static LINEAR_TABLE: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| i as f32 / 255.0));

/// Linear RGBA of four bytes.
pub(crate) fn decode_texel(usage: TextureUsage, t: [u8; 4]) -> [f32; 4] {
    let color = if usage.is_srgb() { &*SRGB_TABLE } else { &*LINEAR_TABLE };
    [color[t[0] as usize], color[t[1] as usize], color[t[2] as usize], LINEAR_TABLE[t[3] as usize]]
}

impl Texture {
    /// An uncompressed texture with the default sampler; `texels` are `width` x `height` x 4 bytes.
    pub fn rgba8(name: &str, [width, height]: [u32; 2], usage: TextureUsage, texels: Vec<u8>) -> Self {
        let (texels, sampler) = (Texels::Rgba8(texels), Sampler::default());
        Self { name: name.into(), width, height, usage, texels, sampler }
    }

    /// The linear RGBA value of one texel of the finest level. Of compressed textures this decodes a whole block: who
    /// reads many texels takes [`Texture::decoded`] first.
    pub fn texel(&self, x: u32, y: u32) -> [f32; 4] {
        match &self.texels {
            Texels::Rgba8(texels) => {
                let at = 4 * (y as usize * self.width as usize + x as usize);
                decode_texel(self.usage, [texels[at], texels[at + 1], texels[at + 2], texels[at + 3]])
            }
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
            Texels::Blocks { levels, .. } => levels.iter().map(Vec::len).sum(),
        }
    }

    /// What the texture takes with its mips when it is not compressed: two bytes a texel for normal maps, else four.
    pub fn uncompressed_bytes(&self) -> u64 {
        let texel = if self.usage == TextureUsage::Normal { 2 } else { 4 };
        let side = |side: u32, level: usize| u64::from((side >> level).max(1));
        (0..self.full_level_count()).map(|i| texel * side(self.width, i) * side(self.height, i)).sum()
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
            Texels::Rgba8(texels) => fits(texels.len(), self.width as usize * self.height as usize * 4),
            Texels::Blocks { levels, .. } if levels.is_empty() || levels.len() > self.full_level_count() => {
                Err(format!("{} mip levels", levels.len()))
            }
            Texels::Blocks { format, levels } => levels.iter().enumerate().try_for_each(|(i, level)| {
                let extent = [self.width, self.height].map(|side| (side >> i).max(1));
                fits(level.len(), format.level_bytes(extent))
            }),
        }
    }

    /// The whole mip chain without compression, from the finest level to 1x1. Each level halves both sides, rounding
    /// down, by an exact area average of linear values: the mean is kept for sizes that are no power of two as well.
    /// Rounding to 8 bits happens once per level and does not add up. [`TextureUsage`] says what is averaged. A
    /// compressed texture gives the levels that it has.
    pub fn mips(&self) -> Vec<MipLevel> {
        match &self.texels {
            Texels::Rgba8(texels) => self.mips_of(texels),
            Texels::Blocks { format, levels } => {
                let levels = levels.iter().enumerate().map(|(i, level)| {
                    let [width, height] = [self.width, self.height].map(|side| (side >> i).max(1));
                    MipLevel { width, height, texels: format.decode([width, height], level) }
                });
                levels.collect()
            }
        }
    }

    fn mips_of(&self, texels: &[u8]) -> Vec<MipLevel> {
        let (mut width, mut height) = (self.width, self.height);
        let mut levels = vec![MipLevel { width, height, texels: texels.to_vec() }];
        let mut linear: Vec<[f32; 4]> = Vec::new();
        while width > 1 || height > 1 {
            linear = if levels.len() == 1 {
                halve(width, height, |at| {
                    let t = &texels[4 * at..4 * at + 4];
                    filtered(self.usage, decode_texel(self.usage, [t[0], t[1], t[2], t[3]]))
                })
            } else {
                halve(width, height, |at| linear[at])
            };
            (width, height) = ((width / 2).max(1), (height / 2).max(1));
            let mut encoded = Vec::with_capacity(linear.len() * 4);
            linear.iter().for_each(|t| encoded.extend_from_slice(&encode(self.usage, *t)));
            levels.push(MipLevel { width, height, texels: encoded });
        }
        levels
    }
}

/// Added to alpha where it is a weight, so that wholly transparent regions keep a colour.
const LEAST_WEIGHT: f32 = 1e-3;

/// What is averaged for a decoded texel.
fn filtered(usage: TextureUsage, [r, g, b, a]: [f32; 4]) -> [f32; 4] {
    match usage {
        TextureUsage::Color | TextureUsage::Data => [r, g, b, a],
        TextureUsage::Cutout => {
            let w = a + LEAST_WEIGHT;
            [r * w, g * w, b * w, a]
        }
        TextureUsage::Normal => [2.0 * r - 1.0, 2.0 * g - 1.0, 2.0 * b - 1.0, a],
    }
}

/// The bytes of an average of [`filtered`] values.
fn encode(usage: TextureUsage, [r, g, b, a]: [f32; 4]) -> [u8; 4] {
    match usage {
        TextureUsage::Color => [srgb_byte(r), srgb_byte(g), srgb_byte(b), byte(a)],
        TextureUsage::Cutout => {
            let w = a + LEAST_WEIGHT;
            [srgb_byte(r / w), srgb_byte(g / w), srgb_byte(b / w), byte(a)]
        }
        TextureUsage::Data => [byte(r), byte(g), byte(b), byte(a)],
        TextureUsage::Normal => encode_normal([r, g, b]),
    }
}

/// The bytes of a normal map's texel that points along `n`; what has no direction points straight up.
pub(crate) fn encode_normal(n: [f32; 3]) -> [u8; 4] {
    let length = n.iter().map(|x| x * x).sum::<f32>().sqrt();
    let n = if length > 1e-6 { n.map(|x| x / length) } else { [0.0, 0.0, 1.0] };
    [byte(0.5 * n[0] + 0.5), byte(0.5 * n[1] + 0.5), byte(0.5 * n[2] + 0.5), 255]
}

fn byte(x: f32) -> u8 {
    (x * 255.0 + 0.5) as u8
}

/// Smallest linear values that round to each 8-bit sRGB code.
static SRGB_THRESHOLDS: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|i| linear_from_srgb((i as f32 - 0.5).max(0.0) / 255.0)));
const SRGB_BUCKETS: usize = 4096;
/// Code at the lower end of each bucket of linear values.
static SRGB_CODES: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let code = |i: usize| byte(srgb_from_linear(i as f32 / SRGB_BUCKETS as f32));
    (0..=SRGB_BUCKETS).map(code).collect()
});

/// `byte(srgb_from_linear(x))` without the power function: mips are made of some hundred million texels.
fn srgb_byte(x: f32) -> u8 {
    let x = x.clamp(0.0, 1.0);
    let mut code = SRGB_CODES[(x * SRGB_BUCKETS as f32) as usize];
    while code < 255 && x >= SRGB_THRESHOLDS[code as usize + 1] {
        code += 1;
    }
    code
}

/// Source texels and weights that make up target texel `i` when `from` texels become `max(1, from / 2)`.
fn taps(from: u32, i: u32) -> impl Iterator<Item = (u32, f32)> {
    let to = (from / 2).max(1);
    let (start, end) = (u64::from(i) * u64::from(from), u64::from(i + 1) * u64::from(from));
    let to = u64::from(to);
    (start / to..end.div_ceil(to)).map(move |x| {
        let overlap = end.min((x + 1) * to) - start.max(x * to);
        (x as u32, overlap as f32 / from as f32)
    })
}

/// The next level of `width` x `height` values, which `value` gives by their place row by row.
fn halve(width: u32, height: u32, value: impl Fn(usize) -> [f32; 4]) -> Vec<[f32; 4]> {
    let (w, h) = ((width / 2).max(1), (height / 2).max(1));
    let mut out = Vec::with_capacity(w as usize * h as usize);
    let row = width as usize;
    if width.is_multiple_of(2) && height.is_multiple_of(2) {
        for y in 0..h as usize {
            for x in 0..w as usize {
                let at = 2 * (y * row + x);
                let [a, b, c, d] = [at, at + 1, at + row, at + row + 1].map(&value);
                out.push(std::array::from_fn(|i| 0.25 * ((a[i] + b[i]) + (c[i] + d[i]))));
            }
        }
        return out;
    }
    for y in 0..h {
        for x in 0..w {
            let mut sum = [0.0f32; 4];
            for (sy, wy) in taps(height, y) {
                for (sx, wx) in taps(width, x) {
                    let t = value(sy as usize * row + sx as usize);
                    for c in 0..4 {
                        sum[c] += wx * wy * t[c];
                    }
                }
            }
            out.push(sum);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_encodes_as_the_formula() {
        for i in 0..=1_000_000u32 {
            let x = i as f32 * 1e-6;
            let (table, formula) = (srgb_byte(x), byte(srgb_from_linear(x)));
            // Both round the same real number; next to a threshold fp32 may decide either way.
            let near = SRGB_THRESHOLDS.iter().any(|t| (t - x).abs() < 1e-6);
            assert!(table == formula || near && table.abs_diff(formula) == 1, "{x}: {table}, {formula}");
        }
    }
}
