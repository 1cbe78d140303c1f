//! Pictures and panels that are drawn for nobody: what the panel costs, on a device that shows nothing.

use crate::blit::Blit;
use crate::drawing::{Drawing, Target, WHOLE};
use crate::error::{Call, Error, Result};
use crate::panel_renderer::LaidOut;
use ash::vk;
use pt_core::Device;

/// Format of the pictures.
const FORMAT: vk::Format = vk::Format::R8G8B8A8_UNORM;

/// An image in place of a window.
pub struct Offscreen {
    device: Device,
    drawing: Drawing,
    target: Target,
    memory: vk::DeviceMemory,
}

impl Offscreen {
    /// Of `size` pixels.
    ///
    /// # Errors
    /// A device that can't draw, or fails.
    pub fn new(device: &Device, size: [u32; 2]) -> Result<Self> {
        if !device.info().capabilities.draws {
            return Err(Error::Panel(format!("{} has no graphics queue", device.info().name)));
        }
        let drawing = Drawing::new(device, FORMAT)?;
        let extent = vk::Extent2D { width: size[0], height: size[1] };
        let none = Target {
            image: vk::Image::null(),
            view: vk::ImageView::null(),
            extent,
            layout: vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL,
        };
        // From here on Drop frees what is made.
        let mut made =
            Self { device: device.clone(), drawing, target: none, memory: vk::DeviceMemory::null() };
        made.make_image()?;
        Ok(made)
    }

    fn make_image(&mut self) -> Result<()> {
        let vulkan = self.device.vulkan();
        let raw = vulkan.device;
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(FORMAT)
            .extent(self.target.extent.into())
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_DST);
        // SAFETY: valid device and create infos; the image is bound before it has a view.
        unsafe {
            self.target.image = raw.create_image(&info, None).call("vkCreateImage")?;
            let needs = raw.get_image_memory_requirements(self.target.image);
            let types = vulkan.instance.get_physical_device_memory_properties(vulkan.physical);
            let fits = |&(index, of): &(u32, &vk::MemoryType)| {
                needs.memory_type_bits >> index & 1 == 1
                    && of.property_flags.contains(vk::MemoryPropertyFlags::DEVICE_LOCAL)
            };
            let (index, _) = (0u32..)
                .zip(types.memory_types_as_slice())
                .find(fits)
                .ok_or(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY)
                .call("vkGetImageMemoryRequirements")?;
            let allocate =
                vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(index);
            self.memory = raw.allocate_memory(&allocate, None).call("vkAllocateMemory")?;
            raw.bind_image_memory(self.target.image, self.memory, 0).call("vkBindImageMemory")?;
            let view = vk::ImageViewCreateInfo::default()
                .image(self.target.image)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(FORMAT)
                .subresource_range(WHOLE);
            self.target.view = raw.create_image_view(&view, None).call("vkCreateImageView")?;
        }
        Ok(())
    }

    /// Whether a picture could be drawn now: the last one is done.
    ///
    /// # Errors
    /// When the device fails.
    pub fn is_free(&mut self) -> Result<bool> {
        self.drawing.is_free()
    }

    /// Draws parts of pictures and, over them, a panel, if the last picture is done; whether it was.
    ///
    /// # Errors
    /// When the device fails.
    pub fn draw(&mut self, blits: &[Blit], panel: Option<&mut LaidOut>) -> Result<bool> {
        if !self.is_free()? {
            return Ok(false);
        }
        let mut panel = panel;
        if let Some(panel) = &mut panel {
            self.drawing.prepare(panel)?;
        }
        self.drawing.draw(self.target, blits, panel.as_deref(), &[], &[], |_| ())?;
        Ok(true)
    }

    /// GPU time of the last panel in milliseconds; `None` before the second picture.
    pub fn panel_ms(&self) -> Option<f64> {
        self.drawing.panel_ms()
    }
}

impl Drop for Offscreen {
    fn drop(&mut self) {
        if let Err(error) = self.device.wait_idle() {
            eprintln!("warning: waiting for the device failed: {error}");
        }
        let raw = self.device.vulkan().device;
        // SAFETY: the queue is idle, and nothing else uses the objects; null handles are ignored.
        unsafe {
            raw.destroy_image_view(self.target.view, None);
            raw.destroy_image(self.target.image, None);
            raw.free_memory(self.memory, None);
        }
    }
}
