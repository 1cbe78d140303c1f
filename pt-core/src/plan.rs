//! Declarations of stages: each stage declares once which images it reads, reads of the last frame, writes and updates. The
//! allocation, the checks before it, and the bindings of the passes follow from that declaration.

use crate::channels::{ChannelImages, Lacking, MemoryWish, TableWish, Wished};
use crate::device::Device;
use crate::error::{Error, Result};
use crate::kernel::Kernel;
use crate::layout::{LAST, Life};
use crate::sizes::FrameSizes;
use pt_shaders::channels::{ChannelId, Lifetime};
use std::collections::{BTreeMap, BTreeSet};

/// The images that a stage accesses: channels of the frame contract and its own private images.
#[derive(Clone, Copy, Debug)]
pub struct StageIo {
    /// Name of the stage, for messages.
    pub stage: &'static str,
    /// Only read, written earlier in the frame.
    pub reads: &'static [ChannelId],
    /// Content of the last frame, only read.
    pub reads_previous: &'static [ChannelId],
    /// Written without reading the old content.
    pub writes: &'static [ChannelId],
    /// Read and written in place.
    pub updates: &'static [ChannelId],
    /// Tables that its passes hand on to each other or to those of other stages, by name: their content lives from the first stage that names them to the last one.
    pub tables: &'static [&'static str],
}

impl StageIo {
    /// A stage that accesses nothing yet: `StageIo { reads: &[...], ..StageIo::of("composite") }`.
    pub const fn of(stage: &'static str) -> Self {
        Self { stage, reads: &[], reads_previous: &[], writes: &[], updates: &[], tables: &[] }
    }

    /// Checks that at least one of the stage's kernels accesses each declared image.
    ///
    /// # Errors
    /// [`Error::Unused`] for the first that none touches.
    pub fn check<'a>(&self, kernels: impl IntoIterator<Item = &'a Kernel>) -> Result<()> {
        let kernels: Vec<_> = kernels.into_iter().collect();
        let used = |names: [String; 2]| kernels.iter().any(|k| names.iter().any(|name| k.has_binding(name)));
        let current = [self.reads, self.writes, self.updates].into_iter().flatten();
        let current = current.map(|id| (id, [id.glsl_name(), id.glsl_sampler()]));
        let previous = self.reads_previous.iter();
        let previous = previous.map(|id| (id, [id.glsl_name_prev(), id.glsl_sampler_prev()]));
        match current.chain(previous).find(|(_, names)| !used(names.clone())) {
            Some((id, _)) => Err(Error::Unused { stage: self.stage.into(), channel: id.full_name() }),
            None => Ok(()),
        }
    }
}

/// Which images hold their content until the next frame begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    /// All, so that any can be read after the frame.
    All,
    /// Those that [`FramePlan::keep`] names, and what the next frame reads. Others share memory where one is written after the last stage
    /// that reads another.
    Outputs,
}

/// When the stages of a frame touch an image, by their numbers.
#[derive(Clone, Copy, Debug, Default)]
struct Uses {
    first: usize,
    last_write: usize,
    last_read: Option<usize>,
}

/// The stages of a frame in order, before anything is allocated.
#[derive(Clone, Debug)]
pub struct FramePlan {
    sizes: FrameSizes,
    /// Stages so far.
    count: usize,
    /// Images that the stages added so far write, with their uses.
    written: BTreeMap<ChannelId, Uses>,
    /// Images with lifetime `Carried`; no stage has to write them first.
    carried: BTreeSet<ChannelId>,
    /// Images whose content of the last frame is read: the stage that reads it last, by name and number.
    previous: BTreeMap<ChannelId, (&'static str, usize)>,
    kept: BTreeSet<ChannelId>,
    /// Tables with the first and the last stage that declares them.
    declared_tables: BTreeMap<&'static str, [usize; 2]>,
    tables: Vec<TableWish>,
}

impl FramePlan {
    /// A frame of these sizes without stages.
    pub fn new(sizes: FrameSizes) -> Self {
        let (written, carried, previous, kept, declared_tables) = Default::default();
        Self { sizes, count: 0, written, carried, previous, kept, declared_tables, tables: Vec::new() }
    }

    /// Declares images that a capture or a test fills.
    pub fn given(&mut self, channels: impl IntoIterator<Item = ChannelId>) {
        self.written.extend(channels.into_iter().map(|id| (id, Uses::default())));
    }

    /// Names images that are read after the frame.
    pub fn keep(&mut self, channels: impl IntoIterator<Item = ChannelId>) {
        self.kept.extend(channels);
    }

    /// Says how large the tables are that stages declare; others are not in the memory of the frame.
    pub fn tables(&mut self, tables: impl IntoIterator<Item = TableWish>) {
        self.tables.extend(tables);
    }

    /// Adds the next stage.
    ///
    /// # Errors
    /// [`Error::NoWriter`] when it reads what no stage before it writes.
    pub fn stage(&mut self, io: &StageIo) -> Result<()> {
        let now = self.count;
        for &id in io.reads.iter().chain(io.updates) {
            if id.channel().lifetime == Lifetime::Carried {
                self.carried.insert(id);
            } else if let Some(uses) = self.written.get_mut(&id) {
                uses.last_read = Some(now);
            } else {
                return Err(no_writer(io.stage, id, "which no stage before it writes"));
            }
        }
        for &id in io.writes.iter().chain(io.updates) {
            let first = Uses { first: now, last_write: now, last_read: None };
            self.written.entry(id).or_insert(first).last_write = now;
        }
        self.previous.extend(io.reads_previous.iter().map(|&id| (id, (io.stage, now))));
        for &table in io.tables {
            self.declared_tables.entry(table).or_insert([now; 2])[1] = now;
        }
        self.count += 1;
        Ok(())
    }

    /// Images that the stages read and that no stage before them writes. A replay has to load them.
    pub fn missing(&self, stages: &[StageIo]) -> BTreeSet<ChannelId> {
        let mut written: BTreeSet<_> = self.written.keys().copied().collect();
        let mut missing = BTreeSet::new();
        for io in stages {
            let carried = |id: &&ChannelId| id.channel().lifetime == Lifetime::Carried;
            let read = io.reads.iter().chain(io.updates).filter(|id| !carried(id));
            missing.extend(read.filter(|id| !written.contains(id)));
            written.extend(io.writes.iter().chain(io.updates));
        }
        let previous = stages.iter().flat_map(|io| io.reads_previous);
        missing.extend(previous.filter(|id| !written.contains(id)));
        missing
    }

    /// Allocates every image that the stages access; last frame's content is kept only where a stage reads it.
    ///
    /// # Errors
    /// [`Error::NoWriter`] when the last frame's content is read of an image that no stage writes; more than the device's
    /// memory, before any of it is taken.
    pub fn allocate(&self, device: &Device) -> Result<ChannelImages> {
        let mut planes = self.allocate_planes(device, self, 0, Kept::All)?;
        Ok(planes.remove(0))
    }

    /// The images of a frame of several planes: this plan is that of plane 0, of whose stages those of each of the `count` other planes follow
    /// the first ones, as `other` lists them.
    ///
    /// # Errors
    /// As [`FramePlan::allocate`], for all of them together.
    pub fn allocate_planes(
        &self,
        device: &Device,
        other: &Self,
        count: usize,
        kept: Kept,
    ) -> Result<Vec<ChannelImages>> {
        // After each plane comes the stage that adds it.
        let stages = other.count + 1;
        let behind = count * stages;
        let moment = |stage| if stage < other.count { stage } else { stage + behind };
        // What the stages of the first plane have written is needed until the others are added, that of the stages behind them until the end.
        let is_of_plane = |uses: &Uses| count > 0 && uses.last_write < other.count;
        let end = |uses: &Uses| if is_of_plane(uses) { other.count } else { LAST };
        let mut wishes = vec![self.wishes(device, kept, moment, end)?];
        for plane in 1..=count {
            let start = plane * stages;
            wishes.push(other.wishes(device, kept, |stage| start + stage, |_| start + other.count)?);
        }
        ChannelImages::allocate(device, self.sizes, wishes)
    }

    /// Every image and table that the stages access. `moment`: when a stage runs; `end`: until when images are needed that no stage reads after it was written.
    fn wishes(
        &self,
        device: &Device,
        kept: Kept,
        moment: impl Fn(usize) -> usize,
        end: impl Fn(&Uses) -> usize,
    ) -> Result<Vec<MemoryWish>> {
        for (&id, &(stage, _)) in &self.previous {
            if !self.written.contains_key(&id) && !self.carried.contains(&id) {
                return Err(no_writer(stage, id, "whose content of the last frame no stage writes"));
            }
        }
        let twice = |from, previous_until| Life::Twice { from, previous_until };
        let life = |id: &ChannelId, uses: &Uses| match (self.previous.get(id), kept) {
            // What nothing reads once this frame's is written needs no second image.
            (Some(&(_, last)), Kept::Outputs) if last < uses.first => Life::Kept,
            (Some(&(_, last)), Kept::Outputs) => twice(moment(uses.first), moment(last)),
            (Some(_), Kept::All) => twice(0, LAST),
            (None, Kept::All) => Life::Always,
            (None, Kept::Outputs) => {
                // Passes may bind what they write by another name, then no declaration says that it is read.
                if self.kept.contains(id) {
                    return Life::Within { from: moment(uses.first), until: LAST };
                }
                let read = uses.last_read.filter(|&read| read > uses.last_write);
                Life::Within { from: moment(uses.first), until: read.map_or_else(|| end(uses), &moment) }
            }
        };
        let written = self.written.iter().filter(|(id, _)| !self.carried.contains(id));
        let mut wishes: Vec<_> = written.map(|(&id, uses)| (id, life(&id, uses))).collect();
        wishes.extend(self.carried.iter().map(|&id| match self.previous.get(&id) {
            Some(_) => (id, twice(0, LAST)),
            None => (id, Life::Always),
        }));
        let wish = |(id, life): (ChannelId, Life)| {
            let extent = self.sizes.extent(id.channel().extent);
            MemoryWish { what: Wished::Image { id, extent, format: device.format(id) }, life }
        };
        let mut wishes: Vec<_> = wishes.into_iter().map(wish).collect();
        wishes.extend(self.tables.iter().filter_map(|&table| {
            let [from, until] = (*self.declared_tables.get(table.name)?).map(&moment);
            Some(MemoryWish { what: Wished::Table(table), life: Life::Within { from, until } })
        }));
        Ok(wishes)
    }
}

impl ChannelImages {
    /// Images of stages that run alone, in this order. The caller fills the images that no stage writes.
    ///
    /// # Errors
    /// As [`FramePlan::allocate`].
    pub fn alone(device: &Device, sizes: FrameSizes, stages: &[StageIo]) -> Result<Self> {
        let mut plan = FramePlan::new(sizes);
        plan.given(plan.missing(stages));
        stages.iter().try_for_each(|io| plan.stage(io))?;
        plan.allocate(device)
    }
}

fn no_writer(stage: &str, id: ChannelId, lacking: &'static str) -> Error {
    Error::NoWriter { stage: stage.into(), channel: id.full_name(), lacking }
}

impl From<Lacking> for String {
    fn from(lacking: Lacking) -> Self {
        let Lacking { channel, previous } = lacking;
        let which = if previous { "last frame's content of " } else { "" };
        format!(
            "{which}\"{}\" is not allocated: the stage's declaration does not name it",
            channel.full_name()
        )
    }
}
