//! Support for the tests of all crates: statistics, and a device with validation enabled whose messages fail the test.

pub mod statistics;

use crate::channels::ChannelImages;
use crate::device::{Device, DeviceOptions};
use crate::plan::FramePlan;
use crate::sizes::FrameSizes;
use pt_shaders::channels::ChannelId;

/// A device opened with validation and synchronization validation. Dropping it panics if the layers said anything.
pub struct TestDevice {
    device: Device,
}

impl TestDevice {
    /// Opens the device named by the environment variable `PT_TEST_DEVICE`, or the best one.
    ///
    /// # Panics
    /// When there is none, or no validation layer: the tests are worth nothing without.
    pub fn open() -> Self {
        let device = std::env::var("PT_TEST_DEVICE").ok();
        let device =
            Device::open(&DeviceOptions { device, validation: true }).unwrap_or_else(|e| panic!("{e}"));
        Self { device }
    }
}

impl std::ops::Deref for TestDevice {
    type Target = Device;
    fn deref(&self) -> &Device {
        &self.device
    }
}

impl Drop for TestDevice {
    fn drop(&mut self) {
        let messages = self.device.validation().map(|log| log.messages()).unwrap_or_default();
        if !std::thread::panicking() {
            assert!(messages.is_empty(), "the validation layers said:\n{}", messages.join("\n"));
        }
    }
}

/// Images of a frame of `size` that nobody has to write first.
///
/// # Panics
/// When the device has not the memory.
pub fn channel_images(
    device: &Device,
    size: [u32; 2],
    ids: impl IntoIterator<Item = ChannelId>,
) -> ChannelImages {
    let mut plan = FramePlan::new(FrameSizes::same(size));
    plan.given(ids);
    plan.allocate(device).expect("the images of a test fit into memory")
}
