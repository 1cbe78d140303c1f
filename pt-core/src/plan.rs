//! Declarations of stages: each stage declares once which images it reads, reads of the last frame, writes and updates. The
//! allocation, the checks before it, and the bindings of the passes follow from that declaration.

use crate::channels::{ChannelImages, Lacking, channel_bytes};
use crate::device::Device;
use crate::error::{Error, Result};
use crate::kernel::Kernel;
use crate::sizes::FrameSizes;
use pt_shaders::channels::{ChannelId, GbufferFormat, Lifetime};
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
}

impl StageIo {
    /// A stage that accesses nothing yet: `StageIo { reads: &[...], ..StageIo::of("composite") }`.
    pub const fn of(stage: &'static str) -> Self {
        Self { stage, reads: &[], reads_previous: &[], writes: &[], updates: &[] }
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

/// The stages of a frame in order, before anything is allocated.
#[derive(Clone, Debug)]
pub struct FramePlan {
    sizes: FrameSizes,
    /// Images that the stages added so far write.
    written: BTreeSet<ChannelId>,
    /// Images with lifetime `Carried`; no stage has to write them first.
    carried: BTreeSet<ChannelId>,
    /// Images whose content of the last frame is read, with the stage that reads it.
    previous: BTreeMap<ChannelId, &'static str>,
}

impl FramePlan {
    /// A frame of these sizes without stages.
    pub fn new(sizes: FrameSizes) -> Self {
        let (written, carried, previous) = Default::default();
        Self { sizes, written, carried, previous }
    }

    /// Declares images that a capture or a test fills.
    pub fn given(&mut self, channels: impl IntoIterator<Item = ChannelId>) {
        self.written.extend(channels);
    }

    /// Adds the next stage.
    ///
    /// # Errors
    /// [`Error::NoWriter`] when it reads what no stage before it writes.
    pub fn stage(&mut self, io: &StageIo) -> Result<()> {
        for &id in io.reads.iter().chain(io.updates) {
            if id.channel().lifetime == Lifetime::Carried {
                self.carried.insert(id);
            } else if !self.written.contains(&id) {
                return Err(no_writer(io.stage, id, "which no stage before it writes"));
            }
        }
        self.written.extend(io.writes.iter().chain(io.updates));
        self.previous.extend(io.reads_previous.iter().map(|&id| (id, io.stage)));
        Ok(())
    }

    /// Images that the stages read and that no stage before them writes. A replay has to load them.
    pub fn missing(&self, stages: &[StageIo]) -> BTreeSet<ChannelId> {
        let mut written = self.written.clone();
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
        self.allocate_beside(device, 0)
    }

    /// As [`FramePlan::allocate`], where other images of the frame take `other_bytes` besides.
    ///
    /// # Errors
    /// As [`FramePlan::allocate`], for all of them together.
    pub fn allocate_beside(&self, device: &Device, other_bytes: u64) -> Result<ChannelImages> {
        for (&id, &stage) in &self.previous {
            if !self.written.contains(&id) && !self.carried.contains(&id) {
                return Err(no_writer(stage, id, "whose content of the last frame no stage writes"));
            }
        }
        ChannelImages::allocate(device, self.sizes, self.images(), other_bytes)
    }

    /// Bytes of the images that [`FramePlan::allocate`] makes.
    pub fn bytes(&self, format: GbufferFormat) -> u64 {
        self.images().map(|(id, previous)| channel_bytes(id, format, self.sizes, previous)).sum()
    }

    /// Every image that the stages access, and whether last frame's content is kept.
    fn images(&self) -> impl Iterator<Item = (ChannelId, bool)> {
        self.written.union(&self.carried).map(|&id| (id, self.previous.contains_key(&id)))
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
