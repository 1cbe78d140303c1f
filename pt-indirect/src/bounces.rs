//! What the passes of indirect lighting tell each other (`bounce_path.glsl`): a place for each path in tables on the device.

use crate::records::{BOUNCE_LIST_HEADS, BOUNCE_LISTS, BounceTables, IndirectPush};
use pt_core::error::Error;
use pt_core::frame::{Pass, RayCount};
use pt_core::memory::check_size;
use pt_core::split::split_size;
use pt_core::{Buffer, ChannelImages, Device, Location, RayLists, Result, TableMemory};
use pt_shaders::records::RayListHead;
use std::cell::RefCell;
use std::mem::offset_of;

/// So that the bytes of a table count in 32 bits.
const MAX_PATHS: u64 = 1 << 28;
/// Bytes of a path in the tables of `uvec4`, `uvec2` and `uint`.
const ROW: u64 = 16;
const PAIR: u64 = 8;
const WORD: u64 = 4;

/// The tables; made in the first frame, which says how large frames are.
pub(crate) struct Bounces {
    device: Device,
    /// Whether paths can be inside of solids.
    has_solids: bool,
    /// Whether glass tints shadow rays.
    has_glass: bool,
    reuses: bool,
    tables: RefCell<Option<Tables>>,
}

/// Which list of paths a pass is launched over.
#[derive(Clone, Copy)]
#[repr(u32)]
pub(crate) enum List {
    Rays,
    ShadowRays,
    Glass,
}

/// Tables for frames of one size.
pub(crate) struct Tables {
    frame: [u32; 2],
    is_half: bool,
    lists: RayLists,
    pub(crate) origins: Buffer,
    pub(crate) directions: Buffer,
    throughputs: Buffer,
    solids: Option<[Buffer; 2]>,
    pub(crate) firsts: Buffer,
    pub(crate) first_directions: Buffer,
    pub(crate) lights: Buffer,
    pub(crate) reflected: Buffer,
    /// Of each path what its ray meets, until its shadow ray is drawn there.
    pub(crate) hits_and_shadow_origins: Buffer,
    pub(crate) shadow_directions: Buffer,
    pub(crate) shadow_lights: Buffer,
    ray_lists: [Buffer; 2],
    pub(crate) shadow_list: Buffer,
    has_glass: bool,
    reuse: Option<ReuseTables>,
    heads: Buffer,
    addresses: Buffer,
    memory: Option<TableMemory>,
}

/// Tables of the reuse of bounces.
pub(crate) struct ReuseTables {
    pub(crate) reusable: Buffer,
    pub(crate) shares: Buffer,
    pub(crate) points: Buffer,
}

/// Paths of a frame.
fn path_count(frame: [u32; 2], is_half: bool) -> u64 {
    let [width, height] = split_size(frame);
    u64::from(width) * u64::from(if is_half { height.div_ceil(2) } else { height })
}

/// Tables at most.
const TABLES: u64 = 18;

/// Bytes of a path.
fn path_bytes(has_solids: bool, reuses: bool) -> u64 {
    let solids = if has_solids { ROW + WORD } else { 0 };
    let reuse = if reuses { 3 * ROW } else { 0 };
    7 * ROW + 2 * PAIR + 4 * WORD + solids + reuse
}

impl Tables {
    fn new(
        device: &Device,
        mut memory: TableMemory,
        frame: [u32; 2],
        is_half: bool,
        has_solids: bool,
        has_glass: bool,
        reuses: bool,
    ) -> Result<Self> {
        let [width, _] = split_size(frame);
        let paths = path_count(frame, is_half);
        if paths > MAX_PATHS {
            return Err(Error::Unsupported(format!(
                "indirect lighting of a frame of {}x{}: at most {MAX_PATHS} paths are possible; ask for a smaller frame",
                frame[0], frame[1]
            )));
        }
        let bytes = paths * path_bytes(has_solids, reuses);
        check_size("indirect lighting of a frame", frame, bytes, "the device", device.info().free_bytes())?;
        let mut buffer = |name, bytes: u64| memory.table(name, paths * bytes);
        let lists = RayLists::new(width, paths);
        let heads = vec![lists.empty(); BOUNCE_LIST_HEADS as usize];
        let mut tables = Self {
            frame,
            is_half,
            lists,
            origins: buffer("bounce ray origins", ROW)?,
            directions: buffer("bounce ray directions", ROW)?,
            throughputs: buffer("throughputs of paths", ROW)?,
            solids: None,
            firsts: buffer("reflectances of first surfaces", ROW)?,
            first_directions: buffer("directions of first rays", WORD)?,
            lights: buffer("light of paths", ROW)?,
            reflected: buffer("reflected light of paths", PAIR)?,
            hits_and_shadow_origins: buffer("hits of bounce rays, origins of bounce shadow rays", ROW)?,
            shadow_directions: buffer("bounce shadow ray directions", ROW)?,
            shadow_lights: buffer("bounce shadow ray lights", PAIR)?,
            ray_lists: [buffer("bounce ray list", WORD)?, buffer("bounce ray list of odd vertices", WORD)?],
            shadow_list: buffer("bounce shadow ray list", WORD)?,
            has_glass,
            reuse: None,
            heads: Buffer::from_slice(device, "bounce list heads", &heads)?,
            addresses: Buffer::new(
                device,
                "bounce tables",
                size_of::<BounceTables>() as u64,
                Location::Device,
            )?,
            memory: None,
        };
        if has_solids {
            let passed = buffer("ways of bounce rays", WORD)?;
            tables.solids = Some([buffer("solids of bounce rays", ROW)?, passed]);
        }
        if reuses {
            tables.reuse = Some(ReuseTables {
                reusable: buffer("reusable light of paths", ROW)?,
                shares: buffer("shares of reusable light", ROW)?,
                points: buffer("points that first rays meet", ROW)?,
            });
        }
        tables.memory = Some(memory);
        tables.addresses.write_through_staging(bytemuck::bytes_of(&tables.addresses()))?;
        Ok(tables)
    }

    fn addresses(&self) -> BounceTables {
        let [solids, passed] = match &self.solids {
            Some(buffers) => [buffers[0].address(), buffers[1].address()],
            None => [0; 2],
        };
        let reuse =
            |table: fn(&ReuseTables) -> &Buffer| self.reuse.as_ref().map_or(0, |t| table(t).address());
        BounceTables {
            origins: self.origins.address(),
            directions: self.directions.address(),
            throughputs: self.throughputs.address(),
            solids,
            passed,
            hits: self.hits_and_shadow_origins.address(),
            firsts: self.firsts.address(),
            first_directions: self.first_directions.address(),
            lights: self.lights.address(),
            reflected: self.reflected.address(),
            shadow_origins: self.hits_and_shadow_origins.address(),
            shadow_directions: self.shadow_directions.address(),
            shadow_lights: self.shadow_lights.address(),
            reusable: reuse(|t| &t.reusable),
            shares: reuse(|t| &t.shares),
            points: reuse(|t| &t.points),
            even_list: self.ray_lists[0].address(),
            odd_list: self.ray_lists[1].address(),
            shadow_list: self.shadow_list.address(),
            heads: self.heads.address(),
        }
    }

    /// Declares what every pass reads and writes besides whole tables: their addresses, and the heads of the lists.
    pub(crate) fn bind<'f, 'r>(&self, pass: Pass<'f, 'r>) -> Pass<'f, 'r> {
        pass.addresses(&self.addresses).addresses_updated(&self.heads)
    }

    /// Paths with a ray from that vertex.
    pub(crate) fn ray_list(&self, vertex: u32) -> &Buffer {
        &self.ray_lists[(vertex & 1) as usize]
    }

    /// What moves on with a path: its ray (two tables), its throughput, and the solids that it is in.
    pub(crate) fn path(&self) -> impl Iterator<Item = &Buffer> {
        [&self.origins, &self.directions, &self.throughputs].into_iter().chain(self.solids())
    }

    /// What says which solids rays are in, if there are any.
    pub(crate) fn solids(&self) -> &[Buffer] {
        self.solids.as_ref().map_or(&[], |buffers| buffers.as_slice())
    }

    /// Paths whose shadow ray from that vertex has met glass, if there is any: where the paths with a ray from there were listed.
    pub(crate) fn glass_list(&self, vertex: u32) -> Option<&Buffer> {
        self.has_glass.then(|| self.ray_list(vertex))
    }

    /// Of the reuse of bounces, if there is any.
    pub(crate) fn reuse(&self) -> Option<&ReuseTables> {
        self.reuse.as_ref()
    }

    /// Launches a kernel that traces over a list.
    pub(crate) fn trace(&self, pass: Pass<'_, '_>, list: List, vertex: u32) -> Result<()> {
        let groups = head(list, vertex) + offset_of!(RayListHead, groups) as u64;
        let count = head(list, vertex) + offset_of!(RayListHead, count) as u64;
        let pass = pass.rays(RayCount::Listed(self.heads.clone(), count));
        pass.dispatch_indirect(self.lists.trace_extent(), &self.heads, groups)
    }

    /// Launches a kernel that shades over a list.
    pub(crate) fn shade(&self, pass: Pass<'_, '_>, list: List, vertex: u32) -> Result<()> {
        let groups = head(list, vertex) + offset_of!(RayListHead, shading_groups) as u64;
        pass.dispatch_indirect(self.lists.shading_extent(), &self.heads, groups)
    }
}

/// Where the head of a list stands among the heads.
fn head(list: List, vertex: u32) -> u64 {
    u64::from(vertex * BOUNCE_LISTS + list as u32) * size_of::<RayListHead>() as u64
}

impl Bounces {
    pub(crate) fn new(device: &Device, has_solids: bool, has_glass: bool, reuses: bool) -> Self {
        Self { device: device.clone(), has_solids, has_glass, reuses, tables: RefCell::new(None) }
    }

    /// Bytes that the tables of a frame of `size` pixels take.
    pub(crate) fn table_bytes(&self, size: [u32; 2], is_half: bool) -> u64 {
        let bytes = path_bytes(self.has_solids, self.reuses);
        TableMemory::room(path_count(size, is_half) * bytes, TABLES)
    }

    /// Makes the tables where there are none for such frames, tells the kernels where they are, and does something with them.
    pub(crate) fn with<T>(
        &self,
        images: &ChannelImages,
        is_half: bool,
        push: &mut IndirectPush,
        record: impl FnOnce(&Tables, &mut IndirectPush) -> Result<T>,
    ) -> Result<T> {
        let mut slot = self.tables.borrow_mut();
        let size = images.size();
        let memory = TableMemory::of(&self.device, images);
        let fits = |t: &Tables| {
            let same_memory = t.memory.as_ref().is_some_and(|of| of.is_that_of(&memory));
            t.frame == size && t.is_half == is_half && same_memory
        };
        let Self { device, has_solids, has_glass, reuses, .. } = self;
        let tables = match slot.take().filter(fits) {
            Some(before) => slot.insert(before),
            None => {
                slot.insert(Tables::new(device, memory, size, is_half, *has_solids, *has_glass, *reuses)?)
            }
        };
        push.tables = tables.addresses.address();
        push.columns = tables.lists.columns();
        push.width = split_size(size)[0];
        record(tables, push)
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
            Tables::new(&device, TableMemory::own(&device), frame, false, true, true, true)
                .err()
                .expect("an error")
                .to_string()
        };
        let message = refusal([40_000, 40_000]);
        assert!(
            message.contains("indirect lighting of a frame of 40000x40000: at most 268435456 paths"),
            "{message}"
        );
        // Twice the free memory, unless that is more than any frame can take.
        let side = (2.0 * device.info().free_bytes() as f64 / path_bytes(true, true) as f64).sqrt();
        let side = (side as u32).min(40_000);
        let message = refusal([side, side]);
        assert!(message.contains("indirect lighting of a frame of"), "{message}");
    }

    /// The README states these, and that half a bounce takes half of them.
    #[test]
    fn bytes_are_those_of_the_readme() {
        assert_eq!([false, true].map(|has_solids| path_bytes(has_solids, false)), [144, 164]);
        assert_eq!(path_bytes(false, true), 192);
        let device = TestDevice::open();
        let bytes = |is_half, reuses| {
            let t = Tables::new(&device, TableMemory::own(&device), [64, 32], is_half, true, true, reuses)
                .unwrap();
            let rows = [&t.origins, &t.directions, &t.throughputs, &t.firsts, &t.first_directions];
            let shadow = [&t.hits_and_shadow_origins, &t.shadow_directions, &t.shadow_lights];
            let light = [&t.lights, &t.reflected].into_iter().chain(shadow);
            let lists = [t.ray_list(0), t.ray_list(1), &t.shadow_list];
            let rest = t.solids().iter();
            let reuse = t.reuse().into_iter().flat_map(|r| [&r.reusable, &r.shares, &r.points]);
            rows.into_iter().chain(light).chain(lists).chain(rest).chain(reuse).map(Buffer::size).sum::<u64>()
        };
        assert_eq!([bytes(false, false), bytes(true, false)], [64 * 32 * 164, 64 * 16 * 164]);
        assert_eq!(bytes(false, true), 64 * 32 * 212);
    }
}
