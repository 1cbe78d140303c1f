//! The scene's textures and its environment as one bindless table.

use crate::mips::linear_from_srgb;
use crate::{Environment, Filter, MipFilter, Sampler, Scene, Texels, Texture, TextureUsage, Wrap};
use half::f16;
use pt_core::Device;
use pt_core::sampler::{self, MipMode, SamplerDesc};
use pt_core::texture::{TextureDesc, TextureFormat, TextureTable, TextureTableBuilder};
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
        max_anisotropy: 8.0,
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
}

/// Compressed textures go as they are where the device takes them. Normal maps keep x and y.
fn prepare(texture: &Texture, device: Abilities) -> Prepared<'_> {
    let srgb = texture.usage.is_srgb();
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
    let abilities = Abilities { compressed: info.capabilities.texture_compression_bc, srgb: !info.is_cpu() };
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
