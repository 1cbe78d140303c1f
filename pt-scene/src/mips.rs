//! Mip chains: exact area averages of linear values, and the tables that make them cheap.

use crate::TextureUsage;
use std::borrow::Cow;
use std::sync::LazyLock;

/// One level of a mip chain with 8 bits per channel, in the encoding of its texture.
#[derive(Clone, Debug, PartialEq)]
pub struct MipLevel<'a> {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// RGBA8; those of the finest level of a [`crate::Texels::Rgba8`] are the texture's own.
    pub texels: Cow<'a, [u8]>,
}

/// Linear value 0..1 of an sRGB-encoded value 0..1 (IEC 61966-2-1).
pub fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// sRGB encoding 0..1 of a linear value 0..1 (IEC 61966-2-1).
pub fn srgb_from_linear(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

const SRGB_BUCKETS: usize = 4096;

/// The sRGB curve without the power function: mips are made of some hundred million texels.
struct SrgbTables {
    /// Linear value of each code.
    linear: [f32; 256],
    /// Smallest linear value that rounds to each code; behind them one that no value reaches.
    thresholds: [f32; 257],
    /// Code at the lower end of each bucket of linear values.
    codes: [u8; SRGB_BUCKETS + 1],
}

static SRGB: LazyLock<SrgbTables> = LazyLock::new(|| SrgbTables {
    linear: std::array::from_fn(|i| linear_from_srgb(i as f32 / 255.0)),
    thresholds: std::array::from_fn(|i| match i {
        256 => f32::INFINITY,
        _ => linear_from_srgb((i as f32 - 0.5).max(0.0) / 255.0),
    }),
    codes: std::array::from_fn(|i| byte(srgb_from_linear(i as f32 / SRGB_BUCKETS as f32))),
});

impl SrgbTables {
    /// `byte(srgb_from_linear(x))` for x in 0..1; what is outside is clamped.
    fn byte(&self, x: f32) -> u8 {
        let x = x.clamp(0.0, 1.0);
        let mut code = self.codes[(x * SRGB_BUCKETS as f32) as usize];
        while x >= self.thresholds[usize::from(code) + 1] {
            code += 1;
        }
        code
    }

    fn linear(&self, [r, g, b, a]: [u8; 4]) -> [f32; 4] {
        let [r, g, b] = [r, g, b].map(|t| self.linear[usize::from(t)]);
        [r, g, b, unorm(a)]
    }

    #[inline]
    fn bytes(&self, [r, g, b, a]: [f32; 4]) -> [u8; 4] {
        [self.byte(r), self.byte(g), self.byte(b), byte(a)]
    }
}

/// Linear value of each 16-bit sRGB code.
static LINEAR_16: LazyLock<Box<[f32]>> =
    LazyLock::new(|| (0..=u16::MAX).map(|code| linear_from_srgb(unorm_16(code))).collect());

fn unorm(t: u8) -> f32 {
    f32::from(t) / 255.0
}

fn byte(x: f32) -> u8 {
    (x * 255.0 + 0.5) as u8
}

fn unorm_16(t: u16) -> f32 {
    f32::from(t) / 65535.0
}

/// The 16-bit code of a value 0..1, rounded; what is outside is clamped.
pub(crate) fn code_16(x: f32) -> u16 {
    (x * 65535.0 + 0.5) as u16
}

/// The 8-bit code that is nearest to a 16-bit one.
fn narrow(code: u16) -> u8 {
    ((u32::from(code) + 128) / 257) as u8
}

/// Linear RGBA of four bytes.
pub fn decode_texel(usage: TextureUsage, texel: [u8; 4]) -> [f32; 4] {
    if usage.is_srgb() { SRGB.linear(texel) } else { texel.map(unorm) }
}

/// Linear RGBA of four 16-bit codes.
pub fn decode_texel_16(usage: TextureUsage, texel: [u16; 4]) -> [f32; 4] {
    if !usage.is_srgb() {
        return texel.map(unorm_16);
    }
    let [r, g, b, a] = texel;
    let [r, g, b] = [r, g, b].map(|code| LINEAR_16[usize::from(code)]);
    [r, g, b, unorm_16(a)]
}

/// RGB of a normal map's texel that points along `n`; what has no direction points straight up.
#[inline]
fn normal_texel(n: [f32; 3]) -> [f32; 3] {
    let length = n.iter().map(|x| x * x).sum::<f32>().sqrt();
    let n = if length > 1e-6 { n.map(|x| x / length) } else { [0.0, 0.0, 1.0] };
    [0.5 * n[0] + 0.5, 0.5 * n[1] + 0.5, 0.5 * n[2] + 0.5]
}

/// The bytes of a normal map's texel that points along `n`; what has no direction points straight up.
pub fn encode_normal(n: [f32; 3]) -> [u8; 4] {
    let [x, y, z] = normal_texel(n);
    [byte(x), byte(y), byte(z), 255]
}

/// As [`encode_normal`], with 16 bits per channel.
pub fn encode_normal_16(n: [f32; 3]) -> [u16; 4] {
    let [x, y, z] = normal_texel(n);
    [code_16(x), code_16(y), code_16(z), u16::MAX]
}

/// Added to alpha where it is a weight, so that wholly transparent regions keep a colour.
const LEAST_WEIGHT: f32 = 1e-3;

/// The whole chain of RGBA8 `texels`; see [`crate::Texture::mips`].
pub(crate) fn mips(usage: TextureUsage, extent: [u32; 2], texels: &[u8]) -> Vec<MipLevel<'_>> {
    let srgb = &*SRGB;
    let quads = texels.as_chunks().0;
    let coarser = if usage.is_srgb() {
        coarser(usage, extent, quads, |t| srgb.linear(t), |linear| srgb.bytes(linear))
    } else {
        coarser(usage, extent, quads, |t| t.map(unorm), |linear| linear.map(byte))
    };
    rgba8_levels(extent, texels.into(), coarser)
}

/// The whole chain of RGBA16 `texels`, rounded to 8 bits.
pub(crate) fn narrow_mips(usage: TextureUsage, extent: [u32; 2], texels: &[u16]) -> Vec<MipLevel<'static>> {
    let srgb = &*SRGB;
    let encode = |linear: [f32; 4]| {
        if usage.is_srgb() { srgb.bytes(linear) } else { linear.map(byte) }
    };
    let decode = |t| decode_texel_16(usage, t);
    let finest: Vec<u8> = texels.iter().map(|&code| narrow(code)).collect();
    rgba8_levels(extent, finest.into(), coarser(usage, extent, texels.as_chunks().0, decode, encode))
}

/// Linear RGBA of the levels of RGBA16 `texels`, without the finest one.
pub(crate) fn coarser_linear(usage: TextureUsage, extent: [u32; 2], texels: &[u16]) -> Vec<Vec<[f32; 4]>> {
    let decode = |t| decode_texel_16(usage, t);
    let levels = coarser(usage, extent, texels.as_chunks().0, decode, |linear| linear);
    levels.into_iter().map(|(_, texels)| texels).collect()
}

fn rgba8_levels(
    [width, height]: [u32; 2],
    finest: Cow<'_, [u8]>,
    coarser: Vec<([u32; 2], Vec<[u8; 4]>)>,
) -> Vec<MipLevel<'_>> {
    let coarser = coarser.into_iter().map(|([width, height], texels)| MipLevel {
        width,
        height,
        texels: texels.into_flattened().into(),
    });
    std::iter::once(MipLevel { width, height, texels: finest }).chain(coarser).collect()
}

/// The levels without the finest one: `decode` makes linear RGBA of a texel, `encode` makes a texel of it.
fn coarser<T: Copy, U>(
    usage: TextureUsage,
    extent: [u32; 2],
    texels: &[[T; 4]],
    decode: impl Fn([T; 4]) -> [f32; 4],
    encode: impl Fn([f32; 4]) -> U,
) -> Vec<([u32; 2], Vec<U>)> {
    match usage {
        TextureUsage::Color | TextureUsage::Data => chain(extent, texels, decode, encode),
        TextureUsage::Cutout => chain(
            extent,
            texels,
            |t| {
                let [r, g, b, a] = decode(t);
                let w = a + LEAST_WEIGHT;
                [r * w, g * w, b * w, a]
            },
            |[r, g, b, a]| {
                let w = a + LEAST_WEIGHT;
                encode([r / w, g / w, b / w, a])
            },
        ),
        TextureUsage::Normal => chain(
            extent,
            texels,
            |t| {
                let [x, y, z, a] = decode(t);
                [2.0 * x - 1.0, 2.0 * y - 1.0, 2.0 * z - 1.0, a]
            },
            |[x, y, z, _]| {
                let [x, y, z] = normal_texel([x, y, z]);
                encode([x, y, z, 1.0])
            },
        ),
    }
}

/// Averages what `value` makes of the texels; `encode` makes texels of averages.
fn chain<T: Copy, U>(
    [mut width, mut height]: [u32; 2],
    texels: &[[T; 4]],
    value: impl Fn([T; 4]) -> [f32; 4],
    encode: impl Fn([f32; 4]) -> U,
) -> Vec<([u32; 2], Vec<U>)> {
    let mut levels = Vec::new();
    let mut averages: Vec<[f32; 4]> = Vec::new();
    while width > 1 || height > 1 {
        averages = if levels.is_empty() {
            halve([width, height], texels, &value)
        } else {
            halve([width, height], &averages, |average| average)
        };
        (width, height) = ((width / 2).max(1), (height / 2).max(1));
        levels.push(([width, height], averages.iter().map(|&average| encode(average)).collect()));
    }
    levels
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

/// The next level of a `width` x `height` one.
fn halve<T: Copy>([width, height]: [u32; 2], level: &[T], value: impl Fn(T) -> [f32; 4]) -> Vec<[f32; 4]> {
    let (w, h) = ((width / 2).max(1), (height / 2).max(1));
    let mut out = Vec::with_capacity(w as usize * h as usize);
    let row = width as usize;
    if width.is_multiple_of(2) && height.is_multiple_of(2) {
        for rows in level.chunks_exact(2 * row) {
            let (upper, lower) = rows.split_at(row);
            let pairs = upper.as_chunks().0.iter().zip(lower.as_chunks().0);
            out.extend(pairs.map(|(&[a, b], &[c, d])| {
                let [a, b, c, d] = [a, b, c, d].map(&value);
                std::array::from_fn::<f32, 4, _>(|i| 0.25 * ((a[i] + b[i]) + (c[i] + d[i])))
            }));
        }
        return out;
    }
    for y in 0..h {
        for x in 0..w {
            let mut sum = [0.0f32; 4];
            for (sy, wy) in taps(height, y) {
                for (sx, wx) in taps(width, x) {
                    let t = value(level[sy as usize * row + sx as usize]);
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
            let (table, formula) = (SRGB.byte(x), byte(srgb_from_linear(x)));
            // Both round the same real number; next to a threshold fp32 may decide either way.
            let near = SRGB.thresholds.iter().any(|t| (t - x).abs() < 1e-6);
            assert!(table == formula || near && table.abs_diff(formula) == 1, "{x}: {table}, {formula}");
        }
    }
}
