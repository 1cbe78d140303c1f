//! Sampled textures and the bindless table that kernels see as `textures[]`.

mod block;

pub use block::BlockFormat;

use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::{Error, Result, VkContext};
use crate::image::{copy_region, create_raw, transition};
use crate::sampler::{SamplerDesc, create_sampler};
use ash::vk;
use gpu_allocator::vulkan::Allocation;
use std::sync::Arc;

/// Texel format of a sampled texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextureFormat {
    /// Four bytes, decoded from sRGB before filtering.
    Rgba8Srgb,
    /// Four bytes, linear.
    Rgba8Unorm,
    /// Two bytes, linear; the rest reads as 0 and 1.
    Rg8Unorm,
    /// Compressed blocks of 4x4 texels; colour formats decoded from sRGB when `srgb`. Needs
    /// [`crate::device::Capabilities::texture_compression_bc`].
    Block {
        /// How they are compressed.
        format: BlockFormat,
        /// Decode colour from sRGB.
        srgb: bool,
    },
    /// Four 16-bit codes, linear. Needs [`crate::device::Capabilities::texture_16_bit_unorm`].
    Rgba16Unorm,
    /// Two 16-bit codes, linear; the rest reads as 0 and 1. Needs [`crate::device::Capabilities::texture_16_bit_unorm`].
    Rg16Unorm,
    /// Four half floats.
    Rgba16F,
    /// Two half floats; the rest reads as 0 and 1.
    Rg16F,
    /// Four floats.
    Rgba32F,
}

impl TextureFormat {
    fn vk(self) -> vk::Format {
        match self {
            Self::Rgba8Srgb => vk::Format::R8G8B8A8_SRGB,
            Self::Rgba8Unorm => vk::Format::R8G8B8A8_UNORM,
            Self::Rg8Unorm => vk::Format::R8G8_UNORM,
            Self::Block { format, srgb } => format.vk(srgb),
            Self::Rgba16Unorm => vk::Format::R16G16B16A16_UNORM,
            Self::Rg16Unorm => vk::Format::R16G16_UNORM,
            Self::Rgba16F => vk::Format::R16G16B16A16_SFLOAT,
            Self::Rg16F => vk::Format::R16G16_SFLOAT,
            Self::Rgba32F => vk::Format::R32G32B32A32_SFLOAT,
        }
    }

    /// Bytes of a tightly packed level.
    fn level_bytes(self, extent: [u32; 2]) -> usize {
        let texels = extent[0] as usize * extent[1] as usize;
        match self {
            Self::Rgba8Srgb | Self::Rgba8Unorm | Self::Rg16Unorm | Self::Rg16F => 4 * texels,
            Self::Rg8Unorm => 2 * texels,
            Self::Block { format, .. } => format.level_bytes(extent),
            Self::Rgba16Unorm | Self::Rgba16F => 8 * texels,
            Self::Rgba32F => 16 * texels,
        }
    }
}

/// Content of a texture: mip levels from fine to coarse, each tightly packed.
#[derive(Clone, Copy)]
pub struct TextureDesc<'a> {
    /// Debug name.
    pub name: &'a str,
    /// Width and height of the first level.
    pub extent: [u32; 2],
    /// Texel format.
    pub format: TextureFormat,
    /// Lookup.
    pub sampler: SamplerDesc,
    /// Levels; level i has extent max(1, extent >> i).
    pub mips: &'a [&'a [u8]],
}

struct Texture {
    image: vk::Image,
    view: vk::ImageView,
    sampler: vk::Sampler,
    allocation: Option<Allocation>,
}

/// The scene's textures in one descriptor set; a material refers to them by index.
#[derive(Clone)]
pub struct TextureTable(Arc<Inner>);

struct Inner {
    device: Device,
    pool: vk::DescriptorPool,
    set: vk::DescriptorSet,
    textures: Vec<Texture>,
    bytes: u64,
}

impl TextureTable {
    /// Uploads all textures and waits.
    pub fn new(device: &Device, textures: &[TextureDesc<'_>]) -> Result<Self> {
        let mut builder = TextureTableBuilder::new(device, textures.len())?;
        textures.iter().try_for_each(|desc| builder.add(desc))?;
        Ok(builder.finish())
    }

    /// Bytes of all texels.
    pub fn bytes(&self) -> u64 {
        self.0.bytes
    }

    /// Number of textures.
    pub fn len(&self) -> usize {
        self.0.textures.len()
    }

    /// Whether there are no textures.
    pub fn is_empty(&self) -> bool {
        self.0.textures.is_empty()
    }

    pub(crate) fn set(&self) -> vk::DescriptorSet {
        self.0.set
    }
}

/// Builds a [`TextureTable`]: textures are added one by one, so that their texels need not be in memory at the same time.
pub struct TextureTableBuilder {
    table: Inner,
    /// As large as the largest texture so far.
    staging: Option<Buffer>,
}

impl TextureTableBuilder {
    /// An empty table that will take `count` textures.
    pub fn new(device: &Device, count: usize) -> Result<Self> {
        let capacity = device.info().capabilities.max_textures;
        if count > capacity as usize {
            return Err(Error::Unsupported(format!(
                "the scene has {count} textures, this device holds {capacity} in one table"
            )));
        }
        let raw = device.raw();
        let sizes = [vk::DescriptorPoolSize {
            ty: vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
            descriptor_count: capacity,
        }];
        let layouts = [device.texture_layout()];
        // SAFETY: valid device and create infos; the set is freed with its pool.
        let (pool, set) = unsafe {
            let pool = raw
                .create_descriptor_pool(
                    &vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes),
                    None,
                )
                .context("vkCreateDescriptorPool")?;
            let set = raw.allocate_descriptor_sets(
                &vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts),
            );
            match set {
                Ok(sets) => (pool, sets[0]),
                Err(result) => {
                    raw.destroy_descriptor_pool(pool, None);
                    return Err(Error::Vulkan { call: "vkAllocateDescriptorSets", result });
                }
            }
        };
        let table = Inner { device: device.clone(), pool, set, textures: Vec::new(), bytes: 0 };
        Ok(Self { table, staging: None })
    }

    /// Uploads the next texture and waits.
    pub fn add(&mut self, desc: &TextureDesc<'_>) -> Result<()> {
        let staging = self.staging(desc.mips.iter().map(|m| m.len() as u64).sum())?;
        let inner = &mut self.table;
        let texture = upload(&inner.device, desc, &staging)?;
        let info = [vk::DescriptorImageInfo {
            sampler: texture.sampler,
            image_view: texture.view,
            image_layout: vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
        }];
        inner.bytes += desc.mips.iter().map(|m| m.len() as u64).sum::<u64>();
        let write = vk::WriteDescriptorSet::default()
            .dst_set(inner.set)
            .dst_binding(0)
            .dst_array_element(inner.textures.len() as u32)
            .descriptor_type(vk::DescriptorType::COMBINED_IMAGE_SAMPLER)
            .image_info(&info);
        // SAFETY: the set is not in use yet.
        unsafe { inner.device.raw().update_descriptor_sets(&[write], &[]) };
        inner.textures.push(texture);
        Ok(())
    }

    fn staging(&mut self, bytes: u64) -> Result<Buffer> {
        match &self.staging {
            Some(staging) if staging.size() >= bytes => Ok(staging.clone()),
            _ => {
                let staging = Buffer::new(&self.table.device, "texture staging", bytes, Location::Upload)?;
                Ok(self.staging.insert(staging).clone())
            }
        }
    }

    /// The table.
    pub fn finish(self) -> TextureTable {
        TextureTable(Arc::new(self.table))
    }
}

fn upload(device: &Device, desc: &TextureDesc<'_>, staging: &Buffer) -> Result<Texture> {
    let block = matches!(desc.format, TextureFormat::Block { .. });
    if block && !device.info().capabilities.texture_compression_bc {
        return Err(Error::Unsupported(format!("{}: this device has no BC texture compression", desc.name)));
    }
    let level_extent = |level: usize| desc.extent.map(|side| (side >> level).max(1));
    for (level, data) in desc.mips.iter().enumerate() {
        let [w, h] = level_extent(level);
        if data.len() != desc.format.level_bytes([w, h]) {
            return Err(Error::Unsupported(format!(
                "{}: mip {level} of {w}x{h} has {} bytes",
                desc.name,
                data.len()
            )));
        }
    }
    let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
    let (format, flags) = (desc.format.vk(), vk::ImageCreateFlags::empty());
    let (image, view, allocation) =
        create_raw(device, desc.name, format, desc.extent, desc.mips.len() as u32, usage, flags)?;
    let mut texture = Texture { image, view, sampler: vk::Sampler::null(), allocation: Some(allocation) };
    let result = fill(device, desc, image, staging, level_extent)
        .and_then(|()| create_sampler(device.raw(), &desc.sampler));
    match result {
        Ok(sampler) => texture.sampler = sampler,
        Err(error) => {
            destroy(device, &mut texture);
            return Err(error);
        }
    }
    Ok(texture)
}

fn fill(
    device: &Device,
    desc: &TextureDesc<'_>,
    image: vk::Image,
    staging: &Buffer,
    extent: impl Fn(usize) -> [u32; 2],
) -> Result<()> {
    let mut regions = Vec::with_capacity(desc.mips.len());
    let mut offset = 0;
    for (level, data) in desc.mips.iter().enumerate() {
        staging.write(offset, data);
        regions.push(copy_region(offset as u64, level as u32, extent(level)));
        offset += data.len();
    }
    device.submit_once(|cmd| {
        transition(device, cmd, image, vk::ImageLayout::UNDEFINED, vk::ImageLayout::TRANSFER_DST_OPTIMAL);
        // SAFETY: image and buffer are alive until the wait inside submit_once is over.
        unsafe {
            let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
            device.raw().cmd_copy_buffer_to_image(cmd, staging.handle(), image, layout, &regions);
        }
        let (from, to) = (vk::ImageLayout::TRANSFER_DST_OPTIMAL, vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
        transition(device, cmd, image, from, to);
    })
}

fn destroy(device: &Device, texture: &mut Texture) {
    // SAFETY: the table that owns the texture is being dropped, or was never built.
    unsafe {
        device.raw().destroy_sampler(texture.sampler, None);
        device.raw().destroy_image_view(texture.view, None);
        device.raw().destroy_image(texture.image, None);
    }
    if let Some(allocation) = texture.allocation.take() {
        device.free(allocation);
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        for texture in &mut self.textures {
            destroy(&self.device, texture);
        }
        // SAFETY: no frame in flight uses the set: the recorder keeps clones of the table.
        unsafe { self.device.raw().destroy_descriptor_pool(self.pool, None) };
    }
}
