//! What the passes of direct lighting tell each other: the shadow rays of a light sample and what they bring (`shadow_ray_slots.glsl`).

use crate::params::DirectParams;
use crate::records::{DirectPush, LightRays, ShadowRayTables};
use pt_core::error::Error;
use pt_core::frame::{Pass, RayCount, Uniforms};
use pt_core::memory::check_size;
use pt_core::split::split_size;
use pt_core::{Buffer, ChannelImages, Device, Frame, RayLists, Result, TableMemory, TableWish};
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

/// The names of the tables.
pub(crate) const TABLES: &[&str] = &[ENDS, LIGHTS, LIST, STATES, SHARES, SUMS];
const ENDS: &str = "shadow ray ends";
const LIGHTS: &str = "shadow ray lights";
const LIST: &str = "shadow ray list";
const STATES: &str = "shadow ray states";
const SHARES: &str = "specular light left to bounce rays";
const SUMS: &str = "light of samples";

/// Makes the tables of a frame.
pub(crate) struct ShadowRays {
    device: Device,
    memory: RefCell<TableMemory>,
    tables: RefCell<Option<Tables>>,
}

/// Tables of a frame.
struct Tables {
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
    addresses: Uniforms<ShadowRayTables>,
}

/// Shadow rays that a light sample has at most: for the sun, local lights (of each kind, or merged), the environment and its reflection.
fn slot_count(params: &DirectParams) -> u64 {
    match params.rays {
        LightRays::PerKind => 5,
        LightRays::Merged => 4,
    }
}

/// The tables of a frame of `size` pixels.
pub(crate) fn wishes(size: [u32; 2], params: &DirectParams) -> Vec<TableWish> {
    wishes_of(size, slot_count(params), params.samples > 1)
}

fn wishes_of(size: [u32; 2], slots: u64, sums: bool) -> Vec<TableWish> {
    let texels: u64 = split_size(size).map(u64::from).iter().product();
    let rays = texels * slots;
    let sums = sums.then_some((SUMS, texels * SUM_BYTES));
    [
        (ENDS, rays * SLOT_BYTES),
        (LIGHTS, rays * SLOT_BYTES),
        (LIST, rays * WORD_BYTES),
        (STATES, texels * WORD_BYTES),
        (SHARES, texels * WORD_BYTES),
    ]
    .into_iter()
    .chain(sums)
    .map(|(name, bytes)| TableWish { name, bytes })
    .collect()
}

impl Tables {
    /// `before`: those of the last frame, or of another plane.
    fn new(
        device: &Device,
        memory: &mut TableMemory,
        images: Option<&ChannelImages>,
        frame: [u32; 2],
        [slots, sums]: [u64; 2],
        before: Option<Self>,
    ) -> Result<Self> {
        let [width, height] = split_size(frame).map(u64::from);
        let texels = width * height;
        if texels > MAX_TEXELS {
            return Err(Error::Unsupported(format!(
                "direct lighting of a frame of {}x{}: at most {MAX_TEXELS} pixels are possible; ask for a smaller frame",
                frame[0], frame[1]
            )));
        }
        let wishes = wishes_of(frame, slots, sums > 0);
        if before.is_none() {
            let bytes = memory.own_bytes(images, &wishes);
            check_size("direct lighting of a frame", frame, bytes, "the device", device.info().free_bytes())?;
        }
        let mut tables = wishes.iter().map(|&wish| memory.table(images, wish));
        let mut table = || tables.next().transpose();
        let missing = || Error::Unsupported("a table of shadow rays is missing".into());
        let mut needed = || table()?.ok_or_else(missing);
        let [ends, lights, list, states, shares] = [needed()?, needed()?, needed()?, needed()?, needed()?];
        let sums = table()?;
        let lists = RayLists::new(width as u32, texels * slots);
        let (head, addresses) = match before.filter(|before| before.lists == lists) {
            Some(before) => (before.head, before.addresses),
            None => (
                Buffer::from_slice(device, "head of the shadow ray list", &[lists.empty()])?,
                Uniforms::new(device, "shadow ray tables")?,
            ),
        };
        Ok(Self { lists, ends, lights, head, list, states, shares, sums, addresses })
    }

    fn addresses(&self) -> ShadowRayTables {
        ShadowRayTables {
            ends: self.ends.address(),
            lights: self.lights.address(),
            head: self.head.address(),
            list: self.list.address(),
            states: self.states.address(),
            shares: self.shares.address(),
            sums: self.sums.as_ref().map_or(0, Buffer::address),
        }
    }
}

impl ShadowRays {
    pub(crate) fn new(device: &Device) -> Self {
        let memory = RefCell::new(TableMemory::new(device));
        Self { device: device.clone(), memory, tables: RefCell::new(None) }
    }

    /// Takes the tables of this frame, and tells the kernels where they are.
    pub(crate) fn prepare(
        &self,
        frame: &mut Frame<'_>,
        images: &ChannelImages,
        params: &DirectParams,
        push: &mut DirectPush,
    ) -> Result<()> {
        let counts = [slot_count(params), u64::from(params.samples > 1)];
        let mut slot = self.tables.borrow_mut();
        let memory = &mut self.memory.borrow_mut();
        let before = slot.take();
        let tables =
            slot.insert(Tables::new(&self.device, memory, Some(images), images.size(), counts, before)?);
        tables.addresses.upload(frame, &tables.addresses())?;
        push.shadow_rays = tables.addresses.buffer().address();
        push.ray_columns = tables.lists.columns();
        Ok(())
    }

    /// Declares what choosing lights does with them.
    pub(crate) fn bind_choice<'f, 'r>(&self, pass: Pass<'f, 'r>) -> Pass<'f, 'r> {
        self.tables.borrow().iter().fold(pass, |pass, t| {
            let pass =
                pass.addresses(t.addresses.buffer()).streams_written(&t.ends).streams_written(&t.lights);
            pass.addresses_updated(&t.head)
                .streams_written(&t.list)
                .streams_written(&t.states)
                .streams_written(&t.shares)
        })
    }

    /// Declares what adding up does with them.
    pub(crate) fn bind_sum<'f, 'r>(
        &self,
        pass: Pass<'f, 'r>,
        params: &DirectParams,
        light_sample: u32,
    ) -> Pass<'f, 'r> {
        // The first light sample begins the sums.
        let sums = if light_sample == 0 { Pass::streams_written } else { Pass::streams_updated };
        self.tables.borrow().iter().fold(pass, |pass, t| {
            let pass = pass.addresses(t.addresses.buffer()).addresses_updated(&t.head);
            let pass = pass.streams(&t.ends).streams(&t.lights).streams(&t.states).streams(&t.shares);
            t.sums.iter().filter(|_| params.samples > 1).fold(pass, sums)
        })
    }

    /// Declares what tracing does with them, and launches a thread for each ray of the list.
    pub(crate) fn trace(&self, pass: Pass<'_, '_>) -> Result<()> {
        let slot = self.tables.borrow();
        let Some(t) = &*slot else { return Ok(()) };
        let pass = pass
            .addresses(t.addresses.buffer())
            .addresses_updated(&t.head)
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
        let refusal = |frame| {
            let mut memory = TableMemory::new(&device);
            let tables = Tables::new(&device, &mut memory, None, frame, [5, 0], None);
            tables.err().expect("an error").to_string()
        };
        let message = refusal([40_000, 40_000]);
        assert!(
            message.contains("direct lighting of a frame of 40000x40000: at most 268435456 pixels"),
            "{message}"
        );
        // Twice the free memory, unless that is more than any frame can take.
        let side = (2.0 * device.info().free_bytes() as f64 / 188.0).sqrt();
        let side = (side as u32).min(40_000);
        let message = refusal([side, side]);
        assert!(message.contains("direct lighting of a frame of"), "{message}");
    }

    #[test]
    fn bytes_are_those_of_the_readme() {
        let texel_bytes = |(slots, sums)| {
            wishes_of([64, 32], slots, sums).iter().map(|wish| wish.bytes).sum::<u64>() / (64 * 32)
        };
        assert_eq!([(5, false), (4, false), (4, true)].map(texel_bytes), [188, 152, 184]);
    }
}
