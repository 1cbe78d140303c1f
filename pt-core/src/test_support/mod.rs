//! Support for the tests of all crates: statistics, and a device with validation enabled whose messages fail the test.

pub mod statistics;

use crate::capture::folder::{CaptureWriter, Index};
use crate::capture::sidecar::Sidecar;
use crate::channels::ChannelImages;
use crate::device::{Device, DeviceOptions};
use crate::lock::lock;
use crate::plan::FramePlan;
use crate::sizes::FrameSizes;
use pt_shaders::channels::ChannelId;
use pt_shaders::records::CameraRecord;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use std::sync::Mutex;

/// A device opened with validation and synchronization validation. Dropping it panics if the layers said anything.
///
/// The next test of the same program that opens one gets the same device, with the kernels that are compiled already: much of the time of a
/// short test goes into its kernels. No two tests have it at a time.
pub struct TestDevice {
    device: Device,
}

/// Devices that no test has.
static IDLE: Mutex<Vec<Device>> = Mutex::new(Vec::new());

impl TestDevice {
    /// Opens the device named by the environment variable `PT_TEST_DEVICE`, or the best one.
    ///
    /// # Panics
    /// When there is none, or no validation layer: the tests are worth nothing without.
    pub fn open() -> Self {
        if let Some(device) = lock(&IDLE).pop() {
            return Self { device };
        }
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
            lock(&IDLE).push(self.device.clone());
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

/// Records the images as the frames of a folder, as `pt capture` does; 1/8 of a second lies between frames.
///
/// # Panics
/// When they can't be recorded.
pub fn record_folder(folder: &Path, images: &ChannelImages, frames: Range<u32>) {
    let index = Index {
        version: env!("CARGO_PKG_VERSION").into(),
        scene: "test".into(),
        output_size: images.output_size(),
        accumulate: false,
        frames: Vec::new(),
    };
    let mut writer = CaptureWriter::create(folder, index).unwrap();
    let first = frames.start;
    for frame in frames {
        let camera: CameraRecord = bytemuck::Zeroable::zeroed();
        let sidecar = Sidecar {
            version: env!("CARGO_PKG_VERSION").into(),
            frame,
            time: 0.0,
            size: images.size(),
            seed: 0,
            jitter: [0.0; 2],
            time_step: Some(0.125),
            camera: (&camera).into(),
            camera_previous: (&camera).into(),
            params: serde_json::Value::Null,
            device: String::new(),
            driver: String::new(),
            backend: String::new(),
            has_history: frame > first,
            histories: Vec::new(),
            state: BTreeMap::new(),
        };
        writer.add(images, Vec::new(), &sidecar, None).unwrap();
    }
}
