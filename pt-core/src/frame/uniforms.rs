//! Typed uniform buffers.

use super::recorder::Frame;
use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::Result;
use crate::lock::lock;
use pt_shaders::GpuStruct;
use std::sync::Mutex;

/// A device-local uniform buffer that holds one record, rewritten in frame order.
pub struct Uniforms<T> {
    buffer: Buffer,
    /// What it holds for the passes that are recorded next.
    record: Mutex<Option<T>>,
}

impl<T: GpuStruct> Uniforms<T> {
    /// Undefined until the first upload.
    pub fn new(device: &Device, name: &str) -> Result<Self> {
        let buffer = Buffer::new(device, name, size_of::<T>() as u64, Location::Device)?;
        Ok(Self { buffer, record: Mutex::new(None) })
    }

    /// Sets the record for the passes that follow in this and later frames.
    pub fn upload(&self, frame: &mut Frame<'_>, record: &T) -> Result<()> {
        frame.upload(&self.buffer, bytemuck::bytes_of(record))?;
        *lock(&self.record) = Some(*record);
        Ok(())
    }

    /// The record that was set last, for what passes get from it as push constants; `None` before the first one.
    pub fn record(&self) -> Option<T> {
        *lock(&self.record)
    }

    /// The buffer, to be bound with [`super::Pass::read`].
    pub fn buffer(&self) -> &Buffer {
        &self.buffer
    }
}
