//! The scene's textures and its environment as one bindless table.

use crate::{Filter, Sampler, Scene, Wrap};
use pt_core::Device;
use pt_core::texture::{self, SamplerDesc, TextureDesc, TextureFormat, TextureTable};
use rayon::prelude::*;

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
        mip_linear: true,
        max_anisotropy: 8.0,
    }
}

/// Uploads all textures with their mips, and the environment behind them: its index is the number of textures.
pub(super) fn table(device: &Device, scene: &Scene) -> pt_core::Result<TextureTable> {
    let mips: Vec<_> = scene.textures.par_iter().map(|texture| texture.mips()).collect();
    let levels: Vec<Vec<&[u8]>> =
        mips.iter().map(|m| m.iter().map(|level| level.texels.as_slice()).collect()).collect();
    let mut descs: Vec<_> = scene
        .textures
        .iter()
        .zip(&levels)
        .map(|(texture, mips)| TextureDesc {
            name: &texture.name,
            extent: [texture.width, texture.height],
            format: if texture.srgb { TextureFormat::Rgba8Srgb } else { TextureFormat::Rgba8Unorm },
            sampler: sampler(texture.sampler),
            mips,
        })
        .collect();
    let image = &scene.environment.image;
    let texels: Vec<[f32; 4]> = image.texels.iter().map(|t| t.extend(1.0).to_array()).collect();
    let bytes = [bytemuck::cast_slice(&texels)];
    descs.push(TextureDesc {
        name: "environment",
        extent: [image.width, image.height],
        format: TextureFormat::Rgba32F,
        sampler: SamplerDesc {
            wrap: [texture::Wrap::Repeat, texture::Wrap::ClampToEdge],
            mip_linear: false,
            max_anisotropy: 1.0,
            ..SamplerDesc::default()
        },
        mips: &bytes,
    });
    TextureTable::new(device, &descs)
}
