use crate::cluster_lists::ClusterBox;
use crate::records::{ClusterSubsetsPush, ShadowStatisticsPush, StatisticsTable};
use glam::Vec4;
use pt_core::{Buffer, Device, Frame, Kernel, Location, Result, SceneResources};
use pt_shaders::records::{LightTablesRecord, MAX_SUBSETS, SceneRecord};

/// Sides of the cube that a normal points to.
const SIDES: u64 = 6;
/// Most entries of a table that `auto` keeps dense, and entries of a hash table.
const AUTO_ENTRIES: u64 = 1 << 22;
/// Bytes of two counts, and of a word: the history as two half floats, the key of a hash table.
const COUNT_BYTES: u64 = 8;
const WORD_BYTES: u64 = 4;
/// Words of a row of `lights/subsets.glsl`.
const SUBSET_ROW: u64 = MAX_SUBSETS as u64 + 1;
/// Threads of a group of `cluster_subsets.comp`.
const WEIGH_GROUP: u32 = 32;
/// Threads in a row of a dispatch.
const ROW: u32 = 1 << 16;

/// Shadow statistics on the device: how many shadow rays of a cluster reached each light (`lights/statistics.glsl`).
pub struct ShadowStatistics {
    /// As they were in the last frame, if asked for.
    last: Option<LastStatistics>,
    kernel: Kernel,
    counts: Buffer,
    /// The history of each entry; in a hash table after its key, so that both are in one sector of a cache.
    entries: Buffer,
    slots: u32,
    hashed: bool,
    weigh: Kernel,
    subsets: Buffer,
    balls: Buffer,
    clusters: u32,
    /// Frames between two visits of an entry and of a cluster.
    interval: u32,
    frame: u32,
}

/// What the choices of the last frame read. A frame changes a part of each table, which the next one copies first: that brings the copy up to
/// that frame. Keys claimed meanwhile in other parts have no history, which is as if they were not there.
struct LastStatistics {
    entries: Buffer,
    subsets: Buffer,
    /// Entries, and clusters, that the last frame has changed: the first one, and how many.
    changed: (u32, u32),
    clusters: (u32, u32),
}

impl ShadowStatistics {
    /// Empty statistics of clusters, of which each is worked on in every `interval`th frame. `lights`: most local lights there may be;
    /// `keeps_last`: those of the last frame are kept too.
    ///
    /// # Errors
    /// When the device has no memory left.
    pub fn new(
        device: &Device,
        boxes: &[ClusterBox],
        lights: usize,
        table: StatisticsTable,
        interval: u32,
        keeps_last: bool,
    ) -> Result<Self> {
        let clusters = boxes.len() as u64;
        let dense = clusters * lights.max(1) as u64 * SIDES;
        let hashed = match table {
            StatisticsTable::Dense => false,
            StatisticsTable::Sparse => true,
            StatisticsTable::Auto => dense > AUTO_ENTRIES,
        };
        let slots = if hashed { AUTO_ENTRIES } else { dense };
        let zeros = |name, bytes: u64| {
            let buffer = Buffer::new(device, name, bytes, Location::Device)?;
            buffer.write_through_staging(&vec![0; bytes as usize])?;
            Ok::<_, pt_core::Error>(buffer)
        };
        let entry_bytes = slots * if hashed { 2 * WORD_BYTES } else { WORD_BYTES };
        let subset_bytes = clusters * SIDES * SUBSET_ROW * WORD_BYTES;
        let last = || {
            Ok::<_, pt_core::Error>(LastStatistics {
                entries: zeros("shadow history of the last frame", entry_bytes)?,
                subsets: zeros("subsets of cluster lists of the last frame", subset_bytes)?,
                changed: (0, 0),
                clusters: (0, 0),
            })
        };
        Ok(Self {
            last: keeps_last.then(last).transpose()?,
            kernel: Kernel::compute::<ShadowStatisticsPush>(device, &crate::kernels::SHADOW_STATISTICS, &[])?,
            counts: zeros("shadow counts", slots * COUNT_BYTES)?,
            entries: zeros("shadow history", entry_bytes)?,
            slots: u32::try_from(slots).unwrap_or(u32::MAX),
            hashed,
            weigh: Kernel::compute::<ClusterSubsetsPush>(device, &crate::kernels::CLUSTER_SUBSETS, &[])?,
            subsets: zeros("subsets of cluster lists", subset_bytes)?,
            balls: Buffer::from_slice(
                device,
                "clusters as balls",
                &boxes.iter().map(ball).collect::<Vec<_>>(),
            )?,
            clusters: boxes.len() as u32,
            interval: interval.max(1),
            frame: 0,
        })
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        self.buffers().map(Buffer::size).sum()
    }

    /// Whether they are a hash table.
    pub fn is_sparse(&self) -> bool {
        self.hashed
    }

    /// What kernels that count shadow rays write.
    pub(crate) fn counted(&self) -> [&Buffer; 2] {
        [&self.counts, &self.entries]
    }

    pub(crate) fn buffers(&self) -> impl Iterator<Item = &Buffer> {
        let last = self.last.iter().flat_map(|last| [&last.entries, &last.subsets]);
        [&self.counts, &self.entries, &self.subsets, &self.balls].into_iter().chain(last)
    }

    pub(crate) fn fill(&self, record: &mut SceneRecord) {
        record.shadow_counts = self.counts.address();
        (record.light_tables.shadow_keys, record.light_tables.shadow_history) = self.addresses(&self.entries);
        record.light_tables.cluster_subsets = self.subsets.address();
        record.shadow_count_slots = self.slots;
        record.shadow_counts_hashed = u32::from(self.hashed);
    }

    /// Where the keys of entries begin, and where their history.
    fn addresses(&self, entries: &Buffer) -> (u64, u64) {
        let address = entries.address();
        (address, if self.hashed { address + WORD_BYTES } else { address })
    }

    /// Forgets all that has been counted, and waits: the next frame is that of new statistics.
    pub(crate) fn forget(&mut self) -> Result<()> {
        let last = self.last.iter().flat_map(|last| [&last.entries, &last.subsets]);
        for buffer in [&self.counts, &self.entries, &self.subsets].into_iter().chain(last) {
            buffer.write_through_staging(&vec![0; buffer.size() as usize])?;
        }
        if let Some(last) = &mut self.last {
            (last.changed, last.clusters) = ((0, 0), (0, 0));
        }
        self.frame = 0;
        Ok(())
    }

    /// Sets the addresses of what the last frame has read, if it is kept.
    pub(crate) fn fill_last(&self, record: &mut LightTablesRecord) {
        if let Some(last) = &self.last {
            (record.shadow_keys, record.shadow_history) = self.addresses(&last.entries);
            record.cluster_subsets = last.subsets.address();
        }
    }

    /// Copies what the last frame has changed.
    fn keep_last(&self, frame: &mut Frame<'_>) -> Result<()> {
        let Some(last) = &self.last else { return Ok(()) };
        let (first, count) = (u64::from(last.changed.0), u64::from(last.changed.1));
        let bytes = if self.hashed { 2 * WORD_BYTES } else { WORD_BYTES };
        frame.copy_part(&self.entries, &last.entries, first * bytes, count * bytes)?;
        let row = SIDES * SUBSET_ROW * WORD_BYTES;
        let (first, count) = (u64::from(last.clusters.0), u64::from(last.clusters.1));
        frame.copy_part(&self.subsets, &last.subsets, first * row, count * row)
    }

    /// Adds what has been counted to the history, of which `frames` frames count, and weighs the subsets of the lists.
    pub(crate) fn record(
        &mut self,
        frame: &mut Frame<'_>,
        scene: &dyn SceneResources,
        frames: u32,
    ) -> Result<()> {
        self.keep_last(frame)?;
        let (turn, every) = (self.frame % self.interval, self.interval);
        let fresh = self.frame == 0;
        self.frame += 1;
        let part = |total: u32| {
            let size = total.div_ceil(every);
            let first = (turn * size).min(total);
            (first, size.min(total - first))
        };
        let entries = if fresh { (0, 0) } else { part(self.slots) };
        let clusters = if fresh { (0, self.clusters) } else { part(self.clusters) };
        if let Some(last) = &mut self.last {
            (last.changed, last.clusters) = (entries, clusters);
        }
        if !fresh {
            let (first, count) = entries;
            let width = count.min(ROW);
            // A visit stands for `every` frames.
            let keep = (1.0 - 1.0 / frames.max(1) as f32).powi(every as i32);
            let pass = scene.bind(frame.pass("shadow statistics", &self.kernel));
            let written = [&self.counts, &self.entries];
            let pass = written.into_iter().fold(pass, |pass, buffer| pass.addresses_updated(buffer));
            let push = ShadowStatisticsPush { keep, width, first, count };
            pass.push(&push).dispatch([width, count.div_ceil(width.max(1)), 1])?;
        }
        let (first, count) = clusters;
        let push = ClusterSubsetsPush { balls: self.balls.address(), first, clusters: first + count };
        let pass = scene.bind(frame.pass("subsets of light lists", &self.weigh));
        pass.addresses_written(&self.subsets).push(&push).dispatch([SIDES as u32 * WEIGH_GROUP, count, 1])
    }
}

/// Centre and radius of a cluster's box.
fn ball(cluster: &ClusterBox) -> Vec4 {
    let bounds = cluster.bounds;
    bounds.center().extend(0.5 * bounds.size().length())
}
