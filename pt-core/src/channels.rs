//! The images of a frame: channels of the frame contract and private images of stages ([`pt_shaders::channels`]).

use crate::buffer::Buffer;
use crate::device::Device;
use crate::error::Result;
use crate::history::History;
use crate::image::Image;
use crate::layout::{Life, Ring, Wish, image_bytes, lay_out};
use crate::memory::check_size;
use crate::sizes::FrameSizes;
use pt_shaders::channels::{ChannelId, Lifetime};
use std::collections::BTreeMap;

pub use pt_shaders::records::field_width;

enum Slot {
    Single(Image),
    /// Read before this frame writes it, so that one image is this frame's and the last one's.
    Kept(Image),
    History(History),
    /// In memory of images that exist twice, and as they do in another one from frame to frame.
    InHistory(History),
}

/// An image that a frame needs, with its channel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChannelWish {
    pub(crate) id: ChannelId,
    pub(crate) wish: Wish,
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
    slots: BTreeMap<ChannelId, Slot>,
    /// Bytes of the memory that was allocated for them.
    bytes: u64,
    /// What passes hand on to each other besides images, stage after stage in the same memory.
    table_memory: Option<Buffer>,
    /// Whether a frame has ever begun.
    has_begun: bool,
    /// Whether a frame has been recorded since the last reset.
    has_frame: bool,
    /// Whether the images hold the content of a frame before this one.
    has_history: bool,
}

impl ChannelImages {
    /// Allocates the images of planes.
    ///
    /// # Errors
    /// More than the device's memory, before any of it is taken.
    pub(crate) fn allocate(
        device: &Device,
        sizes: FrameSizes,
        planes: Vec<Vec<ChannelWish>>,
    ) -> Result<Vec<Self>> {
        let all: Vec<_> = planes.iter().flatten().copied().collect();
        let wishes: Vec<_> = all.iter().map(|wish| wish.wish).collect();
        let (rings, places) = lay_out(&wishes);
        let bytes_of = |wish: &Wish| image_bytes(wish.extent, wish.format);
        let bytes = rings.iter().map(|ring| ring.count() as u64 * bytes_of(&wishes[ring.wishes[0]])).sum();
        check_size("a frame", sizes.frame, bytes, "the device", device.info().free_bytes())?;
        let memories: Vec<_> = rings.iter().map(|ring| memory(device, ring, &all)).collect::<Result<_>>()?;
        let mut slots = Vec::new();
        for (number, (ChannelWish { id, wish }, place)) in all.iter().zip(&places).enumerate() {
            let is_owner = rings[place.ring].wishes[0] == number;
            slots.push((*id, slot(*id, wish, &memories[place.ring], place.first, is_owner)?));
        }
        let mut slots = slots.into_iter();
        // What planes share counts as the first one's.
        let mut bytes = Some(bytes);
        let images = |wishes: &Vec<ChannelWish>| Self {
            sizes,
            slots: slots.by_ref().take(wishes.len()).collect(),
            bytes: bytes.take().unwrap_or(0),
            table_memory: None,
            has_begun: false,
            has_frame: false,
            has_history: false,
        };
        Ok(planes.iter().map(images).collect())
    }

    /// Gives the stages memory for tables, see [`ChannelImages::table_memory`].
    pub fn set_table_memory(&mut self, memory: Buffer) {
        self.table_memory = Some(memory);
    }

    /// Memory that each stage in turn may use for what its passes hand on to each other; its content is lost when the stage ends.
    pub fn table_memory(&self) -> Option<&Buffer> {
        self.table_memory.as_ref()
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
            Some(Slot::Single(image) | Slot::Kept(image)) => Ok(image),
            Some(Slot::History(history) | Slot::InHistory(history)) => Ok(history.current()),
            None => Err(Lacking { channel: id, previous: false }),
        }
    }

    /// Last frame's image, if it is kept.
    pub(crate) fn get_previous(&self, id: ChannelId) -> std::result::Result<&Image, Lacking> {
        match self.slots.get(&id) {
            Some(Slot::History(history)) => Ok(history.previous()),
            Some(Slot::Kept(image)) => Ok(image),
            _ => Err(Lacking { channel: id, previous: true }),
        }
    }

    /// Begins a frame: the current images become the previous ones.
    pub fn begin_frame(&mut self) {
        self.has_history = self.has_frame;
        for slot in self.slots.values_mut() {
            if let Slot::History(history) | Slot::InHistory(history) = slot {
                // In all planes at once, whatever histories they have: they are in each other's memory.
                if self.has_begun {
                    history.advance();
                }
            }
            if let (Slot::History(history), false) = (slot, self.has_history) {
                // Nobody reads what it holds.
                history.previous().note_written();
            }
        }
        self.has_begun = true;
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
        self.has_begun = true;
        self.has_frame = true;
    }

    /// Images whose content the next frame reads: those kept from the last frame, and carried ones.
    pub fn histories(&self) -> impl Iterator<Item = ChannelId> {
        let outlives = |(id, slot): (&ChannelId, &Slot)| {
            let lives = matches!(slot, Slot::History(_) | Slot::Kept(_))
                || id.channel().lifetime == Lifetime::Carried;
            lives.then_some(*id)
        };
        self.slots.iter().filter_map(outlives)
    }

    /// Bytes of the memory of all images. That of several planes counts as the first one's.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }
}

/// The memories of a ring, each named after the image that is in it in the first frame.
fn memory(device: &Device, ring: &Ring, all: &[ChannelWish]) -> Result<Vec<Image>> {
    let ChannelWish { wish, .. } = all[ring.wishes[0]];
    let names = ring.wishes.iter().map(|&number| all[number].id.full_name());
    let spare = ring.has_spare.then(|| format!("{}_prev", all[ring.wishes[0]].id.full_name()));
    let image = |name: String| Image::shareable(device, &name, wish.format, wish.extent, ring.other_formats);
    names.chain(spare).map(image).collect()
}

/// An image in these memories in turn, in the memory `first` in the first frame. A single memory is the image itself for its owner.
fn slot(id: ChannelId, wish: &Wish, memories: &[Image], first: usize, is_owner: bool) -> Result<Slot> {
    let view = |memory: &Image| memory.sharing(&id.full_name(), wish.format);
    if let [memory] = memories {
        let image = if is_owner { memory.clone() } else { view(memory)? };
        return Ok(if wish.life == Life::Kept { Slot::Kept(image) } else { Slot::Single(image) });
    }
    let history = History::new(memories.iter().map(view).collect::<Result<_>>()?, first);
    Ok(match wish.life {
        Life::Twice { .. } => Slot::History(history),
        _ => Slot::InHistory(history),
    })
}
