use crate::records::{ShadowStatisticsPush, StatisticsTable};
use pt_core::{Buffer, Device, Frame, Kernel, Location, Result, SceneResources};
use pt_shaders::records::SceneRecord;

/// Sides of the cube that a normal points to.
const SIDES: u64 = 6;
/// Most entries of a table that `auto` keeps dense, and entries of a hash table.
const AUTO_ENTRIES: u64 = 1 << 22;
/// Bytes of an entry: two counts, the history as two half floats, the key of a hash table.
const COUNT_BYTES: u64 = 8;
const WORD_BYTES: u64 = 4;
/// Threads in a row of a dispatch.
const ROW: u32 = 1 << 16;

/// Shadow statistics on the device: how many shadow rays of a cluster reached each light (`lights/statistics.glsl`).
pub struct ShadowStatistics {
    kernel: Kernel,
    counts: Buffer,
    history: Buffer,
    keys: Buffer,
    slots: u32,
    hashed: bool,
}

impl ShadowStatistics {
    /// Empty statistics.
    ///
    /// # Errors
    /// When the device has no memory left.
    pub fn new(device: &Device, clusters: usize, lights: usize, table: StatisticsTable) -> Result<Self> {
        let dense = clusters as u64 * lights.max(1) as u64 * SIDES;
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
        Ok(Self {
            kernel: Kernel::compute::<ShadowStatisticsPush>(device, &crate::kernels::SHADOW_STATISTICS, &[])?,
            counts: zeros("shadow counts", slots * COUNT_BYTES)?,
            history: zeros("shadow history", slots * WORD_BYTES)?,
            keys: zeros("shadow keys", if hashed { slots * WORD_BYTES } else { WORD_BYTES })?,
            slots: u32::try_from(slots).unwrap_or(u32::MAX),
            hashed,
        })
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        self.counts.size() + self.history.size() + self.keys.size()
    }

    /// Whether they are a hash table.
    pub fn is_sparse(&self) -> bool {
        self.hashed
    }

    pub(crate) fn buffers(&self) -> [&Buffer; 3] {
        [&self.counts, &self.history, &self.keys]
    }

    pub(crate) fn fill(&self, record: &mut SceneRecord) {
        record.shadow_counts = self.counts.address();
        record.shadow_history = self.history.address();
        record.shadow_keys = self.keys.address();
        record.shadow_count_slots = self.slots;
        record.shadow_counts_hashed = u32::from(self.hashed);
    }

    /// Adds the last frame's counts to the history, of which `frames` frames count.
    pub(crate) fn record(
        &self,
        frame: &mut Frame<'_>,
        scene: &dyn SceneResources,
        frames: u32,
    ) -> Result<()> {
        let width = self.slots.min(ROW);
        let pass = scene.bind(frame.pass("shadow statistics", &self.kernel));
        let pass = self.buffers().into_iter().fold(pass, |pass, buffer| pass.addresses_updated(buffer));
        let push = ShadowStatisticsPush { keep: 1.0 - 1.0 / frames.max(1) as f32, width };
        pass.push(&push).dispatch([width, self.slots.div_ceil(width.max(1)), 1])
    }
}
