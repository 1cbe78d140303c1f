//! What the passes of direct lighting tell each other: the shadow rays of a light sample and what they bring (`shadow_ray_slots.glsl`).

use crate::params::DirectParams;
use crate::records::{DirectPush, LightRays, ShadowRayTables};
use pt_core::error::Error;
use pt_core::frame::{Pass, RayCount};
use pt_core::memory::check_size;
use pt_core::split::split_size;
use pt_core::{Buffer, ChannelImages, Device, RayLists, Result, TableMemory};
use pt_shaders::records::RayListHead;
use std::cell::RefCell;
use std::mem::offset_of;

/// A word of the list has 28 bits for the texel.
const MAX_TEXELS: u64 = 1 << 28;
/// Bytes of an end, and of the light that a ray brings.
const SLOT_BYTES: u64 = 16;
/// Bytes of a word of the list, of a texel's state, and of what it leaves to bounce rays.
const WORD_BYTES: u64 = 4;
/// Bytes of a texel's sums.
const SUM_BYTES: u64 = 32;

/// The tables; made in the first frame, which says how large frames are.
pub(crate) struct ShadowRays {
    device: Device,
    tables: RefCell<Option<Tables>>,
}

/// Tables for frames of one size.
struct Tables {
    frame: [u32; 2],
    slots: u64,
    lists: RayLists,
    ends: Buffer,
    lights: Buffer,
    /// Of the list; kept from frame to frame.
    head: Buffer,
    list: Buffer,
    states: Buffer,
    shares: Buffer,
    /// With more than one light sample a pixel.
    sums: Option<Buffer>,
    addresses: Buffer,
    memory: TableMemory,
}

/// Shadow rays that a light sample has at most: for the sun, local lights (of each kind, or merged), the environment and its reflection.
fn slot_count(params: &DirectParams) -> u64 {
    match params.rays {
        LightRays::PerKind => 5,
        LightRays::Merged => 4,
    }
}

/// Bytes that the tables of a frame of `size` pixels take.
pub(crate) fn table_bytes(size: [u32; 2], params: &DirectParams) -> u64 {
    let [width, height] = split_size(size).map(u64::from);
    TableMemory::room(width * height * texel_bytes(slot_count(params), params.samples > 1), TABLES)
}

/// Tables in memory that other stages use, too.
const TABLES: u64 = 6;

/// Bytes for a texel of the split frame.
fn texel_bytes(slots: u64, sums: bool) -> u64 {
    slots * (2 * SLOT_BYTES + WORD_BYTES) + 2 * WORD_BYTES + if sums { SUM_BYTES } else { 0 }
}

impl Tables {
    fn new(
        device: &Device,
        mut memory: TableMemory,
        frame: [u32; 2],
        slots: u64,
        sums: bool,
    ) -> Result<Self> {
        let [width, height] = split_size(frame).map(u64::from);
        let texels = width * height;
        if texels > MAX_TEXELS {
            return Err(Error::Unsupported(format!(
                "direct lighting of a frame of {}x{}: at most {MAX_TEXELS} pixels are possible; ask for a smaller frame",
                frame[0], frame[1]
            )));
        }
        let bytes = texels * texel_bytes(slots, sums);
        check_size("direct lighting of a frame", frame, bytes, "the device", device.info().free_bytes())?;
        let mut table = |name, bytes| memory.table(name, bytes);
        let ends = table("shadow ray ends", texels * slots * SLOT_BYTES)?;
        let lights = table("shadow ray lights", texels * slots * SLOT_BYTES)?;
        let list = table("shadow ray list", texels * slots * WORD_BYTES)?;
        let lists = RayLists::new(width as u32, texels * slots);
        let head = Buffer::from_slice(device, "head of the shadow ray list", &[lists.empty()])?;
        let states = table("shadow ray states", texels * WORD_BYTES)?;
        let shares = table("specular light left to bounce rays", texels * WORD_BYTES)?;
        let sums = sums.then(|| table("light of samples", texels * SUM_BYTES)).transpose()?;
        let addresses = ShadowRayTables {
            ends: ends.address(),
            lights: lights.address(),
            head: head.address(),
            list: list.address(),
            states: states.address(),
            shares: shares.address(),
            sums: sums.as_ref().map_or(0, Buffer::address),
        };
        let addresses = Buffer::from_slice(device, "shadow ray tables", &[addresses])?;
        Ok(Self { frame, slots, lists, ends, lights, head, list, states, shares, sums, addresses, memory })
    }
}

impl ShadowRays {
    pub(crate) fn new(device: &Device) -> Self {
        Self { device: device.clone(), tables: RefCell::new(None) }
    }

    /// Makes the tables where there are none for such frames, and tells the kernels where they are.
    pub(crate) fn prepare(
        &self,
        images: &ChannelImages,
        params: &DirectParams,
        push: &mut DirectPush,
    ) -> Result<()> {
        let (size, slots, sums) = (images.size(), slot_count(params), params.samples > 1);
        let memory = TableMemory::of(&self.device, images);
        let mut slot = self.tables.borrow_mut();
        let fits = |t: &Tables| {
            t.frame == size && t.slots == slots && (t.sums.is_some() || !sums) && t.memory.is_that_of(&memory)
        };
        let tables = match slot.take().filter(fits) {
            Some(before) => slot.insert(before),
            None => slot.insert(Tables::new(&self.device, memory, size, slots, sums)?),
        };
        push.shadow_rays = tables.addresses.address();
        push.ray_columns = tables.lists.columns();
        Ok(())
    }

    /// Declares what choosing lights does with them.
    pub(crate) fn bind_choice<'f, 'r>(&self, pass: Pass<'f, 'r>) -> Pass<'f, 'r> {
        self.tables.borrow().iter().fold(pass, |pass, t| {
            let pass = pass.addresses(&t.addresses).streams_written(&t.ends).streams_written(&t.lights);
            pass.addresses_updated(&t.head)
                .streams_written(&t.list)
                .streams_written(&t.states)
                .streams_written(&t.shares)
        })
    }

    /// Declares what adding up does with them.
    pub(crate) fn bind_sum<'f, 'r>(&self, pass: Pass<'f, 'r>, params: &DirectParams) -> Pass<'f, 'r> {
        self.tables.borrow().iter().fold(pass, |pass, t| {
            let pass = pass.addresses(&t.addresses).addresses_updated(&t.head);
            let pass = pass.streams(&t.ends).streams(&t.lights).streams(&t.states).streams(&t.shares);
            t.sums.iter().filter(|_| params.samples > 1).fold(pass, Pass::streams_updated)
        })
    }

    /// Declares what tracing does with them, and launches a thread for each ray of the list.
    pub(crate) fn trace(&self, pass: Pass<'_, '_>) -> Result<()> {
        let slot = self.tables.borrow();
        let Some(t) = &*slot else { return Ok(()) };
        let pass = pass
            .addresses(&t.addresses)
            .addresses(&t.head)
            .streams(&t.ends)
            .streams(&t.list)
            .streams_updated(&t.states);
        let pass = pass.rays(RayCount::Listed(t.head.clone(), offset_of!(RayListHead, count) as u64));
        pass.dispatch_indirect(t.lists.trace_extent(), &t.head, offset_of!(RayListHead, groups) as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pt_core::test_support::TestDevice;

    #[test]
    fn frames_without_room_are_refused() {
        let device = TestDevice::open();
        let memory = || TableMemory::own(&device);
        let refusal =
            |frame| Tables::new(&device, memory(), frame, 5, false).err().expect("an error").to_string();
        let message = refusal([40_000, 40_000]);
        assert!(
            message.contains("direct lighting of a frame of 40000x40000: at most 268435456 pixels"),
            "{message}"
        );
        // Twice the free memory, unless that is more than any frame can take.
        let side = (2.0 * device.info().free_bytes() as f64 / texel_bytes(5, false) as f64).sqrt();
        let side = (side as u32).min(40_000);
        let message = refusal([side, side]);
        assert!(message.contains("direct lighting of a frame of"), "{message}");
    }

    #[test]
    fn bytes_are_those_of_the_readme() {
        assert_eq!(
            [(5, false), (4, false), (4, true)].map(|(slots, sums)| texel_bytes(slots, sums)),
            [188, 152, 184]
        );
    }
}
