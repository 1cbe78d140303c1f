//! The images of the frame contract ([`pt_shaders::channels`]) and histories.

use crate::device::Device;
use crate::error::Result;
use crate::image::Image;
use pt_shaders::channels::{ChannelId, ExtentClass};
use std::collections::BTreeMap;

/// A value of this frame and of the last one.
#[derive(Clone, Debug)]
pub struct History<T> {
    current: T,
    previous: T,
}

impl<T> History<T> {
    /// Both at their start.
    pub fn new(current: T, previous: T) -> Self {
        Self { current, previous }
    }

    /// This frame's.
    pub fn current(&self) -> &T {
        &self.current
    }

    /// Last frame's.
    pub fn previous(&self) -> &T {
        &self.previous
    }

    /// Ends the frame: what was current becomes previous.
    pub fn swap(&mut self) {
        std::mem::swap(&mut self.current, &mut self.previous);
    }
}

enum Slot {
    Single(Image),
    History(History<Image>),
}

/// Allocated channels.
pub struct ChannelImages {
    size: [u32; 2],
    slots: BTreeMap<ChannelId, Slot>,
}

/// Width of one checkerboard field of a frame that is `width` wide.
pub const fn field_width(width: u32) -> u32 {
    width.div_ceil(2)
}

/// Extent of a channel for a frame of `size`.
pub fn extent(class: ExtentClass, size: [u32; 2]) -> [u32; 2] {
    match class {
        ExtentClass::Split => [2 * field_width(size[0]), size[1]],
        ExtentClass::Flat => size,
    }
}

impl ChannelImages {
    /// Allocates `channels` (duplicates are fine) for a frame of `size` pixels.
    pub fn new(
        device: &Device,
        size: [u32; 2],
        channels: impl IntoIterator<Item = ChannelId>,
    ) -> Result<Self> {
        let mut slots = BTreeMap::new();
        for id in channels {
            if slots.contains_key(&id) {
                continue;
            }
            let channel = id.channel();
            let extent = extent(channel.extent, size);
            let image = |name: &str| Image::new(device, name, channel.format, extent);
            let slot = if channel.history {
                Slot::History(History::new(image(channel.name)?, image(&format!("{}_prev", channel.name))?))
            } else {
                Slot::Single(image(channel.name)?)
            };
            slots.insert(id, slot);
        }
        Ok(Self { size, slots })
    }

    /// Full frame in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Channels that are there, in table order.
    pub fn ids(&self) -> impl Iterator<Item = ChannelId> {
        self.slots.keys().copied()
    }

    /// This frame's image.
    ///
    /// # Panics
    /// When the channel was not asked for in [`ChannelImages::new`]: a mistake in the frame's composition.
    pub fn current(&self, id: ChannelId) -> &Image {
        match self.slot(id) {
            Slot::Single(image) => image,
            Slot::History(history) => history.current(),
        }
    }

    /// Last frame's image.
    ///
    /// # Panics
    /// When the channel was not asked for or has no history.
    pub fn previous(&self, id: ChannelId) -> &Image {
        match self.slot(id) {
            Slot::Single(_) => panic!("channel {} has no history", id.channel().name),
            Slot::History(history) => history.previous(),
        }
    }

    fn slot(&self, id: ChannelId) -> &Slot {
        self.slots.get(&id).unwrap_or_else(|| panic!("channel {} is not allocated", id.channel().name))
    }

    /// Ends the frame: every history moves on.
    pub fn swap(&mut self) {
        for slot in self.slots.values_mut() {
            if let Slot::History(history) = slot {
                history.swap();
            }
        }
    }

    /// Bytes of all images.
    pub fn bytes(&self) -> u64 {
        self.slots
            .values()
            .map(|slot| match slot {
                Slot::Single(image) => image.bytes(),
                Slot::History(history) => history.current().bytes() + history.previous().bytes(),
            })
            .sum()
    }
}
