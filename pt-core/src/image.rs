//! Screen-space storage images. They always stay in GENERAL layout, so barriers only concern memory.

use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::{Error, Result, VkContext};
use crate::layout::image_bytes;
use crate::texels::{decode_f32, decode_u32, encode_f32};
use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use pt_shaders::channels::Format;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
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
    /// As the last frame's.
    previous_name: String,
    is_previous: AtomicBool,
    handle: vk::Image,
    view: vk::ImageView,
    format: Format,
    extent: [u32; 2],
    allocation: Mutex<Option<Allocation>>,
    /// The image whose memory it is in, if it has none of its own.
    host: Option<Image>,
    /// The number of the image that was written last in this memory; 0: none yet.
    writer: AtomicU64,
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
    flags: vk::ImageCreateFlags,
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
        .usage(usage)
        .flags(flags);
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
    // SAFETY: memory and offset come from the allocator for exactly these requirements.
    unsafe { raw.bind_image_memory(handle, allocation.memory(), allocation.offset()) }
        .context("vkBindImageMemory")?;
    let view = create_view(device, handle, format)?;
    device.name(handle, name);
    Ok((handle, view, allocation))
}

fn create_view(device: &Device, image: vk::Image, format: vk::Format) -> Result<vk::ImageView> {
    let info = vk::ImageViewCreateInfo::default()
        .image(image)
        .view_type(vk::ImageViewType::TYPE_2D)
        .format(format)
        .subresource_range(COLOR_RANGE);
    // SAFETY: the image is bound to memory; a format that is not its own has as many bytes, and the image allows it.
    unsafe { device.raw().create_image_view(&info, None) }.context("vkCreateImageView")
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
        Self::with_flags(device, name, format, extent, vk::ImageCreateFlags::empty())
    }

    /// An image of zeros. `other_formats`: [`Image::sharing`] may ask for other formats than this one.
    pub(crate) fn shareable(
        device: &Device,
        name: &str,
        format: Format,
        extent: [u32; 2],
        other_formats: bool,
    ) -> Result<Self> {
        let flags = match other_formats {
            true => vk::ImageCreateFlags::MUTABLE_FORMAT,
            false => vk::ImageCreateFlags::empty(),
        };
        Self::with_flags(device, name, format, extent, flags)
    }

    fn with_flags(
        device: &Device,
        name: &str,
        format: Format,
        extent: [u32; 2],
        flags: vk::ImageCreateFlags,
    ) -> Result<Self> {
        let usage = vk::ImageUsageFlags::STORAGE
            | vk::ImageUsageFlags::SAMPLED
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST;
        let (handle, view, allocation) =
            create_raw(device, name, vk_format(format), extent, 1, usage, flags)?;
        let image = Self(Arc::new(Inner {
            device: device.clone(),
            id: device.next_id(),
            name: name.to_owned(),
            previous_name: format!("{name}_prev"),
            is_previous: AtomicBool::new(false),
            handle,
            view,
            format,
            extent,
            allocation: Mutex::new(Some(allocation)),
            host: None,
            writer: AtomicU64::new(0),
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

    /// An image in the memory of this one, with the same number of bytes a texel. Barriers take both for one.
    pub(crate) fn sharing(&self, name: &str, format: Format) -> Result<Self> {
        let device = &self.0.device;
        Ok(Self(Arc::new(Inner {
            device: device.clone(),
            id: device.next_id(),
            name: name.to_owned(),
            previous_name: format!("{name}_prev"),
            is_previous: AtomicBool::new(false),
            handle: self.0.handle,
            view: create_view(device, self.0.handle, vk_format(format))?,
            format,
            extent: self.0.extent,
            allocation: Mutex::new(None),
            host: Some(self.clone()),
            writer: AtomicU64::new(0),
        })))
    }

    /// The image that owns the memory.
    fn owner(&self) -> &Self {
        self.0.host.as_ref().unwrap_or(self)
    }

    /// Whether it has memory of its own.
    pub fn owns_memory(&self) -> bool {
        self.0.host.is_none()
    }

    /// A pass writes it: the content of other images in this memory is lost.
    pub(crate) fn note_written(&self) {
        self.owner().0.writer.store(self.0.id, Ordering::Relaxed);
    }

    /// Whether another image in this memory was written after it.
    pub(crate) fn is_overwritten(&self) -> bool {
        let writer = self.owner().0.writer.load(Ordering::Relaxed);
        writer != 0 && writer != self.0.id
    }

    /// Says whether it is the last frame's.
    pub(crate) fn set_previous(&self, is_previous: bool) {
        self.0.is_previous.store(is_previous, Ordering::Relaxed);
    }

    /// Texel format.
    pub fn format(&self) -> Format {
        self.0.format
    }

    /// Width and height.
    pub fn extent(&self) -> [u32; 2] {
        self.0.extent
    }

    /// Debug name; it ends in `_prev` while the image is the last frame's.
    pub fn name(&self) -> &str {
        if self.0.is_previous.load(Ordering::Relaxed) { &self.0.previous_name } else { &self.0.name }
    }

    /// Size in bytes of the texels.
    pub fn bytes(&self) -> u64 {
        image_bytes(self.0.extent, self.0.format)
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

    /// Its handle, for a copy into a swapchain. The layout is GENERAL.
    pub fn handle(&self) -> vk::Image {
        self.0.handle
    }

    pub(crate) fn view(&self) -> vk::ImageView {
        self.0.view
    }

    /// Number of its memory, for barriers.
    pub(crate) fn id(&self) -> u64 {
        self.owner().0.id
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
            if self.host.is_none() {
                self.device.raw().destroy_image(self.handle, None);
            }
        }
        if let Some(allocation) = crate::lock::lock(&self.allocation).take() {
            self.device.free(allocation);
        }
    }
}
