//! Screen-space storage images. They always stay in GENERAL layout, so barriers only concern memory.

use crate::block::Part;
use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::{Error, Result, VkContext};
use crate::texels::{decode_f32, decode_u32, encode_f32};
use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use pt_shaders::channels::Format;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

/// The Vulkan format of a channel format.
pub(crate) const fn vk_format(format: Format) -> vk::Format {
    match format {
        Format::R32F => vk::Format::R32_SFLOAT,
        Format::Rg32F => vk::Format::R32G32_SFLOAT,
        Format::Rgba32F => vk::Format::R32G32B32A32_SFLOAT,
        Format::Rgba16F | Format::Half(_) => vk::Format::R16G16B16A16_SFLOAT,
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
    /// Its memory, if that is not its own.
    part: Option<Part>,
    /// Whether it may be bound although its content is lost.
    is_unread: AtomicBool,
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
    check_extent(device, name, extent)?;
    let raw = device.raw();
    let info = create_info(format, extent, mips, usage).flags(flags);
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

fn check_extent(device: &Device, name: &str, extent: [u32; 2]) -> Result<()> {
    let limit = device.info().capabilities.max_image_side;
    if extent.iter().any(|&side| side == 0 || side > limit) {
        return Err(Error::Unsupported(format!(
            "{name}: an image of {}x{} is not possible; sides must be 1 to {limit}",
            extent[0], extent[1]
        )));
    }
    Ok(())
}

fn create_info(
    format: vk::Format,
    extent: [u32; 2],
    mips: u32,
    usage: vk::ImageUsageFlags,
) -> vk::ImageCreateInfo<'static> {
    vk::ImageCreateInfo::default()
        .image_type(vk::ImageType::TYPE_2D)
        .format(format)
        .extent(vk::Extent3D { width: extent[0], height: extent[1], depth: 1 })
        .mip_levels(mips)
        .array_layers(1)
        .samples(vk::SampleCountFlags::TYPE_1)
        .tiling(vk::ImageTiling::OPTIMAL)
        .usage(usage)
}

/// How an [`Image`] may be used.
fn usage() -> vk::ImageUsageFlags {
    vk::ImageUsageFlags::STORAGE
        | vk::ImageUsageFlags::SAMPLED
        | vk::ImageUsageFlags::TRANSFER_SRC
        | vk::ImageUsageFlags::TRANSFER_DST
}

fn create_view(device: &Device, image: vk::Image, format: vk::Format) -> Result<vk::ImageView> {
    let info = vk::ImageViewCreateInfo::default()
        .image(image)
        .view_type(vk::ImageViewType::TYPE_2D)
        .format(format)
        .subresource_range(COLOR_RANGE);
    // SAFETY: the image is bound to memory, and the format is its own.
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
        let flags = vk::ImageCreateFlags::empty();
        let (handle, view, allocation) =
            create_raw(device, name, vk_format(format), extent, 1, usage(), flags)?;
        let image = Self::with(device, name, format, extent, (handle, view), Some(allocation), None);
        let one = std::slice::from_ref(&image);
        Self::prepare(device, one, one)?;
        Ok(image)
    }

    /// Memory that such an image needs.
    ///
    /// # Errors
    /// When the device has no such images.
    pub(crate) fn requirements(
        device: &Device,
        name: &str,
        format: Format,
        extent: [u32; 2],
    ) -> Result<vk::MemoryRequirements> {
        check_extent(device, name, extent)?;
        let info = create_info(vk_format(format), extent, 1, usage());
        let info = vk::DeviceImageMemoryRequirements::default().create_info(&info);
        let mut requirements = vk::MemoryRequirements2::default();
        // SAFETY: valid create info within the device's limits.
        unsafe { device.raw().get_device_image_memory_requirements(&info, &mut requirements) };
        Ok(requirements.memory_requirements)
    }

    /// An image in memory that others use too, of what [`Image::requirements`] says. It is undefined until [`Image::prepare`].
    pub(crate) fn placed(
        part: Part,
        device: &Device,
        name: &str,
        format: Format,
        extent: [u32; 2],
    ) -> Result<Self> {
        let info = create_info(vk_format(format), extent, 1, usage());
        // SAFETY: valid create info within the device's limits.
        let handle = unsafe { device.raw().create_image(&info, None) }.context("vkCreateImage")?;
        let (memory, offset) = part.memory();
        // The implementation wants to be asked before an image is bound.
        // SAFETY: `handle` was created above, and the part is as large as asked for.
        unsafe {
            let _ = device.raw().get_image_memory_requirements(handle);
            device.raw().bind_image_memory(handle, memory, offset).context("vkBindImageMemory")?;
        }
        let view = create_view(device, handle, vk_format(format))?;
        device.name(handle, name);
        Ok(Self::with(device, name, format, extent, (handle, view), None, Some(part)))
    }

    fn with(
        device: &Device,
        name: &str,
        format: Format,
        extent: [u32; 2],
        (handle, view): (vk::Image, vk::ImageView),
        allocation: Option<Allocation>,
        part: Option<Part>,
    ) -> Self {
        Self(Arc::new(Inner {
            device: device.clone(),
            id: device.next_id(),
            name: name.to_owned(),
            previous_name: format!("{name}_prev"),
            is_previous: AtomicBool::new(false),
            handle,
            view,
            format,
            extent,
            allocation: Mutex::new(allocation),
            part,
            is_unread: AtomicBool::new(false),
        }))
    }

    /// Gives new images their layout, and those of `zeros` zeros.
    pub(crate) fn prepare(device: &Device, images: &[Self], zeros: &[Self]) -> Result<()> {
        device.submit_once(|cmd| {
            for image in images {
                transition(device, cmd, image.0.handle, vk::ImageLayout::UNDEFINED, vk::ImageLayout::GENERAL);
            }
            for image in zeros {
                let zero = vk::ClearColorValue { uint32: [0; 4] };
                let layout = vk::ImageLayout::GENERAL;
                // SAFETY: recording, alive, in GENERAL layout.
                unsafe {
                    device.raw().cmd_clear_color_image(cmd, image.0.handle, layout, &zero, &[COLOR_RANGE]);
                }
            }
        })
    }

    /// Its memory, if others use that too.
    pub(crate) fn part(&self) -> Option<&Part> {
        self.0.part.as_ref()
    }

    /// A pass writes it: returns the numbers of the resources in this memory whose content is lost.
    pub(crate) fn note_written(&self) -> Vec<u64> {
        self.part().map_or_else(Vec::new, |part| part.note_written(self.0.id))
    }

    /// Whether another resource in this memory was written after it, and what it holds is asked for.
    pub(crate) fn is_overwritten(&self) -> bool {
        !self.is_unread() && self.part().is_some_and(|part| part.is_overwritten(self.0.id))
    }

    /// Whether nobody reads what it holds, although it may be bound.
    pub(crate) fn is_unread(&self) -> bool {
        self.0.is_unread.load(Ordering::Relaxed)
    }

    /// Says whether nobody reads what it holds, although it may be bound.
    pub(crate) fn set_unread(&self, is_unread: bool) {
        self.0.is_unread.store(is_unread, Ordering::Relaxed);
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
        self.0.extent.map(u64::from).iter().product::<u64>() * u64::from(self.0.format.bytes())
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

    /// Its number, for barriers.
    pub(crate) fn id(&self) -> u64 {
        self.0.id
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
