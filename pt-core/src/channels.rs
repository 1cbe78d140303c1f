//! The images of a frame: channels of the frame contract and private images of stages ([`pt_shaders::channels`]). The tables in the same memory.

use crate::block::{Block, Part};
use crate::buffer::Buffer;
use crate::device::Device;
use crate::error::Result;
use crate::history::Turns;
use crate::image::Image;
use crate::layout::{Life, Place, Wish, lay_out};
use crate::memory::check_size;
use crate::sizes::FrameSizes;
use ash::vk;
use pt_shaders::channels::{ChannelId, Format, Lifetime};
use std::collections::BTreeMap;

pub use pt_shaders::records::field_width;

/// A table that a frame needs, by the name that stages declare it with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TableWish {
    /// Its name, see [`crate::StageIo::tables`].
    pub name: &'static str,
    /// Its size.
    pub bytes: u64,
}

enum Slot {
    Single(Image),
    /// Read before this frame writes it, so that one image is this frame's and the last one's.
    Kept(Image),
    History(Turns<Image>),
    /// In memory of images that exist twice, and as they do in another one from frame to frame.
    InHistory(Turns<Image>),
}

/// What a frame needs memory for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MemoryWish {
    pub(crate) what: Wished,
    pub(crate) life: Life,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Wished {
    Image { id: ChannelId, format: Format, extent: [u32; 2] },
    Table(TableWish),
}

impl Wished {
    fn requirements(&self, device: &Device) -> Result<vk::MemoryRequirements> {
        match *self {
            Self::Image { id, format, extent } => {
                Image::requirements(device, &id.full_name(), format, extent)
            }
            Self::Table(table) => Ok(Buffer::requirements(device, table.bytes.max(1))),
        }
    }
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
    /// What passes hand on to each other besides images.
    tables: BTreeMap<&'static str, Turns<Buffer>>,
    /// Whether a frame has ever begun.
    has_begun: bool,
    /// Whether a frame has been recorded since the last reset.
    has_frame: bool,
    /// Whether the images hold the content of a frame before this one.
    has_history: bool,
}

impl ChannelImages {
    /// Allocates the images and tables of planes.
    ///
    /// # Errors
    /// More than the device's memory, before any of it is taken.
    pub(crate) fn allocate(
        device: &Device,
        sizes: FrameSizes,
        planes: Vec<Vec<MemoryWish>>,
    ) -> Result<Vec<Self>> {
        let all: Vec<_> = planes.iter().flatten().copied().collect();
        let needs: Vec<_> = all.iter().map(|wish| wish.what.requirements(device)).collect::<Result<_>>()?;
        // Images and buffers are side by side.
        let page = device.info().capabilities.memory_page;
        let alignment = needs.iter().map(|needs| needs.alignment).fold(page, u64::max);
        let wish = |(wish, needs): (&MemoryWish, &vk::MemoryRequirements)| {
            let bytes = needs.size.next_multiple_of(alignment);
            Wish { bytes, types: needs.memory_type_bits, life: wish.life }
        };
        let wishes: Vec<_> = all.iter().zip(&needs).map(wish).collect();
        let (layout, places) = lay_out(&wishes, LARGEST_BLOCK);
        let bytes = layout.iter().map(|block| block.bytes).sum();
        check_size("a frame", sizes.frame, bytes, "the device", device.info().free_bytes())?;
        let mut blocks: Vec<Block> = Vec::new();
        let mut last = None;
        for block in &layout {
            let name = match (block.owner.map(|owner| all[owner].what), &last) {
                (Some(Wished::Image { id, .. }), _) => id.full_name(),
                // The spare one of the ring before.
                (_, Some(name)) => format!("{name}_prev"),
                _ => SHARED.to_owned(),
            };
            last = match block.owner {
                Some(owner) if matches!(all[owner].life, Life::Twice { .. }) => Some(name.clone()),
                _ => None,
            };
            let memory_type_bits = block.types;
            let requirements = vk::MemoryRequirements { size: block.bytes, alignment, memory_type_bits };
            blocks.push(Block::new(device, &name, requirements)?);
        }
        let mut made: Vec<(MemoryWish, Made)> = Vec::new();
        for ((wish, place), needs) in all.iter().zip(&places).zip(&wishes) {
            made.push((*wish, Made::new(device, &wish.what, place, needs.bytes, &blocks)?));
        }
        let images = |is_owner: &dyn Fn(usize) -> bool| -> Vec<Image> {
            let kept = made.iter().enumerate().filter(|(number, _)| is_owner(*number));
            kept.flat_map(|(_, (_, made))| made.images().to_vec()).collect()
        };
        // Nobody reads others before they are written; one image of a ring fills all of its blocks.
        let zeros = images(&|number| layout[places[number].turns[0]].owner == Some(number));
        Image::prepare(device, &images(&|_| true), &zeros)?;
        let mut made = made.into_iter();
        // What planes share counts as the first one's.
        let mut bytes = Some(bytes);
        let images = |wishes: &Vec<MemoryWish>| {
            let mut images = Self {
                sizes,
                slots: BTreeMap::new(),
                bytes: bytes.take().unwrap_or(0),
                tables: BTreeMap::new(),
                has_begun: false,
                has_frame: false,
                has_history: false,
            };
            made.by_ref().take(wishes.len()).for_each(|(wish, made)| images.insert(&wish, made));
            images
        };
        Ok(planes.iter().map(images).collect())
    }

    fn insert(&mut self, wish: &MemoryWish, made: Made) {
        match (wish.what, made) {
            (Wished::Table(table), Made::Table(turns)) => {
                self.tables.insert(table.name, turns);
            }
            (Wished::Image { id, .. }, Made::Image(turns)) => {
                self.slots.insert(id, slot(wish.life, turns));
            }
            _ => {}
        }
    }

    /// The table of this name in the memory of the frame, if the plan knows of it. It may be another one in the next frame.
    pub fn table(&self, name: &str) -> Option<&Buffer> {
        self.tables.get(name).map(Turns::current)
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
                history.name_images();
            }
            if let Slot::History(history) = slot {
                history.current().set_unread(false);
                history.previous().set_unread(!self.has_history);
            }
        }
        if self.has_begun {
            self.tables.values_mut().for_each(Turns::advance);
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

/// So large may an allocation be on every device (`maxMemoryAllocationSize`).
const LARGEST_BLOCK: u64 = 1 << 30;

/// Name of the memory of what lives within a frame.
pub const SHARED: &str = "images and tables in turn";

/// Resources that were made for a wish, one for each block in turn.
enum Made {
    Image(Turns<Image>),
    Table(Turns<Buffer>),
}

impl Made {
    fn new(device: &Device, what: &Wished, place: &Place, bytes: u64, blocks: &[Block]) -> Result<Self> {
        let parts = place.turns.iter().map(|&block| blocks[block].part(place.offset, bytes));
        Ok(match *what {
            Wished::Image { id, format, extent } => {
                let image = |part: Part| Image::placed(part, device, &id.full_name(), format, extent);
                Self::Image(Turns::new(parts.map(image).collect::<Result<_>>()?, place.first))
            }
            Wished::Table(TableWish { name, bytes }) => {
                let table = |part: Part| Buffer::placed(part, device, name, bytes.max(1));
                Self::Table(Turns::new(parts.map(table).collect::<Result<_>>()?, place.first))
            }
        })
    }

    fn images(&self) -> &[Image] {
        match self {
            Self::Image(turns) => turns.all(),
            Self::Table(_) => &[],
        }
    }
}

/// An image in its places.
fn slot(life: Life, turns: Turns<Image>) -> Slot {
    match (life, turns.all()) {
        (Life::Twice { .. }, _) => {
            turns.name_images();
            Slot::History(turns)
        }
        (Life::Kept, [image]) => Slot::Kept(image.clone()),
        (_, [image]) => Slot::Single(image.clone()),
        _ => Slot::InHistory(turns),
    }
}
