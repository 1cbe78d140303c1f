//! What the passes of indirect lighting tell each other (`bounce_path.glsl`): a place for each path in tables on the device.

use crate::records::{BOUNCE_LIST_HEADS, BOUNCE_LISTS, BounceTables, IndirectPush};
use pt_core::error::Error;
use pt_core::frame::{Pass, RayCount, Uniforms};
use pt_core::memory::check_size;
use pt_core::split::split_size;
use pt_core::{Buffer, ChannelImages, Device, Frame, RayLists, Result, TableMemory, TableWish};
use pt_shaders::records::RayListHead;
use std::cell::RefCell;
use std::mem::offset_of;
use std::sync::Arc;

/// So that the bytes of a table count in 32 bits.
const MAX_PATHS: u64 = 1 << 28;
/// Bytes of a path in the tables of `uvec4`, `uvec2` and `uint`.
const ROW: u64 = 16;
const PAIR: u64 = 8;
const WORD: u64 = 4;

/// Tables whose content is lost when the last ray of the paths is traced.
const RAYS: [&str; 9] = [
    "bounce ray origins",
    "bounce ray directions",
    "throughputs of paths",
    "hits of bounce rays, origins of bounce shadow rays",
    "bounce shadow ray directions",
    "bounce shadow ray lights",
    "bounce ray list",
    "bounce ray list of odd vertices",
    "bounce shadow ray list",
];
const SOLIDS: [&str; 2] = ["solids of bounce rays", "ways of bounce rays"];
/// Those that reuse over time reads as the last.
const SHARES: &str = "shares of reusable light";
/// Those that the light of the pixels is summed from.
const SUMMED: [&str; 4] = [
    "reflectances of first surfaces",
    "directions of first rays",
    "light of paths",
    "reflected light of paths",
];
const REUSED: [&str; 2] = ["reusable light of paths", "points that first rays meet"];

/// All tables.
pub(crate) const TABLES: &[&str] = &[
    RAYS[0], RAYS[1], RAYS[2], RAYS[3], RAYS[4], RAYS[5], RAYS[6], RAYS[7], RAYS[8], SOLIDS[0], SOLIDS[1],
    SHARES, SUMMED[0], SUMMED[1], SUMMED[2], SUMMED[3], REUSED[0], REUSED[1],
];
/// Those that reuse over time reads.
pub(crate) const TABLES_OVER_TIME: &[&str] = &[SHARES];
/// Those that the sum reads.
pub(crate) const TABLES_OF_SUM: &[&str] = &[SUMMED[0], SUMMED[1], SUMMED[2], SUMMED[3], REUSED[0], REUSED[1]];

/// Makes the tables of a frame.
pub(crate) struct Bounces {
    device: Device,
    /// Whether paths can be inside of solids.
    has_solids: bool,
    /// Whether glass tints shadow rays.
    has_glass: bool,
    reuses: bool,
    memory: RefCell<TableMemory>,
    heads: RefCell<Option<Heads>>,
}

/// What is kept from frame to frame.
#[derive(Clone)]
struct Heads {
    lists: RayLists,
    buffer: Buffer,
    addresses: Arc<Uniforms<BounceTables>>,
}

/// Which list of paths a pass is launched over.
#[derive(Clone, Copy)]
#[repr(u32)]
pub(crate) enum List {
    Rays,
    ShadowRays,
    Glass,
}

/// Tables of a frame.
pub(crate) struct Tables {
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
    heads: Heads,
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

/// The tables of so many paths.
fn wishes(paths: u64, has_solids: bool, reuses: bool) -> Vec<TableWish> {
    let all: [(&[&'static str], &[u64], bool); 5] = [
        (&RAYS, &[ROW, ROW, ROW, ROW, ROW, PAIR, WORD, WORD, WORD], true),
        (&SUMMED, &[ROW, WORD, ROW, PAIR], true),
        (&SOLIDS, &[ROW, WORD], has_solids),
        (&REUSED, &[ROW, ROW], reuses),
        (&[SHARES], &[ROW], reuses),
    ];
    let kept = all.into_iter().filter(|(_, _, is_there)| *is_there);
    kept.flat_map(|(names, bytes, _)| names.iter().zip(bytes))
        .map(|(&name, bytes)| TableWish { name, bytes: paths * bytes })
        .collect()
}

impl Tables {
    fn new(
        bounces: &Bounces,
        images: Option<&ChannelImages>,
        frame: [u32; 2],
        is_half: bool,
    ) -> Result<Self> {
        let Bounces { device, has_solids, has_glass, reuses, .. } = bounces;
        let [width, _] = split_size(frame);
        let paths = path_count(frame, is_half);
        if paths > MAX_PATHS {
            return Err(Error::Unsupported(format!(
                "indirect lighting of a frame of {}x{}: at most {MAX_PATHS} paths are possible; ask for a smaller frame",
                frame[0], frame[1]
            )));
        }
        let wishes = wishes(paths, *has_solids, *reuses);
        let mut memory = bounces.memory.borrow_mut();
        let lists = RayLists::new(width, paths);
        let before = bounces.heads.borrow_mut().take().filter(|before| before.lists == lists);
        let heads = match before {
            Some(before) => before,
            None => {
                let bytes = memory.own_bytes(images, &wishes);
                let free = device.info().free_bytes();
                check_size("indirect lighting of a frame", frame, bytes, "the device", free)?;
                let heads = vec![lists.empty(); BOUNCE_LIST_HEADS as usize];
                Heads {
                    lists,
                    buffer: Buffer::from_slice(device, "bounce list heads", &heads)?,
                    addresses: Arc::new(Uniforms::new(device, "bounce tables")?),
                }
            }
        };
        *bounces.heads.borrow_mut() = Some(heads.clone());
        let mut table = |name: &str| match wishes.iter().find(|wish| wish.name == name) {
            Some(&wish) => memory.table(images, wish),
            None => Err(Error::Unsupported(format!("indirect lighting has no table {name}"))),
        };
        Ok(Self {
            origins: table(RAYS[0])?,
            directions: table(RAYS[1])?,
            throughputs: table(RAYS[2])?,
            hits_and_shadow_origins: table(RAYS[3])?,
            shadow_directions: table(RAYS[4])?,
            shadow_lights: table(RAYS[5])?,
            ray_lists: [table(RAYS[6])?, table(RAYS[7])?],
            shadow_list: table(RAYS[8])?,
            solids: match has_solids {
                true => Some([table(SOLIDS[0])?, table(SOLIDS[1])?]),
                false => None,
            },
            firsts: table(SUMMED[0])?,
            first_directions: table(SUMMED[1])?,
            lights: table(SUMMED[2])?,
            reflected: table(SUMMED[3])?,
            has_glass: *has_glass,
            reuse: match reuses {
                true => Some(ReuseTables {
                    reusable: table(REUSED[0])?,
                    points: table(REUSED[1])?,
                    shares: table(SHARES)?,
                }),
                false => None,
            },
            heads,
        })
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
            heads: self.heads.buffer.address(),
        }
    }

    /// Declares what every pass reads and writes besides whole tables: their addresses, and the heads of the lists.
    pub(crate) fn bind<'f, 'r>(&self, pass: Pass<'f, 'r>) -> Pass<'f, 'r> {
        pass.addresses(self.heads.addresses.buffer()).addresses_updated(&self.heads.buffer)
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
        let pass = pass.rays(RayCount::Listed(self.heads.buffer.clone(), count));
        pass.dispatch_indirect(self.heads.lists.trace_extent(), &self.heads.buffer, groups)
    }

    /// Launches a kernel that shades over a list.
    pub(crate) fn shade(&self, pass: Pass<'_, '_>, list: List, vertex: u32) -> Result<()> {
        let groups = head(list, vertex) + offset_of!(RayListHead, shading_groups) as u64;
        pass.dispatch_indirect(self.heads.lists.shading_extent(), &self.heads.buffer, groups)
    }
}

/// Where the head of a list stands among the heads.
fn head(list: List, vertex: u32) -> u64 {
    u64::from(vertex * BOUNCE_LISTS + list as u32) * size_of::<RayListHead>() as u64
}

impl Bounces {
    pub(crate) fn new(device: &Device, has_solids: bool, has_glass: bool, reuses: bool) -> Self {
        let memory = RefCell::new(TableMemory::new(device));
        Self { device: device.clone(), has_solids, has_glass, reuses, memory, heads: RefCell::new(None) }
    }

    /// The tables of a frame of `size` pixels.
    pub(crate) fn wishes(&self, size: [u32; 2], is_half: bool) -> Vec<TableWish> {
        wishes(path_count(size, is_half), self.has_solids, self.reuses)
    }

    /// Takes the tables of this frame, and tells the kernels where they are.
    pub(crate) fn prepare(
        &self,
        frame: &mut Frame<'_>,
        images: &ChannelImages,
        is_half: bool,
        push: &mut IndirectPush,
    ) -> Result<Tables> {
        let tables = Tables::new(self, Some(images), images.size(), is_half)?;
        let Heads { lists, addresses, .. } = &tables.heads;
        addresses.upload(frame, &tables.addresses())?;
        push.tables = addresses.buffer().address();
        push.columns = lists.columns();
        push.width = split_size(images.size())[0];
        Ok(tables)
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
            let bounces = Bounces::new(&device, true, true, true);
            Tables::new(&bounces, None, frame, false).err().expect("an error").to_string()
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

    fn path_bytes(has_solids: bool, reuses: bool) -> u64 {
        wishes(1, has_solids, reuses).iter().map(|wish| wish.bytes).sum()
    }

    /// The README states these, and that half a bounce takes half of them.
    #[test]
    fn bytes_are_those_of_the_readme() {
        assert_eq!([false, true].map(|has_solids| path_bytes(has_solids, false)), [144, 164]);
        assert_eq!([false, true].map(|has_solids| path_bytes(has_solids, true)), [192, 212]);
        assert_eq!([false, true].map(|is_half| path_count([64, 32], is_half)), [64 * 32, 64 * 16]);
    }

    #[test]
    fn stages_declare_all_tables() {
        let names: Vec<_> = wishes(1, true, true).iter().map(|wish| wish.name).collect();
        assert!(names.len() == TABLES.len() && names.iter().all(|name| TABLES.contains(name)));
    }
}
