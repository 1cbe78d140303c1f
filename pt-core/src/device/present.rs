//! The seam to a window: a device that can present, and the handles that a swapchain needs.

use super::{Device, DeviceOptions};
use crate::error::{Error, Result, VkContext};
use crate::lock::lock;
use ash::{khr, vk};
use std::ffi::CStr;

/// The handles below a device. They are valid as long as it is.
#[derive(Clone, Copy)]
pub struct Vulkan<'a> {
    /// The loader.
    pub entry: &'a ash::Entry,
    /// The instance.
    pub instance: &'a ash::Instance,
    /// The physical device.
    pub physical: vk::PhysicalDevice,
    /// The logical device.
    pub device: &'a ash::Device,
    /// Family of the one queue.
    pub queue_family: u32,
}

impl Device {
    /// Opens a device as [`Device::open`] does, with `VK_KHR_swapchain` and the instance extensions that `surfaces` need.
    ///
    /// # Errors
    /// [`Error::NoPresentation`] where the drivers lack one of them; else those of [`Device::open`].
    pub fn open_presenting(options: &DeviceOptions, surfaces: &[&CStr]) -> Result<Self> {
        Self::open_with(options, surfaces)
    }

    /// The handles below it.
    pub fn vulkan(&self) -> Vulkan<'_> {
        let inner = self.inner();
        Vulkan {
            entry: &inner.instance.entry,
            instance: &inner.instance.raw,
            physical: inner.physical,
            device: &inner.raw,
            queue_family: inner.queue_family,
        }
    }

    /// Gives the one queue to `work`; nobody else uses it meanwhile.
    pub fn with_queue<T>(&self, work: impl FnOnce(vk::Queue) -> T) -> T {
        work(*lock(&self.inner().queue))
    }
}

/// Checks that the device called `name` can show images and, if it `draws`, a panel over them.
pub(super) fn check(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    name: &str,
    draws: bool,
) -> Result<()> {
    let lacks = |what: &str| Err(Error::NoPresentation(format!("{name} lacks {what}")));
    // SAFETY: valid handles.
    let extensions = unsafe { instance.enumerate_device_extension_properties(physical) }
        .context("vkEnumerateDeviceExtensionProperties")?;
    if !extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(khr::swapchain::NAME)) {
        return lacks("VK_KHR_swapchain");
    }
    if draws { Ok(()) } else { lacks("dynamic rendering or a graphics queue") }
}
