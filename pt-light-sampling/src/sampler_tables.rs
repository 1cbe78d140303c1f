use crate::cluster_lists::{ClusterLists, ListLimits, ListUpdate, changing_lights, cluster_boxes};
use crate::records::StatisticsTable;
use crate::statistics::ShadowStatistics;
use crate::{LightBvh, LightLists, NO_TRAIL};
use pt_core::{Buffer, Device, Frame, Location, Result, SceneResources};
use pt_scene::{Clusters, Scene};
use pt_shaders::records::{ClusterListRecord, LightBvhNode, LightSampler, RisSource, SceneRecord};

/// A light sampler, as far as its tables depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SamplerChoice {
    /// How a light is picked.
    pub sampler: LightSampler,
    /// Where the candidates of [`LightSampler::Ris`] come from.
    pub ris_source: RisSource,
    /// How shadow statistics are stored.
    pub statistics_table: StatisticsTable,
    /// Frames that they reach back, from 1 on.
    pub statistics_frames: u32,
    /// Frames between two visits of a cluster.
    pub statistics_interval: u32,
    /// Whether the quads of the environment are among the local lights.
    pub environment_listed: bool,
}

impl From<LightSampler> for SamplerChoice {
    /// With sixteen frames of statistics, candidates from the cluster, and the environment apart.
    fn from(sampler: LightSampler) -> Self {
        Self {
            sampler,
            ris_source: RisSource::Cluster,
            statistics_table: StatisticsTable::Auto,
            statistics_frames: 16,
            statistics_interval: 4,
            environment_listed: false,
        }
    }
}

/// What a light sampler needs besides the lights: the lists of the clusters, and statistics.
pub struct SamplerTables {
    lists: Option<DeviceLists>,
    tree: Option<DeviceTree>,
    statistics: Option<ShadowStatistics>,
    statistics_frames: u32,
}

/// The light tree on the device.
struct DeviceTree {
    host: Option<LightBvh>,
    nodes: Buffer,
    trails: Buffer,
    uploaded: bool,
}

/// The lists of all clusters on the device.
struct DeviceLists {
    host: ClusterLists,
    records: Buffer,
    fixed: Buffer,
    changing: Buffer,
    may_change: Vec<bool>,
    uploaded: bool,
    scratch: Vec<ClusterListRecord>,
}

impl SamplerTables {
    /// The tables of a sampler.
    ///
    /// # Errors
    /// When the device has no memory left.
    pub fn new(
        device: &Device,
        scene: &Scene,
        clusters: &Clusters,
        lights: &LightLists,
        choice: SamplerChoice,
    ) -> Result<Self> {
        let counted = choice.sampler == LightSampler::ClusterStats;
        let listed = match choice.sampler {
            LightSampler::ClusterCdf | LightSampler::ClusterStats => true,
            LightSampler::Ris | LightSampler::RestirDi => choice.ris_source == RisSource::Cluster,
            LightSampler::Uniform | LightSampler::Power | LightSampler::LightBvh | LightSampler::NeeAt => {
                false
            }
        };
        let tree = choice.sampler == LightSampler::LightBvh;
        let statistics = || {
            let boxes = cluster_boxes(scene, clusters);
            let SamplerChoice { statistics_table: table, statistics_interval: interval, .. } = choice;
            ShadowStatistics::new(device, &boxes, lights.local.len(), table, interval)
        };
        Ok(Self {
            lists: listed.then(|| DeviceLists::new(device, scene, clusters, lights)).transpose()?,
            tree: tree.then(|| DeviceTree::new(device, lights)).transpose()?,
            statistics: counted.then(statistics).transpose()?,
            statistics_frames: choice.statistics_frames,
        })
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        self.buffers().iter().map(|buffer| buffer.size()).sum()
    }

    /// Forgets what the sampler has learned.
    pub(crate) fn forget(&mut self) -> Result<()> {
        self.statistics.as_mut().map_or(Ok(()), ShadowStatistics::forget)
    }

    /// The statistics, if the sampler keeps any.
    pub fn statistics(&self) -> Option<&ShadowStatistics> {
        self.statistics.as_ref()
    }

    /// The lists, if the sampler has any.
    pub fn lists(&self) -> Option<&ClusterLists> {
        self.lists.as_ref().map(|lists| &lists.host)
    }

    pub(crate) fn buffers(&self) -> Vec<&Buffer> {
        let lists = self.lists.iter().flat_map(|l| [&l.records, &l.fixed, &l.changing]);
        let tree = self.tree.iter().flat_map(|t| [&t.nodes, &t.trails]);
        lists.chain(tree).chain(self.statistics.iter().flat_map(|s| s.buffers())).collect()
    }

    pub(crate) fn fill(&self, record: &mut SceneRecord) {
        if let Some(lists) = &self.lists {
            record.cluster_lists = lists.records.address();
            record.cluster_entries = lists.fixed.address();
            record.cluster_moving_entries = lists.changing.address();
        }
        if let Some(tree) = &self.tree {
            record.light_bvh = tree.nodes.address();
            record.light_bvh_trails = tree.trails.address();
            let power = tree.host.as_ref().map_or(0.0, LightBvh::power);
            record.light_bvh_power = power.min(f32::MAX.into()) as f32;
        }
        record.shadow_count_slots = 0;
        if let Some(statistics) = &self.statistics {
            statistics.fill(record);
        }
    }

    /// Brings lists and tree to where the lights are now.
    pub(crate) fn update(&mut self, frame: &mut Frame<'_>, lights: &LightLists, moved: bool) -> Result<()> {
        if let Some(lists) = &mut self.lists {
            lists.update(frame, lights)?;
        }
        match &mut self.tree {
            Some(tree) => tree.update(frame, lights, moved),
            None => Ok(()),
        }
    }

    /// Begins the statistics of a frame.
    pub(crate) fn record(&mut self, frame: &mut Frame<'_>, scene: &dyn SceneResources) -> Result<()> {
        match &mut self.statistics {
            Some(statistics) => statistics.record(frame, scene, self.statistics_frames),
            None => Ok(()),
        }
    }
}

impl DeviceTree {
    fn new(device: &Device, lights: &LightLists) -> Result<Self> {
        let count = lights.local.len();
        let buffer = |name, bytes: usize| Buffer::new(device, name, bytes as u64, Location::Device);
        Ok(Self {
            host: LightBvh::new(&lights.local),
            nodes: buffer("light tree", LightBvh::max_nodes(count).max(1) * size_of::<LightBvhNode>())?,
            trails: buffer("trails of the light tree", count.max(1) * size_of::<u64>())?,
            uploaded: false,
        })
    }

    /// Refits the tree, and builds another one when that does not do: lights that were dark are not in it.
    fn update(&mut self, frame: &mut Frame<'_>, lights: &LightLists, moved: bool) -> Result<()> {
        if !moved && self.uploaded {
            return Ok(());
        }
        if !self.host.as_mut().is_some_and(|tree| tree.refit(&lights.local)) {
            self.host = LightBvh::new(&lights.local);
        }
        self.uploaded = true;
        let Some(tree) = &self.host else {
            // More lights than the links of a tree can tell apart: nothing is picked.
            frame.upload(&self.trails, bytemuck::cast_slice(&vec![NO_TRAIL; lights.local.len()]))?;
            return frame
                .upload(&self.nodes, bytemuck::bytes_of(&<LightBvhNode as bytemuck::Zeroable>::zeroed()));
        };
        frame.upload(&self.nodes, bytemuck::cast_slice(tree.nodes()))?;
        frame.upload(&self.trails, bytemuck::cast_slice(tree.trails()))
    }
}

impl DeviceLists {
    fn new(device: &Device, scene: &Scene, clusters: &Clusters, lights: &LightLists) -> Result<Self> {
        let boxes = cluster_boxes(scene, clusters);
        let mut may_change = changing_lights(scene, &lights.emissives);
        // The intensity and rotation of the environment are whatever the caller sets in a frame.
        may_change.resize(lights.local.len(), true);
        let limits = ListLimits::default();
        let changing = may_change.iter().filter(|may| **may).count();
        let room = (changing * boxes.len()).min(limits.max_entries) * size_of::<u32>();
        let host = ClusterLists::new(boxes, &lights.local, &may_change, limits, None);
        let records = (host.count() * size_of::<ClusterListRecord>()) as u64;
        let buffer = |name, bytes| Buffer::new(device, name, bytes, Location::Device);
        Ok(Self {
            records: buffer("cluster lists", records)?,
            fixed: Buffer::from_slice(device, "lights of clusters", &host.fixed.entries)?,
            changing: buffer("changing lights of clusters", room as u64)?,
            may_change,
            uploaded: false,
            scratch: Vec::with_capacity(host.count()),
            host,
        })
    }

    fn update(&mut self, frame: &mut Frame<'_>, lights: &LightLists) -> Result<()> {
        let change = self.host.update(&lights.local, &self.may_change, None);
        if change == ListUpdate::Nothing && self.uploaded {
            return Ok(());
        }
        self.uploaded = true;
        let ClusterLists { fixed, changing, catch_all, .. } = &self.host;
        let ends = fixed.offsets.windows(2).zip(changing.offsets.windows(2));
        self.scratch.clear();
        self.scratch.extend(ends.zip(catch_all).map(|((fixed, changing), &catch_all)| ClusterListRecord {
            first: fixed[0],
            count: fixed[1] - fixed[0],
            moving_first: changing[0],
            moving_count: changing[1] - changing[0],
            catch_all,
        }));
        frame.upload(&self.records, bytemuck::cast_slice(&self.scratch))?;
        if !changing.entries.is_empty() {
            frame.upload(&self.changing, bytemuck::cast_slice(&changing.entries))?;
        }
        Ok(())
    }
}
