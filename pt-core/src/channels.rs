//! The images of the frame contract ([`pt_shaders::channels`]) and histories.

use crate::device::Device;
use crate::error::{Error, Result};
use crate::image::Image;
use crate::split::split_size;
use pt_shaders::channels::{ChannelId, ExtentClass};
use std::collections::{BTreeMap, BTreeSet};

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
    output_size: [u32; 2],
    slots: BTreeMap<ChannelId, Slot>,
}

pub use pt_shaders::records::field_width;

/// Extent of a channel for a frame of `size` whose picture has `output_size`.
pub fn extent(class: ExtentClass, size: [u32; 2], output_size: [u32; 2]) -> [u32; 2] {
    match class {
        ExtentClass::Split => split_size(size),
        ExtentClass::Flat => size,
        ExtentClass::Output => output_size,
    }
}

fn channel_bytes(id: ChannelId, size: [u32; 2], output_size: [u32; 2]) -> u64 {
    let channel = id.channel();
    let [width, height] = extent(channel.extent, size, output_size).map(u64::from);
    width * height * u64::from(channel.format.bytes()) * (1 + u64::from(channel.history))
}

impl ChannelImages {
    /// Allocates `channels` (duplicates are fine) for a frame of `size` pixels, whose picture is as large.
    ///
    /// # Errors
    /// More than the device's memory, before any of it is taken.
    pub fn new(
        device: &Device,
        size: [u32; 2],
        channels: impl IntoIterator<Item = ChannelId>,
    ) -> Result<Self> {
        Self::with_output(device, size, size, channels)
    }

    /// As [`ChannelImages::new`], for a picture of `output_size` pixels.
    ///
    /// # Errors
    /// More than the device's memory, before any of it is taken.
    pub fn with_output(
        device: &Device,
        size: [u32; 2],
        output_size: [u32; 2],
        channels: impl IntoIterator<Item = ChannelId>,
    ) -> Result<Self> {
        let channels: BTreeSet<_> = channels.into_iter().collect();
        let bytes = channels.iter().map(|&id| channel_bytes(id, size, output_size)).sum::<u64>();
        let memory = device.info().memory_bytes;
        if bytes > memory {
            let gib = |bytes: u64| bytes as f64 / (1u64 << 30) as f64;
            return Err(Error::Unsupported(format!(
                "a frame of {}x{} takes {:.1} GiB of images, the device has {:.1} GiB; ask for a smaller one",
                size[0],
                size[1],
                gib(bytes),
                gib(memory)
            )));
        }
        let mut slots = BTreeMap::new();
        for id in channels {
            let channel = id.channel();
            let extent = extent(channel.extent, size, output_size);
            let image = |name: &str| Image::new(device, name, channel.format, extent);
            let slot = if channel.history {
                Slot::History(History::new(image(channel.name)?, image(&format!("{}_prev", channel.name))?))
            } else {
                Slot::Single(image(channel.name)?)
            };
            slots.insert(id, slot);
        }
        Ok(Self { size, output_size, slots })
    }

    /// Full frame in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The picture in pixels.
    pub fn output_size(&self) -> [u32; 2] {
        self.output_size
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
        self.slots.keys().map(|&id| channel_bytes(id, self.size, self.output_size)).sum()
    }
}
