//! The images of a frame: channels of the frame contract and private images of stages ([`pt_shaders::channels`]).

use crate::device::Device;
use crate::error::Result;
use crate::history::History;
use crate::image::Image;
use crate::memory::check_size;
use crate::sizes::FrameSizes;
use pt_shaders::channels::{ChannelId, GbufferFormat, Lifetime};
use std::collections::BTreeMap;

pub use pt_shaders::records::field_width;

enum Slot {
    Single(Image),
    History(History<Image>),
}

/// An image that was requested and is not allocated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lacking {
    /// The image.
    pub channel: ChannelId,
    /// Whether it was last frame's content.
    pub previous: bool,
}

/// The allocated images of a frame, from [`FramePlan::allocate`](crate::plan::FramePlan::allocate) according to the declarations of
/// the stages.
pub struct ChannelImages {
    sizes: FrameSizes,
    format: GbufferFormat,
    slots: BTreeMap<ChannelId, Slot>,
    /// Whether a frame has been recorded since the last reset.
    has_frame: bool,
    /// Whether the images hold the content of a frame before this one.
    has_history: bool,
}

pub(crate) fn channel_bytes(id: ChannelId, format: GbufferFormat, sizes: FrameSizes, previous: bool) -> u64 {
    let [width, height] = sizes.extent(id.channel().extent).map(u64::from);
    width * height * u64::from(id.format(format).bytes()) * (1 + u64::from(previous))
}

impl ChannelImages {
    /// Allocates images; the flag says whether last frame's content is kept too. Other images of the frame take `other_bytes`.
    ///
    /// # Errors
    /// More than the device's memory, before any of it is taken.
    pub(crate) fn allocate(
        device: &Device,
        sizes: FrameSizes,
        images: impl IntoIterator<Item = (ChannelId, bool)>,
        other_bytes: u64,
    ) -> Result<Self> {
        let images: BTreeMap<_, _> = images.into_iter().collect();
        let format = device.gbuffer_format();
        let bytes_of = |(&id, &previous)| channel_bytes(id, format, sizes, previous);
        let bytes = images.iter().map(bytes_of).sum::<u64>() + other_bytes;
        check_size("a frame", sizes.frame, bytes, "the device", device.info().free_bytes())?;
        let mut slots = BTreeMap::new();
        for (id, previous) in images {
            let extent = sizes.extent(id.channel().extent);
            let image = |name: &str| Image::new(device, name, id.format(format), extent);
            let name = id.full_name();
            let slot = if previous {
                Slot::History(History::new(image(&name)?, image(&format!("{name}_prev"))?))
            } else {
                Slot::Single(image(&name)?)
            };
            slots.insert(id, slot);
        }
        Ok(Self { sizes, format, slots, has_frame: false, has_history: false })
    }

    /// Full frame in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.sizes.frame
    }

    /// The picture in pixels.
    pub fn output_size(&self) -> [u32; 2] {
        self.sizes.output
    }

    /// All sizes of the frame.
    pub fn sizes(&self) -> FrameSizes {
        self.sizes
    }

    /// The allocated images: the frame contract in table order, then the private images of the stages.
    pub fn ids(&self) -> impl Iterator<Item = ChannelId> {
        self.slots.keys().copied()
    }

    /// This frame's image.
    ///
    /// # Panics
    /// If no stage of the plan declares it. Passes report that as an error instead.
    pub fn current(&self, id: ChannelId) -> &Image {
        self.get(id).unwrap_or_else(|_| panic!("{} is not allocated", id.full_name()))
    }

    /// This frame's image, if it is there.
    pub(crate) fn get(&self, id: ChannelId) -> std::result::Result<&Image, Lacking> {
        match self.slots.get(&id) {
            Some(Slot::Single(image)) => Ok(image),
            Some(Slot::History(history)) => Ok(history.current()),
            None => Err(Lacking { channel: id, previous: false }),
        }
    }

    /// Last frame's image, if it is kept.
    pub(crate) fn get_previous(&self, id: ChannelId) -> std::result::Result<&Image, Lacking> {
        match self.slots.get(&id) {
            Some(Slot::History(history)) => Ok(history.previous()),
            _ => Err(Lacking { channel: id, previous: true }),
        }
    }

    /// Begins a frame: the current images become the previous ones.
    pub fn begin_frame(&mut self) {
        self.has_history = self.has_frame;
        if self.has_frame {
            for slot in self.slots.values_mut() {
                if let Slot::History(history) = slot {
                    history.swap();
                }
            }
        }
        self.has_frame = true;
    }

    /// Whether previous and carried images hold the content of the last frame. They do not in the first frame and in the one after
    /// [`ChannelImages::reset_history`]; a stage then starts without history.
    pub fn has_history(&self) -> bool {
        self.has_history
    }

    /// Whether a frame has been recorded since the last reset: the next one will have a history.
    pub fn has_frame(&self) -> bool {
        self.has_frame
    }

    /// Invalidates all histories of all stages, after a cut or a teleport of the camera.
    pub fn reset_history(&mut self) {
        self.has_frame = false;
    }

    /// Declares the histories valid after the caller has loaded them.
    pub fn resume_history(&mut self) {
        self.has_frame = true;
    }

    /// Images whose content the next frame reads: those kept from the last frame, and carried ones.
    pub fn histories(&self) -> impl Iterator<Item = ChannelId> {
        let outlives = |(id, slot): (&ChannelId, &Slot)| {
            let lives = matches!(slot, Slot::History(_)) || id.channel().lifetime == Lifetime::Carried;
            lives.then_some(*id)
        };
        self.slots.iter().filter_map(outlives)
    }

    /// Bytes of an image, with last frame's where that is kept; 0 when it is not there.
    pub fn bytes_of(&self, id: ChannelId) -> u64 {
        let slot = self.slots.get(&id);
        slot.map_or(0, |slot| channel_bytes(id, self.format, self.sizes, matches!(slot, Slot::History(_))))
    }

    /// Bytes of all images.
    pub fn bytes(&self) -> u64 {
        self.ids().map(|id| self.bytes_of(id)).sum()
    }
}
