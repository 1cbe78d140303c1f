//! Tables that the passes of a stage hand on to each other.

use crate::buffer::{Buffer, Location};
use crate::channels::{ChannelImages, TableWish};
use crate::device::Device;
use crate::error::Result;
use std::collections::BTreeMap;

/// Finds tables in the memory of the frame, where its plan knows of them, and else makes them in memory of their own. Their content is undefined at the start of the
/// first stage that declares them.
pub struct TableMemory {
    device: Device,
    own: BTreeMap<&'static str, Buffer>,
}

impl TableMemory {
    /// Without tables yet.
    pub fn new(device: &Device) -> Self {
        Self { device: device.clone(), own: BTreeMap::new() }
    }

    /// Bytes of those tables that the frame has no memory for.
    pub fn own_bytes(&self, images: Option<&ChannelImages>, wishes: &[TableWish]) -> u64 {
        let has = |wish: &&TableWish| planned(images, wish).is_none();
        wishes.iter().filter(has).map(|wish| wish.bytes).sum()
    }

    /// A table. It may be another one in the next frame.
    ///
    /// # Errors
    /// When the device has no memory left.
    pub fn table(&mut self, images: Option<&ChannelImages>, wish: TableWish) -> Result<Buffer> {
        if let Some(table) = planned(images, &wish) {
            return Ok(table.clone());
        }
        let TableWish { name, bytes } = wish;
        if let Some(table) = self.own.get(name).filter(|table| table.size() == bytes.max(1)) {
            return Ok(table.clone());
        }
        let table = Buffer::new(&self.device, name, bytes, Location::Device)?;
        self.own.insert(name, table.clone());
        Ok(table)
    }
}

/// The table in the memory of the frame.
fn planned<'a>(images: Option<&'a ChannelImages>, wish: &TableWish) -> Option<&'a Buffer> {
    images.and_then(|images| images.table(wish.name)).filter(|table| table.size() >= wish.bytes)
}
