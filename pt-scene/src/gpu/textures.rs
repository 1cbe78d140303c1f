//! The scene's textures and its environment as one bindless table.

use crate::{Environment, Filter, MipFilter, Sampler, Scene, Texels, Texture, TextureUsage, Wrap};
use pt_core::Device;
use pt_core::texture::{
    self, MipMode, SamplerDesc, TextureDesc, TextureFormat, TextureTable, TextureTableBuilder,
};
use rayon::prelude::*;

/// Bytes of texels that are prepared together: bounds the memory that mips in the making take.
const BATCH_BYTES: usize = 64 << 20;

fn sampler(s: Sampler) -> SamplerDesc {
    let wrap = |w| match w {
        Wrap::Repeat => texture::Wrap::Repeat,
        Wrap::MirroredRepeat => texture::Wrap::MirroredRepeat,
        Wrap::ClampToEdge => texture::Wrap::ClampToEdge,
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
struct Prepared<'a> {
    texture: &'a Texture,
    format: TextureFormat,
    levels: Vec<std::borrow::Cow<'a, [u8]>>,
}

/// Compressed textures go as they are where the device takes them. Normal maps keep x and y.
fn prepare(texture: &Texture, compressed: bool) -> Prepared<'_> {
    let srgb = texture.usage.is_srgb();
    if let (Texels::Blocks { format, levels }, true) = (&texture.texels, compressed) {
        let format = TextureFormat::Block { format: *format, srgb };
        return Prepared { texture, format, levels: levels.iter().map(|level| level.into()).collect() };
    }
    let format = match texture.usage {
        TextureUsage::Color | TextureUsage::Cutout => TextureFormat::Rgba8Srgb,
        TextureUsage::Data => TextureFormat::Rgba8Unorm,
        TextureUsage::Normal => TextureFormat::Rg8Unorm,
    };
    let levels = texture.mips().into_iter().map(|level| match texture.usage {
        TextureUsage::Normal => level.texels.chunks_exact(4).flat_map(|t| [t[0], t[1]]).collect(),
        _ => level.texels.into(),
    });
    Prepared { texture, format, levels: levels.collect() }
}

/// Uploads all textures with their mips, and the environment behind them: its index is the number of textures.
pub(super) fn table(device: &Device, scene: &Scene) -> pt_core::Result<TextureTable> {
    let compressed = device.info().capabilities.texture_compression_bc;
    let mut builder = TextureTableBuilder::new(device, scene.textures.len() + 1)?;
    let mut rest = &scene.textures[..];
    while !rest.is_empty() {
        let mut bytes = 0;
        let fits = |t: &&Texture| {
            bytes += t.bytes();
            bytes <= BATCH_BYTES
        };
        let (batch, behind) = rest.split_at(rest.iter().take_while(fits).count().max(1));
        rest = behind;
        let prepared: Vec<_> = batch.par_iter().map(|texture| prepare(texture, compressed)).collect();
        for Prepared { texture, format, levels } in &prepared {
            let mips: Vec<&[u8]> = levels.iter().map(|level| &**level).collect();
            builder.add(&TextureDesc {
                name: &texture.name,
                extent: [texture.width, texture.height],
                format: *format,
                sampler: sampler(texture.sampler),
                mips: &mips,
            })?;
        }
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
            wrap: [texture::Wrap::Repeat, texture::Wrap::ClampToEdge],
            mip: MipMode::Off,
            max_anisotropy: 1.0,
            ..SamplerDesc::default()
        },
        mips: &[bytemuck::cast_slice(&texels)],
    })
}
