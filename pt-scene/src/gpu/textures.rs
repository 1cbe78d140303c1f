//! The scene's textures and its environment as one bindless table.

use crate::mips::{coarser_linear, code_16, decode_texel_16, linear_from_srgb};
use crate::{Environment, Filter, MipFilter, Sampler, Scene, Texels, Texture, TextureUsage, Wrap};
use half::f16;
use pt_core::Device;
use pt_core::sampler::{self, MipMode, SamplerDesc};
use pt_core::texture::{TextureDesc, TextureFormat, TextureTable, TextureTableBuilder};
use pt_shaders::records::MAX_TEXTURE_ANISOTROPY;
use rayon::prelude::*;
use std::borrow::Cow;
use std::sync::mpsc::{self, Receiver};
use std::thread::Scope;

/// Bytes of texels that are prepared together, and batches that wait to be uploaded: they bound the memory that mips take
/// on their way, a third of the texels (half for normal maps).
const BATCH_BYTES: usize = 16 << 20;
const BATCHES_AHEAD: usize = 8;

fn sampler(s: Sampler) -> SamplerDesc {
    let wrap = |w| match w {
        Wrap::Repeat => sampler::Wrap::Repeat,
        Wrap::MirroredRepeat => sampler::Wrap::MirroredRepeat,
        Wrap::ClampToEdge => sampler::Wrap::ClampToEdge,
    };
    let linear = |f| f == Filter::Linear;
    SamplerDesc {
        wrap: [wrap(s.wrap_u), wrap(s.wrap_v)],
        mag_linear: linear(s.mag),
        min_linear: linear(s.min),
        mip: match s.mip {
            MipFilter::Off => MipMode::Off,
            MipFilter::Nearest => MipMode::Nearest,
            MipFilter::Linear => MipMode::Linear,
        },
        max_anisotropy: MAX_TEXTURE_ANISOTROPY,
    }
}

/// A texture as it goes to the device.
pub(super) struct Prepared<'a> {
    texture: &'a Texture,
    format: TextureFormat,
    levels: Vec<Cow<'a, [u8]>>,
}

/// What a device does with textures.
#[derive(Clone, Copy)]
struct Abilities {
    /// It takes compressed ones.
    compressed: bool,
    /// It decodes sRGB with the precision of the standard. Drivers that run on the CPU fit a polynomial, which is off by 2.5 % in the darks.
    srgb: bool,
    /// It filters 16-bit unorm codes.
    unorm_16: bool,
}

/// Compressed textures go as they are where the device takes them. Normal maps keep x and y.
fn prepare(texture: &Texture, device: Abilities) -> Prepared<'_> {
    let srgb = texture.usage.is_srgb();
    if let Texels::Rgba16(texels) = &texture.texels {
        return prepare_16_bit(texture, texels, device);
    }
    if let (Texels::Blocks { format, levels }, true) = (&texture.texels, device.compressed) {
        let format = TextureFormat::Block { format: *format, srgb };
        return Prepared { texture, format, levels: levels.iter().map(|level| level.into()).collect() };
    }
    if srgb && !device.srgb {
        let levels = texture.mips().into_iter().map(|level| linear_halves(&level.texels).into());
        return Prepared { texture, format: TextureFormat::Rgba16F, levels: levels.collect() };
    }
    let format = match texture.usage {
        TextureUsage::Color | TextureUsage::Cutout => TextureFormat::Rgba8Srgb,
        TextureUsage::Data => TextureFormat::Rgba8Unorm,
        TextureUsage::Normal => TextureFormat::Rg8Unorm,
    };
    let levels = texture.mips().into_iter().map(|level| match texture.usage {
        TextureUsage::Normal => {
            let xy: Vec<_> = level.texels.as_chunks().0.iter().map(|&[x, y, _, _]| [x, y]).collect();
            xy.into_flattened().into()
        }
        _ => level.texels,
    });
    Prepared { texture, format, levels: levels.collect() }
}

/// No format has 16-bit sRGB codes, so colours go as linear values. They are half floats, at most 1/2048 off: linear unorm codes of 16 bits
/// are up to 2.4 % off between the two darkest codes of an 8-bit image. Other values go as the codes that they are; half floats hold 12 bits of
/// them and are for devices that do not filter these codes.
fn prepare_16_bit<'a>(texture: &'a Texture, texels: &'a [u16], device: Abilities) -> Prepared<'a> {
    let usage = texture.usage;
    let finest = texels.as_chunks().0.iter().map(|&texel| decode_texel_16(usage, texel));
    let coarser = coarser_linear(usage, [texture.width, texture.height], texels);
    let unorm = device.unorm_16 && !usage.is_srgb();
    let (format, levels) = match (usage == TextureUsage::Normal, unorm) {
        (true, true) => (TextureFormat::Rg16Unorm, levels_of::<2>(finest, &coarser, code_16)),
        (true, false) => (TextureFormat::Rg16F, levels_of::<2>(finest, &coarser, half_bits)),
        (false, true) => (TextureFormat::Rgba16Unorm, levels_of::<4>(finest, &coarser, code_16)),
        (false, false) => (TextureFormat::Rgba16F, levels_of::<4>(finest, &coarser, half_bits)),
    };
    Prepared { texture, format, levels }
}

fn half_bits(x: f32) -> u16 {
    f16::from_f32(x).to_bits()
}

/// The first `N` channels of all levels, each as `encode` writes it.
fn levels_of<'a, const N: usize>(
    finest: impl Iterator<Item = [f32; 4]>,
    coarser: &[Vec<[f32; 4]>],
    encode: impl Fn(f32) -> u16 + Copy,
) -> Vec<Cow<'a, [u8]>> {
    let texel = |linear: [f32; 4]| std::array::from_fn::<_, N, _>(|i| encode(linear[i]).to_le_bytes());
    let bytes = |level: Vec<[[u8; 2]; N]>| level.into_flattened().into_flattened().into();
    let coarser = coarser.iter().map(|level| level.iter().copied().map(texel).collect());
    std::iter::once(finest.map(texel).collect()).chain(coarser).map(bytes).collect()
}

/// Linear values of sRGB bytes, as half floats.
fn linear_halves(texels: &[u8]) -> Vec<u8> {
    let linear: [[u8; 2]; 256] =
        std::array::from_fn(|i| f16::from_f32(linear_from_srgb(i as f32 / 255.0)).to_le_bytes());
    let alpha: [[u8; 2]; 256] = std::array::from_fn(|i| f16::from_f32(i as f32 / 255.0).to_le_bytes());
    let texel = |&[r, g, b, a]: &[u8; 4]| {
        [linear[r as usize], linear[g as usize], linear[b as usize], alpha[a as usize]]
    };
    texels.as_chunks().0.iter().flat_map(texel).flatten().collect()
}

/// Texture by texture in batches of at most [`BATCH_BYTES`]; a batch has at least one.
fn batches(mut rest: &[Texture]) -> impl Iterator<Item = &[Texture]> {
    std::iter::from_fn(move || {
        let mut bytes = 0;
        let fits = |t: &&Texture| {
            bytes += t.bytes();
            bytes <= BATCH_BYTES
        };
        let batch;
        (batch, rest) = rest.split_at(rest.iter().take_while(fits).count().max(1).min(rest.len()));
        (!batch.is_empty()).then_some(batch)
    })
}

/// Prepares all textures on a thread of its own, a few batches ahead of who receives them.
pub(super) fn prepare_all<'scope>(
    threads: &'scope Scope<'scope, '_>,
    device: &Device,
    scene: &'scope Scene,
) -> Receiver<Vec<Prepared<'scope>>> {
    let info = device.info();
    let abilities = Abilities {
        compressed: info.capabilities.texture_compression_bc,
        srgb: !info.is_cpu(),
        unorm_16: info.capabilities.texture_16_bit_unorm,
    };
    let (send, receive) = mpsc::sync_channel(BATCHES_AHEAD);
    threads.spawn(move || {
        for batch in batches(&scene.textures) {
            let prepared = batch.par_iter().map(|texture| prepare(texture, abilities)).collect();
            // Nobody receives when the scene has failed elsewhere.
            if send.send(prepared).is_err() {
                return;
            }
        }
    });
    receive
}

/// Uploads the textures as they come, and the environment behind them: its index is the number of textures.
pub(super) fn table(
    device: &Device,
    scene: &Scene,
    textures: Receiver<Vec<Prepared<'_>>>,
) -> pt_core::Result<TextureTable> {
    let mut builder = TextureTableBuilder::new(device, scene.textures.len() + 1)?;
    for Prepared { texture, format, levels } in textures.into_iter().flatten() {
        let mips: Vec<&[u8]> = levels.iter().map(|level| &**level).collect();
        builder.add(&TextureDesc {
            name: &texture.name,
            extent: [texture.width, texture.height],
            format,
            sampler: sampler(texture.sampler),
            mips: &mips,
        })?;
    }
    add_environment(&mut builder, &scene.environment)?;
    Ok(builder.finish())
}

fn add_environment(builder: &mut TextureTableBuilder, environment: &Environment) -> pt_core::Result<()> {
    let image = &environment.image;
    let texels: Vec<[f32; 4]> = image.texels.iter().map(|t| t.extend(1.0).to_array()).collect();
    builder.add(&TextureDesc {
        name: "environment",
        extent: [image.width, image.height],
        format: TextureFormat::Rgba32F,
        sampler: SamplerDesc {
            wrap: [sampler::Wrap::Repeat, sampler::Wrap::ClampToEdge],
            mip: MipMode::Off,
            max_anisotropy: 1.0,
            ..SamplerDesc::default()
        },
        mips: &[bytemuck::cast_slice(&texels)],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Formats that every device filters, and what they hold of 16 bits.
    #[test]
    fn devices_that_do_not_filter_16_bit_codes_get_half_floats() {
        let [basic, capable] =
            [false, true].map(|unorm_16| Abilities { compressed: true, srgb: true, unorm_16 });
        let codes = [0x1234, 0x5678, 0x9abc, 0xffff, 1, 2, 3, 4];
        use TextureFormat::{Rg16F, Rg16Unorm, Rgba16F, Rgba16Unorm};
        for (usage, device, format, channels) in [
            (TextureUsage::Color, basic, Rgba16F, 4),
            (TextureUsage::Color, capable, Rgba16F, 4),
            (TextureUsage::Data, basic, Rgba16F, 4),
            (TextureUsage::Data, capable, Rgba16Unorm, 4),
            (TextureUsage::Normal, basic, Rg16F, 2),
            (TextureUsage::Normal, capable, Rg16Unorm, 2),
        ] {
            let texture = Texture::rgba16("wide", [2, 1], usage, codes.into());
            let prepared = prepare(&texture, device);
            assert_eq!((prepared.format, prepared.levels.len()), (format, 2), "{usage:?}");
            let level = |i: usize| -> Vec<u16> {
                let words = prepared.levels[i].as_chunks().0;
                words.iter().map(|&word| u16::from_le_bytes(word)).collect()
            };
            assert_eq!(level(1).len(), channels);
            let linear = [texture.texel(0, 0), texture.texel(1, 0)];
            let expected: Vec<f32> = linear.iter().flat_map(|t| t[..channels].to_vec()).collect();
            for (code, value) in level(0).into_iter().zip(expected) {
                let (held, tolerance) = match format {
                    Rgba16Unorm | Rg16Unorm => (f32::from(code) / 65535.0, 0.0),
                    _ => (f16::from_bits(code).to_f32(), value / 2048.0 + 3e-8),
                };
                assert!((held - value).abs() <= tolerance, "{usage:?}: {held}, {value}");
            }
        }
    }
}
