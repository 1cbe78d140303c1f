//! Screen-space storage images. They always stay in GENERAL layout, so barriers only concern memory.

use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::{Error, Result, VkContext};
use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use half::f16;
use pt_shaders::channels::Format;
use std::sync::{Arc, Mutex};

/// The Vulkan format of a channel format.
pub(crate) const fn vk_format(format: Format) -> vk::Format {
    match format {
        Format::R32F => vk::Format::R32_SFLOAT,
        Format::Rg32F => vk::Format::R32G32_SFLOAT,
        Format::Rgba32F => vk::Format::R32G32B32A32_SFLOAT,
        Format::Rgba16F => vk::Format::R16G16B16A16_SFLOAT,
        Format::Rg16Unorm => vk::Format::R16G16_UNORM,
        Format::Rgba16Unorm => vk::Format::R16G16B16A16_UNORM,
        Format::Rg8Unorm => vk::Format::R8G8_UNORM,
        Format::Rgba8Unorm | Format::Rgba8Root => vk::Format::R8G8B8A8_UNORM,
        Format::R32Uint => vk::Format::R32_UINT,
        Format::Rg32Uint => vk::Format::R32G32_UINT,
        Format::Rgba32Uint => vk::Format::R32G32B32A32_UINT,
        Format::R16Uint => vk::Format::R16_UINT,
    }
}

/// A two-dimensional storage image; clones share it. Born zeroed.
#[derive(Clone)]
pub struct Image(Arc<Inner>);

struct Inner {
    device: Device,
    id: u64,
    name: String,
    handle: vk::Image,
    view: vk::ImageView,
    format: Format,
    extent: [u32; 2],
    allocation: Mutex<Option<Allocation>>,
}

pub(crate) const COLOR_RANGE: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: vk::REMAINING_MIP_LEVELS,
    base_array_layer: 0,
    layer_count: 1,
};

/// Creates an image with memory and view.
pub(crate) fn create_raw(
    device: &Device,
    name: &str,
    format: vk::Format,
    extent: [u32; 2],
    mips: u32,
    usage: vk::ImageUsageFlags,
) -> Result<(vk::Image, vk::ImageView, Allocation)> {
    let limit = device.info().capabilities.max_image_side;
    if extent.iter().any(|&side| side == 0 || side > limit) {
        return Err(Error::Unsupported(format!(
            "{name}: an image of {}x{} is not possible; sides must be 1 to {limit}",
            extent[0], extent[1]
        )));
    }
    let raw = device.raw();
    let info = vk::ImageCreateInfo::default()
        .image_type(vk::ImageType::TYPE_2D)
        .format(format)
        .extent(vk::Extent3D { width: extent[0], height: extent[1], depth: 1 })
        .mip_levels(mips)
        .array_layers(1)
        .samples(vk::SampleCountFlags::TYPE_1)
        .tiling(vk::ImageTiling::OPTIMAL)
        .usage(usage);
    // SAFETY: valid create info within the device's limits.
    let handle = unsafe { raw.create_image(&info, None) }.context("vkCreateImage")?;
    // SAFETY: `handle` was created above.
    let requirements = unsafe { raw.get_image_memory_requirements(handle) };
    let allocation = match device.allocate(&AllocationCreateDesc {
        name,
        requirements,
        location: MemoryLocation::GpuOnly,
        linear: false,
        allocation_scheme: AllocationScheme::GpuAllocatorManaged,
    }) {
        Ok(allocation) => allocation,
        Err(error) => {
            // SAFETY: never bound or used.
            unsafe { raw.destroy_image(handle, None) };
            return Err(error);
        }
    };
    let view_info = vk::ImageViewCreateInfo::default()
        .image(handle)
        .view_type(vk::ImageViewType::TYPE_2D)
        .format(format)
        .subresource_range(COLOR_RANGE);
    // SAFETY: memory and offset come from the allocator for exactly these requirements.
    let view = unsafe {
        raw.bind_image_memory(handle, allocation.memory(), allocation.offset())
            .context("vkBindImageMemory")?;
        raw.create_image_view(&view_info, None).context("vkCreateImageView")?
    };
    device.name(handle, name);
    Ok((handle, view, allocation))
}

/// Layout transition with full ordering, for set-up.
pub(crate) fn transition(
    device: &Device,
    cmd: vk::CommandBuffer,
    image: vk::Image,
    from: vk::ImageLayout,
    to: vk::ImageLayout,
) {
    let barrier = [vk::ImageMemoryBarrier2::default()
        .image(image)
        .subresource_range(COLOR_RANGE)
        .old_layout(from)
        .new_layout(to)
        .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
        .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)];
    // SAFETY: the command buffer is recording, the image is alive.
    unsafe {
        device
            .raw()
            .cmd_pipeline_barrier2(cmd, &vk::DependencyInfo::default().image_memory_barriers(&barrier))
    };
}

impl Image {
    /// An image of zeros.
    pub fn new(device: &Device, name: &str, format: Format, extent: [u32; 2]) -> Result<Self> {
        let usage = vk::ImageUsageFlags::STORAGE
            | vk::ImageUsageFlags::SAMPLED
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST;
        let (handle, view, allocation) = create_raw(device, name, vk_format(format), extent, 1, usage)?;
        let image = Self(Arc::new(Inner {
            device: device.clone(),
            id: device.next_id(),
            name: name.to_owned(),
            handle,
            view,
            format,
            extent,
            allocation: Mutex::new(Some(allocation)),
        }));
        device.submit_once(|cmd| {
            transition(device, cmd, handle, vk::ImageLayout::UNDEFINED, vk::ImageLayout::GENERAL);
            let zero = vk::ClearColorValue { uint32: [0; 4] };
            // SAFETY: recording, alive, in GENERAL layout.
            unsafe {
                device.raw().cmd_clear_color_image(
                    cmd,
                    handle,
                    vk::ImageLayout::GENERAL,
                    &zero,
                    &[COLOR_RANGE],
                );
            }
        })?;
        Ok(image)
    }

    /// Texel format.
    pub fn format(&self) -> Format {
        self.0.format
    }

    /// Width and height.
    pub fn extent(&self) -> [u32; 2] {
        self.0.extent
    }

    /// Debug name.
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// Size in bytes of the texels.
    pub fn bytes(&self) -> u64 {
        u64::from(self.0.extent[0]) * u64::from(self.0.extent[1]) * u64::from(self.0.format.bytes())
    }

    /// Copies the texels to the host, after everything submitted so far.
    pub fn read(&self) -> Result<Vec<u8>> {
        self.read_part(self.whole_copy(), self.bytes())
    }

    /// Copies one texel to the host, after everything submitted so far.
    ///
    /// # Panics
    /// Where there is no texel.
    pub fn read_texel(&self, at: [u32; 2]) -> Result<Vec<u8>> {
        let [width, height] = self.extent();
        assert!(at[0] < width && at[1] < height, "{}: no texel {at:?} in {width}x{height}", self.name());
        let offset = vk::Offset3D { x: at[0] as i32, y: at[1] as i32, z: 0 };
        let part = vk::BufferImageCopy { image_offset: offset, ..copy_region(0, 0, [1, 1]) };
        self.read_part(part, self.0.format.bytes().into())
    }

    fn read_part(&self, part: vk::BufferImageCopy, bytes: u64) -> Result<Vec<u8>> {
        let device = &self.0.device;
        let staging = Buffer::new(device, "read-back", bytes, Location::Readback)?;
        // SAFETY: image and buffer are alive until the wait inside submit_once is over.
        device.submit_once(|cmd| unsafe {
            device.raw().cmd_copy_image_to_buffer(
                cmd,
                self.0.handle,
                vk::ImageLayout::GENERAL,
                staging.handle(),
                &[part],
            );
        })?;
        Ok(staging.mapped())
    }

    /// Texels as floats, `components()` per texel, in scan-line order. Integers are converted by value: exact up to 2^24.
    pub fn read_f32(&self) -> Result<Vec<f32>> {
        Ok(decode_f32(self.0.format, &self.read()?))
    }

    /// Texels as unsigned integers, for the integer formats.
    pub fn read_u32(&self) -> Result<Vec<u32>> {
        decode_u32(self.0.format, &self.read()?).ok_or_else(|| self.no_integers(self.0.format))
    }

    fn no_integers(&self, format: Format) -> Error {
        Error::Unsupported(format!("{}: {format:?} texels are no integers", self.0.name))
    }

    /// Inverse of [`Image::read_f32`]. Normalised formats clamp to 0..1 and round to nearest, integers clamp to their
    /// range and truncate; NaN gives 0 there.
    ///
    /// # Errors
    /// When there are not `components()` values per texel, or the device fails.
    pub fn write_f32(&self, values: &[f32]) -> Result<()> {
        self.write(&encode_f32(self.0.format, values))
    }

    /// Inverse of [`Image::read_u32`], for the integer formats. Values above the format's range become its largest.
    ///
    /// # Errors
    /// If there are not `components()` values per texel, the texels are not integers, or the device fails.
    pub fn write_u32(&self, values: &[u32]) -> Result<()> {
        match self.0.format {
            Format::R16Uint => {
                let clamped = values.iter().map(|&v| v.min(u16::MAX.into()) as u16);
                self.write(&clamped.flat_map(u16::to_le_bytes).collect::<Vec<_>>())
            }
            Format::R32Uint | Format::Rg32Uint | Format::Rgba32Uint => {
                self.write(bytemuck::cast_slice(values))
            }
            other => Err(self.no_integers(other)),
        }
    }

    /// Replaces the texels (same layout as [`Image::read`]) and waits: for recorded inputs and tests.
    pub fn write(&self, texels: &[u8]) -> Result<()> {
        if texels.len() as u64 != self.bytes() {
            return Err(Error::Unsupported(format!(
                "{}: {} bytes given for an image of {} bytes",
                self.0.name,
                texels.len(),
                self.bytes()
            )));
        }
        let device = &self.0.device;
        let staging = Buffer::new(device, "staging", self.bytes(), Location::Upload)?;
        staging.write(0, texels);
        // SAFETY: image and buffer are alive until the wait inside submit_once is over.
        device.submit_once(|cmd| unsafe {
            device.raw().cmd_copy_buffer_to_image(
                cmd,
                staging.handle(),
                self.0.handle,
                vk::ImageLayout::GENERAL,
                &[self.whole_copy()],
            );
        })
    }

    fn whole_copy(&self) -> vk::BufferImageCopy {
        copy_region(0, 0, self.0.extent)
    }

    pub(crate) fn handle(&self) -> vk::Image {
        self.0.handle
    }

    pub(crate) fn view(&self) -> vk::ImageView {
        self.0.view
    }

    pub(crate) fn id(&self) -> u64 {
        self.0.id
    }
}

/// Values of texels as floats; see [`Image::read_f32`].
pub(crate) fn decode_f32(format: Format, bytes: &[u8]) -> Vec<f32> {
    let u16s = |scale: f32| {
        bytes.chunks_exact(2).map(|b| f32::from(u16::from_le_bytes([b[0], b[1]])) * scale).collect()
    };
    match format {
        Format::R32F | Format::Rg32F | Format::Rgba32F => {
            bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect()
        }
        Format::Rgba16F => bytes.chunks_exact(2).map(|b| f16::from_le_bytes([b[0], b[1]]).to_f32()).collect(),
        Format::Rg16Unorm | Format::Rgba16Unorm => u16s(1.0 / 65535.0),
        Format::R16Uint => u16s(1.0),
        Format::Rg8Unorm | Format::Rgba8Unorm => bytes.iter().map(|&b| f32::from(b) / 255.0).collect(),
        Format::Rgba8Root => bytes.iter().map(|&b| (f32::from(b) / 255.0).powi(2)).collect(),
        Format::R32Uint | Format::Rg32Uint | Format::Rgba32Uint => {
            bytes.chunks_exact(4).map(|b| bytemuck::pod_read_unaligned::<u32>(b) as f32).collect()
        }
    }
}

/// Values of texels as integers; `None` if they are none.
pub(crate) fn decode_u32(format: Format, bytes: &[u8]) -> Option<Vec<u32>> {
    match format {
        Format::R16Uint => {
            Some(bytes.chunks_exact(2).map(|b| u32::from(u16::from_le_bytes([b[0], b[1]]))).collect())
        }
        Format::R32Uint | Format::Rg32Uint | Format::Rgba32Uint => {
            Some(bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect())
        }
        _ => None,
    }
}

/// Bytes of texels from values, `format.components()` per texel.
fn encode_f32(format: Format, values: &[f32]) -> Vec<u8> {
    let unorm = |max: f32| move |v: &f32| (v.clamp(0.0, 1.0) * max).round();
    match format {
        Format::R32F | Format::Rg32F | Format::Rgba32F => bytemuck::cast_slice(values).to_vec(),
        Format::Rgba16F => values.iter().flat_map(|&v| f16::from_f32(v).to_le_bytes()).collect(),
        Format::Rg16Unorm | Format::Rgba16Unorm => {
            values.iter().map(unorm(65535.0)).flat_map(|v| (v as u16).to_le_bytes()).collect()
        }
        Format::Rg8Unorm | Format::Rgba8Unorm => values.iter().map(unorm(255.0)).map(|v| v as u8).collect(),
        Format::Rgba8Root => {
            values.iter().map(|v| v.max(0.0).sqrt()).map(|v| unorm(255.0)(&v) as u8).collect()
        }
        Format::R32Uint | Format::Rg32Uint | Format::Rgba32Uint => {
            values.iter().flat_map(|&v| (v as u32).to_le_bytes()).collect()
        }
        Format::R16Uint => values.iter().flat_map(|&v| (v as u16).to_le_bytes()).collect(),
    }
}

/// Copy of one whole mip level, tightly packed at `offset`.
pub(crate) fn copy_region(offset: u64, mip: u32, extent: [u32; 2]) -> vk::BufferImageCopy {
    vk::BufferImageCopy {
        buffer_offset: offset,
        image_subresource: vk::ImageSubresourceLayers {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            mip_level: mip,
            base_array_layer: 0,
            layer_count: 1,
        },
        image_extent: vk::Extent3D { width: extent[0], height: extent[1], depth: 1 },
        ..Default::default()
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        // SAFETY: the frame recorder keeps clones of what is in flight, so the device no longer uses the image.
        unsafe {
            self.device.raw().destroy_image_view(self.view, None);
            self.device.raw().destroy_image(self.handle, None);
        }
        if let Some(allocation) = crate::lock::lock(&self.allocation).take() {
            self.device.free(allocation);
        }
    }
}
