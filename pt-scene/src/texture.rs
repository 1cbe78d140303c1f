use std::sync::LazyLock;

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

/// How a texture is read between texels. Mip levels are always used and always blended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// The nearest texel.
    Nearest,
    /// Linear interpolation.
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
}

/// An 8-bit RGBA image with its sampler. Row 0 is the top (v = 0).
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Name from the file, for messages.
    pub name: String,
    /// Texels in a row, >= 1.
    pub width: u32,
    /// Rows, >= 1.
    pub height: u32,
    /// `width` x `height` x 4 bytes.
    pub texels: Vec<u8>,
    /// RGB is sRGB-encoded (colour); otherwise linear (data). Alpha is linear in both.
    pub srgb: bool,
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

impl Texture {
    /// The linear RGBA value of one texel.
    pub fn texel(&self, x: u32, y: u32) -> [f32; 4] {
        let at = 4 * (y as usize * self.width as usize + x as usize);
        let color = if self.srgb { &*SRGB_TABLE } else { &*LINEAR_TABLE };
        let t = &self.texels[at..at + 4];
        [color[t[0] as usize], color[t[1] as usize], color[t[2] as usize], LINEAR_TABLE[t[3] as usize]]
    }

    /// The whole mip chain, level 0 (a copy of the texture) to 1x1. Each level halves both sides, rounding down, by
    /// an exact area average of linear values: the mean is kept for sizes that are no power of two as well. Rounding
    /// to 8 bits happens once per level and does not add up.
    pub fn mips(&self) -> Vec<MipLevel> {
        let mut levels =
            vec![MipLevel { width: self.width, height: self.height, texels: self.texels.clone() }];
        let (mut width, mut height) = (self.width, self.height);
        let mut linear: Vec<[f32; 4]> = Vec::new();
        while width > 1 || height > 1 {
            let (w, h) = ((width / 2).max(1), (height / 2).max(1));
            linear = match levels.len() {
                1 => halve(width, height, |x, y| self.texel(x, y)),
                _ => halve(width, height, |x, y| linear[y as usize * width as usize + x as usize]),
            };
            (width, height) = (w, h);
            let texels = linear.iter().flat_map(|t| self.encode(*t)).collect();
            levels.push(MipLevel { width, height, texels });
        }
        levels
    }

    fn encode(&self, [r, g, b, a]: [f32; 4]) -> [u8; 4] {
        let byte = |x: f32| (x * 255.0 + 0.5) as u8;
        let color = |x: f32| byte(if self.srgb { srgb_from_linear(x) } else { x });
        [color(r), color(g), color(b), byte(a)]
    }
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

fn halve(width: u32, height: u32, texel: impl Fn(u32, u32) -> [f32; 4]) -> Vec<[f32; 4]> {
    let (w, h) = ((width / 2).max(1), (height / 2).max(1));
    let mut out = Vec::with_capacity(w as usize * h as usize);
    for y in 0..h {
        for x in 0..w {
            let mut sum = [0.0f32; 4];
            for (sy, wy) in taps(height, y) {
                for (sx, wx) in taps(width, x) {
                    let t = texel(sx, sy);
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
