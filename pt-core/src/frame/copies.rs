//! Copies by the driver, as passes.

use super::hazards::Touch;
use super::recorder::Frame;
use super::resource::{Keep, PassInfo};
use crate::buffer::Buffer;
use crate::error::Result;
use crate::image::Image;
use ash::vk;

impl Frame<'_> {
    /// The driver's copy of a buffer to another of the same size.
    pub(crate) fn copy_buffer(&mut self, name: &str, from: &Buffer, to: &Buffer) -> Result<()> {
        let region = [vk::BufferCopy::default().size(from.size())];
        let info = copy_info(name, from.size(), [from.name(), to.name()]);
        let keep = [Keep::Buffer(from.clone()), Keep::Buffer(to.clone())];
        self.encode(info, &copy_touches(from.id(), to.id()), keep, |raw, cmd| {
            // SAFETY: recording; both buffers are kept alive by the slot.
            unsafe { raw.cmd_copy_buffer(cmd, from.handle(), to.handle(), &region) };
        })
    }

    /// Copies a part of a buffer to the same place of another, in frame order. Both are at least `offset + size` bytes large.
    pub fn copy_part(&mut self, from: &Buffer, to: &Buffer, offset: u64, size: u64) -> Result<()> {
        if size == 0 {
            return Ok(());
        }
        let region = [vk::BufferCopy::default().src_offset(offset).dst_offset(offset).size(size)];
        let info = copy_info(&format!("keep {}", from.name()), size, [from.name(), to.name()]);
        let keep = [Keep::Buffer(from.clone()), Keep::Buffer(to.clone())];
        self.encode(info, &copy_touches(from.id(), to.id()), keep, |raw, cmd| {
            // SAFETY: recording; both buffers are kept alive by the slot.
            unsafe { raw.cmd_copy_buffer(cmd, from.handle(), to.handle(), &region) };
        })
    }

    /// The driver's copy of an image to another of the same size and format.
    pub(crate) fn copy_image(&mut self, name: &str, from: &Image, to: &Image) -> Result<()> {
        let [width, height] = from.extent();
        let layers =
            vk::ImageSubresourceLayers::default().aspect_mask(vk::ImageAspectFlags::COLOR).layer_count(1);
        let region = [vk::ImageCopy::default()
            .src_subresource(layers)
            .dst_subresource(layers)
            .extent(vk::Extent3D { width, height, depth: 1 })];
        let info = copy_info(name, from.bytes(), [from.name(), to.name()]);
        let keep = [Keep::Image(from.clone()), Keep::Image(to.clone())];
        self.encode(info, &copy_touches(from.id(), to.id()), keep, |raw, cmd| {
            let layout = vk::ImageLayout::GENERAL;
            // SAFETY: recording; both images are kept alive by the slot and are in the general layout.
            unsafe { raw.cmd_copy_image(cmd, from.handle(), layout, to.handle(), layout, &region) };
        })
    }
}

/// Row of a copy that reads and writes `bytes` each.
fn copy_info(name: &str, bytes: u64, [from, to]: [&str; 2]) -> PassInfo {
    PassInfo {
        name: name.into(),
        kernel: "(copy)".into(),
        extent: [bytes as u32, 1, 1],
        reads: vec![from.into()],
        writes: vec![to.into()],
        bytes: 2 * bytes,
        bytes_are_upper_bound: false,
    }
}

fn copy_touches(from: u64, to: u64) -> [(u64, Touch); 2] {
    let touch = |access, write| Touch { stage: vk::PipelineStageFlags2::ALL_TRANSFER, access, write };
    [
        (from, touch(vk::AccessFlags2::TRANSFER_READ, false)),
        (to, touch(vk::AccessFlags2::TRANSFER_WRITE, true)),
    ]
}
