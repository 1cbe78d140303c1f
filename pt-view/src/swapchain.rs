//! The images of a surface.

use crate::drawing::WHOLE;
use crate::error::{Call, Error, Result};
use ash::{khr, vk};
use pt_core::Device;

/// Images of a surface with their views, and for each a semaphore that says when it is drawn.
pub(crate) struct Swapchain {
    device: Device,
    loader: khr::swapchain::Device,
    pub(crate) handle: vk::SwapchainKHR,
    pub(crate) images: Vec<vk::Image>,
    pub(crate) views: Vec<vk::ImageView>,
    pub(crate) drawn: Vec<vk::Semaphore>,
    pub(crate) extent: vk::Extent2D,
}

/// Formats of the picture's own 8-bit codes: shown at its size, it keeps its bits.
const FORMATS: [vk::Format; 2] = [vk::Format::B8G8R8A8_UNORM, vk::Format::R8G8B8A8_UNORM];

/// The format of the swapchains of a surface.
///
/// # Errors
/// A surface that has none, or that the device can't present to.
pub(crate) fn surface_format(
    device: &Device,
    surfaces: &khr::surface::Instance,
    surface: vk::SurfaceKHR,
) -> Result<vk::Format> {
    let vulkan = device.vulkan();
    let lacks = |lacks| Error::NoPresentation { device: device.info().name.clone(), lacks };
    // SAFETY: the surface is of the device's instance.
    let (presents, formats) = unsafe {
        (
            surfaces
                .get_physical_device_surface_support(vulkan.physical, vulkan.queue_family, surface)
                .call("vkGetPhysicalDeviceSurfaceSupportKHR")?,
            surfaces.get_physical_device_surface_formats(vulkan.physical, surface),
        )
    };
    if !presents {
        return Err(lacks("its queue can't"));
    }
    let formats = formats.call("vkGetPhysicalDeviceSurfaceFormatsKHR")?;
    let is_there = |format: &vk::Format| {
        formats.iter().any(|f| f.format == *format && f.color_space == vk::ColorSpaceKHR::SRGB_NONLINEAR)
    };
    FORMATS.into_iter().find(is_there).ok_or_else(|| lacks("no 8-bit sRGB format"))
}

impl Swapchain {
    /// For a window of `size` pixels; takes the place of `old`. `None`: the surface has no area now.
    ///
    /// # Errors
    /// Vulkan's answer as it is, for [`crate::swapchain_rules`].
    pub(crate) fn new(
        device: &Device,
        surfaces: &khr::surface::Instance,
        surface: vk::SurfaceKHR,
        format: vk::Format,
        size: [u32; 2],
        old: Option<&Self>,
    ) -> std::result::Result<Option<Self>, vk::Result> {
        let vulkan = device.vulkan();
        let raw = vulkan.device;
        // SAFETY: the surface is of the device's instance.
        let can = unsafe { surfaces.get_physical_device_surface_capabilities(vulkan.physical, surface) }?;
        let Some(extent) = extent(&can, size) else { return Ok(None) };
        let most = if can.max_image_count == 0 { u32::MAX } else { can.max_image_count };
        let alpha = [vk::CompositeAlphaFlagsKHR::OPAQUE, vk::CompositeAlphaFlagsKHR::INHERIT];
        let alpha = alpha.into_iter().find(|alpha| can.supported_composite_alpha.contains(*alpha));
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(surface)
            .min_image_count((can.min_image_count + 1).min(most))
            .image_format(format)
            .image_color_space(vk::ColorSpaceKHR::SRGB_NONLINEAR)
            .image_extent(extent)
            .image_array_layers(1)
            .image_usage(vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_DST)
            .pre_transform(can.current_transform)
            .composite_alpha(alpha.unwrap_or(vk::CompositeAlphaFlagsKHR::OPAQUE))
            // The one mode that is always there.
            .present_mode(vk::PresentModeKHR::FIFO)
            .clipped(true)
            .old_swapchain(old.map_or(vk::SwapchainKHR::null(), |old| old.handle));
        let loader = khr::swapchain::Device::new(vulkan.instance, raw);
        // SAFETY: valid create info; the images are used only after they are acquired.
        let (handle, images) = unsafe {
            let handle = loader.create_swapchain(&info, None)?;
            (handle, loader.get_swapchain_images(handle)?)
        };
        let mut swapchain = Self {
            device: device.clone(),
            loader,
            handle,
            images,
            views: Vec::new(),
            drawn: Vec::new(),
            extent,
        };
        for &image in &swapchain.images {
            let view = vk::ImageViewCreateInfo::default()
                .image(image)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(format)
                .subresource_range(WHOLE);
            // SAFETY: the image belongs to the swapchain, which outlives the view.
            unsafe {
                swapchain.views.push(raw.create_image_view(&view, None)?);
                swapchain.drawn.push(raw.create_semaphore(&vk::SemaphoreCreateInfo::default(), None)?);
            }
        }
        Ok(Some(swapchain))
    }

    /// Asks for an image without waiting for one.
    pub(crate) fn acquire(&self, signal: vk::Semaphore) -> std::result::Result<(u32, bool), vk::Result> {
        // SAFETY: the semaphore is unsignalled, and nothing waits for it.
        unsafe { self.loader.acquire_next_image(self.handle, 0, signal, vk::Fence::null()) }
    }

    /// Hands a drawn image to the display; nobody else uses the queue meanwhile.
    pub(crate) fn present(&self, queue: vk::Queue, index: u32) -> std::result::Result<bool, vk::Result> {
        let (swapchains, indices) = ([self.handle], [index]);
        let wait = [self.drawn[index as usize]];
        let info = vk::PresentInfoKHR::default()
            .wait_semaphores(&wait)
            .swapchains(&swapchains)
            .image_indices(&indices);
        // SAFETY: the image was acquired, and the submission that draws it signals the semaphore.
        unsafe { self.loader.queue_present(queue, &info) }
    }
}
/// The size of the images: the surface's own where it has one, else the window's within its limits. `None` without an area.
fn extent(can: &vk::SurfaceCapabilitiesKHR, [width, height]: [u32; 2]) -> Option<vk::Extent2D> {
    let (least, most) = (can.min_image_extent, can.max_image_extent);
    // The surface leaves the size to its swapchains (Vulkan specification, VkSurfaceCapabilitiesKHR).
    let is_free = can.current_extent.width == u32::MAX;
    let extent = if is_free {
        let clamp = |side: u32, least: u32, most: u32| side.max(least).min(most);
        vk::Extent2D {
            width: clamp(width, least.width, most.width),
            height: clamp(height, least.height, most.height),
        }
    } else {
        can.current_extent
    };
    (extent.width > 0 && extent.height > 0).then_some(extent)
}

impl Drop for Swapchain {
    fn drop(&mut self) {
        // Images may still be on their way to the display.
        if let Err(error) = self.device.wait_idle() {
            eprintln!("warning: waiting for the device failed: {error}");
        }
        let raw = self.device.vulkan().device;
        // SAFETY: the queue is idle, so that nothing uses the objects.
        unsafe {
            self.views.iter().for_each(|&view| raw.destroy_image_view(view, None));
            self.drawn.iter().for_each(|&semaphore| raw.destroy_semaphore(semaphore, None));
            self.loader.destroy_swapchain(self.handle, None);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_have_the_size_of_the_surface_or_that_of_the_window_within_its_limits() {
        let e = |width, height| vk::Extent2D { width, height };
        let can = |current| vk::SurfaceCapabilitiesKHR {
            current_extent: current,
            min_image_extent: e(2, 2),
            max_image_extent: e(100, 50),
            ..Default::default()
        };
        assert_eq!(extent(&can(e(30, 20)), [9, 9]), Some(e(30, 20)));
        assert_eq!(extent(&can(e(u32::MAX, u32::MAX)), [200, 1]), Some(e(100, 2)));
        assert_eq!(extent(&can(e(0, 20)), [9, 9]), None, "minimised");
    }
}
