//! Memory for tables that live within a stage.

use crate::buffer::{Buffer, Location, PART_ALIGNMENT};
use crate::channels::ChannelImages;
use crate::device::Device;
use crate::error::Result;

/// Makes the tables that the passes of a stage hand on to each other: in the memory that the stages of a frame use in turn
/// ([`ChannelImages::table_memory`]), or, where it is not there or too small, in memory of their own. Their content is undefined at the start of
/// the stage.
pub struct TableMemory {
    device: Device,
    shared: Option<Buffer>,
    used: u64,
}

impl TableMemory {
    /// Room for `tables` tables that take `bytes` together.
    pub const fn room(bytes: u64, tables: u64) -> u64 {
        bytes + tables * PART_ALIGNMENT
    }

    /// The memory of the frame that has these images.
    pub fn of(device: &Device, images: &ChannelImages) -> Self {
        Self { device: device.clone(), shared: images.table_memory().cloned(), used: 0 }
    }

    /// Memory of their own for all tables.
    pub fn own(device: &Device) -> Self {
        Self { device: device.clone(), shared: None, used: 0 }
    }

    /// The next table.
    ///
    /// # Errors
    /// When the device has no memory left.
    pub fn table(&mut self, name: &str, bytes: u64) -> Result<Buffer> {
        let bytes = bytes.max(1);
        if let Some(shared) = &self.shared
            && let Some(part) = shared.part(name, self.used, bytes)?
        {
            self.used += bytes.next_multiple_of(PART_ALIGNMENT);
            return Ok(part);
        }
        Buffer::new(&self.device, name, bytes, Location::Device)
    }

    /// Whether tables that were made with `other` are where those of this one would be.
    pub fn is_that_of(&self, other: &Self) -> bool {
        self.shared.as_ref().map(Buffer::id) == other.shared.as_ref().map(Buffer::id)
    }
}
