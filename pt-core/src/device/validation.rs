//! The validation layers' messages, collected so that a test can fail on any.

use crate::error::{Result, VkContext};
use ash::{ext, vk};
use std::ffi::{CStr, c_void};
use std::sync::Mutex;

pub(super) const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// Warnings and errors of the validation layers since the device was opened.
#[derive(Default)]
pub struct ValidationLog(Mutex<Vec<String>>);

impl ValidationLog {
    /// All messages so far.
    pub fn messages(&self) -> Vec<String> {
        super::lock(&self.0).clone()
    }
}

pub(super) fn layer_available(entry: &ash::Entry) -> bool {
    // SAFETY: no preconditions.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }.unwrap_or_default();
    layers.iter().any(|l| l.layer_name_as_c_str() == Ok(LAYER))
}

pub(super) struct Messenger {
    utils: ext::debug_utils::Instance,
    handle: vk::DebugUtilsMessengerEXT,
    // Boxed: the layers hold its address.
    log: Box<ValidationLog>,
}

impl Messenger {
    pub(super) fn new(entry: &ash::Entry, instance: &ash::Instance) -> Result<Self> {
        let utils = ext::debug_utils::Instance::new(entry, instance);
        let log = Box::<ValidationLog>::default();
        let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(
                vk::DebugUtilsMessageSeverityFlagsEXT::WARNING | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
            )
            // Not PERFORMANCE: it advises against GENERAL layout, which is a decision here.
            .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
            .pfn_user_callback(Some(callback))
            .user_data((&raw const *log).cast_mut().cast());
        // SAFETY: the log outlives the messenger (dropped after it below).
        let handle = unsafe { utils.create_debug_utils_messenger(&info, None) }
            .context("vkCreateDebugUtilsMessengerEXT")?;
        Ok(Self { utils, handle, log })
    }

    pub(super) fn log(&self) -> &ValidationLog {
        &self.log
    }
}

impl Drop for Messenger {
    fn drop(&mut self) {
        // SAFETY: created from this instance, which is still alive.
        unsafe { self.utils.destroy_debug_utils_messenger(self.handle, None) };
    }
}

unsafe extern "system" fn callback(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layers pass valid data; `user` is the boxed log of `Messenger`.
    let (data, log) = unsafe { (&*data, &*user.cast_const().cast::<ValidationLog>()) };
    // SAFETY: a NUL-terminated string that lives during the call.
    let message =
        unsafe { data.message_as_c_str() }.map_or("(no text)".into(), |m| m.to_string_lossy().into_owned());
    eprintln!("validation: {message}");
    super::lock(&log.0).push(message);
    vk::FALSE
}
