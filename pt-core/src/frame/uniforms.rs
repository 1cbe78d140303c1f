//! Typed uniform buffers.

use super::recorder::Frame;
use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::Result;
use pt_shaders::GpuStruct;
use std::marker::PhantomData;

/// A device-local uniform buffer that holds one record, rewritten in frame order.
pub struct Uniforms<T> {
    buffer: Buffer,
    record: PhantomData<T>,
}

impl<T: GpuStruct> Uniforms<T> {
    /// Undefined until the first upload.
    pub fn new(device: &Device, name: &str) -> Result<Self> {
        let buffer = Buffer::new(device, name, size_of::<T>() as u64, Location::Device)?;
        Ok(Self { buffer, record: PhantomData })
    }

    /// Sets the record for the passes that follow in this and later frames.
    pub fn upload(&self, frame: &mut Frame<'_>, record: &T) -> Result<()> {
        frame.upload(&self.buffer, bytemuck::bytes_of(record))
    }

    /// The buffer, to be bound with [`super::Pass::read`].
    pub fn buffer(&self) -> &Buffer {
        &self.buffer
    }
}
