//! The images of a frame: channels of the frame contract and private images of stages ([`pt_shaders::channels`]).

use crate::buffer::Buffer;
use crate::device::Device;
use crate::error::Result;
use crate::history::History;
use crate::image::Image;
use crate::layout::{Life, Place, Wish, places};
use crate::memory::check_size;
use crate::sizes::FrameSizes;
use pt_shaders::channels::{ChannelId, Lifetime};
use std::collections::BTreeMap;

pub use pt_shaders::records::field_width;

enum Slot {
    Single(Image),
    /// Read before this frame writes it, so that one image is this frame's and the last one's.
    Kept(Image),
    History(History<Image>),
    /// In the memory of another image that exists twice: each view is of one of the two.
    InHistory(History<Image>),
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
    /// What passes hand on to each other besides images, stage after stage in the same memory.
    table_memory: Option<Buffer>,
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
        let places = places(&wishes);
        let own = wishes.iter().zip(&places).filter(|(_, place)| matches!(place, Place::Own { .. }));
        let bytes = own.map(|(wish, _)| wish.bytes()).sum();
        check_size("a frame", sizes.frame, bytes, "the device", device.info().free_bytes())?;
        let mut slots: Vec<Option<Slot>> = Vec::new();
        for (ChannelWish { id, wish }, place) in all.iter().zip(&places) {
            slots.push(match *place {
                Place::Own { other_formats } => Some(own_memory(device, *id, wish, other_formats)?),
                Place::In { .. } => None,
            });
        }
        for (number, place) in places.iter().enumerate() {
            if let Place::In { host, previous } = *place {
                let slot = slots[host].as_ref().map(|host| shared_memory(host, previous, all[number]));
                slots[number] = slot.transpose()?;
            }
        }
        let mut slots = all.iter().map(|wish| wish.id).zip(slots).filter_map(|(id, slot)| Some((id, slot?)));
        let images = |wishes: &Vec<ChannelWish>| Self {
            sizes,
            slots: slots.by_ref().take(wishes.len()).collect(),
            table_memory: None,
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
        if self.has_frame {
            for slot in self.slots.values_mut() {
                if let Slot::History(history) | Slot::InHistory(history) = slot {
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
            let lives = matches!(slot, Slot::History(_) | Slot::Kept(_))
                || id.channel().lifetime == Lifetime::Carried;
            lives.then_some(*id)
        };
        self.slots.iter().filter_map(outlives)
    }

    /// Bytes of the memory of all images.
    pub fn bytes(&self) -> u64 {
        let bytes = |image: &Image| if image.owns_memory() { image.bytes() } else { 0 };
        let slots = self.slots.values().map(|slot| match slot {
            Slot::Single(image) | Slot::Kept(image) => bytes(image),
            Slot::History(history) | Slot::InHistory(history) => {
                bytes(history.current()) + bytes(history.previous())
            }
        });
        slots.sum()
    }
}

fn previous_name(name: &str) -> String {
    format!("{name}_prev")
}

fn own_memory(device: &Device, id: ChannelId, wish: &Wish, other_formats: bool) -> Result<Slot> {
    let name = id.full_name();
    let image = |name: &str| Image::shareable(device, name, wish.format, wish.extent, other_formats);
    Ok(match wish.life {
        Life::Twice { .. } => Slot::History(History::new(image(&name)?, image(&previous_name(&name))?)),
        Life::Kept => Slot::Kept(image(&name)?),
        Life::Always | Life::Within { .. } => Slot::Single(image(&name)?),
    })
}

/// `previous`: in the memory of last frame's content.
fn shared_memory(host: &Slot, previous: bool, ChannelWish { id, wish }: ChannelWish) -> Result<Slot> {
    let name = id.full_name();
    let within = |host: &Image| host.sharing(&name, wish.format);
    Ok(match host {
        Slot::Single(host) | Slot::Kept(host) => Slot::Single(within(host)?),
        // The two swap from frame to frame.
        Slot::History(host) | Slot::InHistory(host) => {
            let [now, next] = match previous {
                true => [host.previous(), host.current()],
                false => [host.current(), host.previous()],
            };
            Slot::InHistory(History::new(within(now)?, within(next)?))
        }
    })
}
