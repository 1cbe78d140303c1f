//! Memory that images and tables of a frame share, and what is in it.

use crate::device::Device;
use crate::error::Result;
use crate::lock::lock;
use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use std::sync::{Arc, Mutex};

/// A piece of device memory; clones share it.
#[derive(Clone)]
pub(crate) struct Block(Arc<Inner>);

struct Inner {
    device: Device,
    allocation: Mutex<Option<Allocation>>,
    memory: vk::DeviceMemory,
    offset: u64,
    contents: Mutex<Vec<Content>>,
}

/// Which resource was written last in these bytes, by its number.
#[derive(Clone, Copy)]
struct Content {
    start: u64,
    end: u64,
    writer: u64,
}

impl Content {
    fn meets(&self, part: &Part) -> bool {
        self.start < part.end && part.start < self.end
    }
}

impl Block {
    /// Memory of these requirements.
    pub(crate) fn new(device: &Device, name: &str, requirements: vk::MemoryRequirements) -> Result<Self> {
        let allocation = device.allocate(&AllocationCreateDesc {
            name,
            requirements,
            location: MemoryLocation::GpuOnly,
            linear: false,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        })?;
        // SAFETY: the memory is used through what is bound to it only, which keeps the block.
        let memory = unsafe { allocation.memory() };
        let offset = allocation.offset();
        Ok(Self(Arc::new(Inner {
            device: device.clone(),
            allocation: Mutex::new(Some(allocation)),
            memory,
            offset,
            contents: Mutex::default(),
        })))
    }

    /// Bytes of it.
    pub(crate) fn part(&self, offset: u64, bytes: u64) -> Part {
        Part { block: self.clone(), start: offset, end: offset + bytes }
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        if let Some(allocation) = lock(&self.allocation).take() {
            self.device.free(allocation);
        }
    }
}

/// Bytes of a block that a resource is bound to.
#[derive(Clone)]
pub(crate) struct Part {
    block: Block,
    start: u64,
    end: u64,
}

impl Part {
    /// Memory and offset to bind to.
    pub(crate) fn memory(&self) -> (vk::DeviceMemory, u64) {
        (self.block.0.memory, self.block.0.offset + self.start)
    }

    /// Whether a byte is in both.
    pub(crate) fn meets(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.block.0, &other.block.0) && self.start < other.end && other.start < self.end
    }

    /// The resource with this number is written: returns those whose content is lost.
    pub(crate) fn note_written(&self, writer: u64) -> Vec<u64> {
        let mut contents = lock(&self.block.0.contents);
        let (met, mut left): (Vec<Content>, Vec<Content>) =
            contents.drain(..).partition(|content| content.meets(self));
        // What is beside it is still what that resource has left there, which whoever writes there must wait for.
        for content in &met {
            left.push(Content { end: content.end.min(self.start), ..*content });
            left.push(Content { start: content.start.max(self.end), ..*content });
        }
        left.retain(|content| content.start < content.end);
        left.push(Content { start: self.start, end: self.end, writer });
        *contents = left;
        met.into_iter().map(|content| content.writer).filter(|&other| other != writer).collect()
    }

    /// Whether another resource was written after the one with this number.
    pub(crate) fn is_overwritten(&self, writer: u64) -> bool {
        lock(&self.block.0.contents).iter().any(|content| content.meets(self) && content.writer != writer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::buffer::Buffer;
    use crate::test_support::TestDevice;

    #[test]
    fn who_writes_learns_whose_content_is_lost() {
        let device = TestDevice::open();
        let needs = Buffer::requirements(&device, 64);
        let block = Block::new(&device, "block", needs).unwrap();
        let [whole, start, end] = [block.part(0, 64), block.part(0, 16), block.part(48, 16)];
        assert!(whole.note_written(1).is_empty() && whole.note_written(1).is_empty());
        assert_eq!(start.note_written(2), [1]);
        assert!(whole.is_overwritten(1) && !start.is_overwritten(2));
        assert_eq!(end.note_written(3), [1], "the rest of the first one is still there");
        let mut lost = whole.note_written(4);
        lost.sort_unstable();
        assert_eq!(lost, [1, 2, 3]);
        assert!(start.meets(&whole) && !start.meets(&end));
    }
}
