//! Texture samplers and the layout of the texture table, which a device creates once.

use crate::error::{Result, VkContext};
use ash::vk;

/// Descriptor set of the bindless table, declared in scene.glsl.
pub const TEXTURE_SET: u32 = 3;

/// Behaviour outside [0, 1].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Wrap {
    /// Tile.
    #[default]
    Repeat,
    /// Tile mirrored.
    MirroredRepeat,
    /// Stretch the border.
    ClampToEdge,
}

/// Which mip levels are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum MipMode {
    /// The first only.
    Off,
    /// The nearest.
    Nearest,
    /// Two, blended.
    #[default]
    Linear,
}

/// How a texture is looked up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SamplerDesc {
    /// Horizontal and vertical wrapping.
    pub wrap: [Wrap; 2],
    /// Bilinear rather than nearest when magnified.
    pub mag_linear: bool,
    /// Bilinear rather than nearest when minified.
    pub min_linear: bool,
    /// Between mip levels.
    pub mip: MipMode,
    /// Largest anisotropy, 1 to 16.
    pub max_anisotropy: f32,
}

impl Default for SamplerDesc {
    fn default() -> Self {
        Self {
            wrap: [Wrap::Repeat; 2],
            mag_linear: true,
            min_linear: true,
            mip: MipMode::Linear,
            max_anisotropy: 8.0,
        }
    }
}

pub(crate) fn table_layout(raw: &ash::Device, count: u32) -> Result<vk::DescriptorSetLayout> {
    let bindings = [vk::DescriptorSetLayoutBinding::default()
        .binding(0)
        .descriptor_type(vk::DescriptorType::COMBINED_IMAGE_SAMPLER)
        .descriptor_count(count)
        .stage_flags(vk::ShaderStageFlags::ALL)];
    let flags = [vk::DescriptorBindingFlags::PARTIALLY_BOUND];
    let mut flags = vk::DescriptorSetLayoutBindingFlagsCreateInfo::default().binding_flags(&flags);
    let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings).push_next(&mut flags);
    // SAFETY: valid device and create info.
    unsafe { raw.create_descriptor_set_layout(&info, None) }.context("vkCreateDescriptorSetLayout")
}

pub(crate) fn create_sampler(raw: &ash::Device, desc: &SamplerDesc) -> Result<vk::Sampler> {
    let filter = |linear| if linear { vk::Filter::LINEAR } else { vk::Filter::NEAREST };
    let wrap = |wrap| match wrap {
        Wrap::Repeat => vk::SamplerAddressMode::REPEAT,
        Wrap::MirroredRepeat => vk::SamplerAddressMode::MIRRORED_REPEAT,
        Wrap::ClampToEdge => vk::SamplerAddressMode::CLAMP_TO_EDGE,
    };
    let anisotropic =
        desc.mip != MipMode::Off && desc.max_anisotropy > 1.0 && desc.min_linear && desc.mag_linear;
    let info = vk::SamplerCreateInfo::default()
        .mag_filter(filter(desc.mag_linear))
        .min_filter(filter(desc.min_linear))
        .mipmap_mode(match desc.mip {
            MipMode::Linear => vk::SamplerMipmapMode::LINEAR,
            MipMode::Off | MipMode::Nearest => vk::SamplerMipmapMode::NEAREST,
        })
        .address_mode_u(wrap(desc.wrap[0]))
        .address_mode_v(wrap(desc.wrap[1]))
        .anisotropy_enable(anisotropic)
        .max_anisotropy(if anisotropic { desc.max_anisotropy.min(16.0) } else { 1.0 })
        // Up to 0.25 the first level is the nearest, and the filter can still tell magnification from minification.
        .max_lod(if desc.mip == MipMode::Off { 0.25 } else { vk::LOD_CLAMP_NONE });
    // SAFETY: valid device and create info.
    unsafe { raw.create_sampler(&info, None) }.context("vkCreateSampler")
}
