use crate::cluster_lists::{
    ClusterBox, ClusterLists, ListLimits, ListUpdate, VisibilityEstimate, Visible, cluster_boxes, rank_words,
    ranks, subset_by_subset,
};
use crate::records::{ListVisibility, StatisticsTable};
use crate::statistics::ShadowStatistics;
use crate::table::Table;
use crate::{LightBounds, LightBvh, LightLists, NO_TRAIL};
use pt_core::{Buffer, Device, Frame, Result, SceneResources};
use pt_scene::{Clusters, Scene};
use pt_shaders::records::{
    ClusterListRecord, LightBvhNode, LightSampler, LightTablesRecord, RisSource, SceneRecord,
};

/// Most bytes of the places of lights in the lists; with more, kernels search for them.
const MAX_RANK_BYTES: usize = 32 << 20;

/// A light sampler, as far as its tables depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SamplerChoice {
    /// How a light is picked.
    pub sampler: LightSampler,
    /// Where the candidates of [`LightSampler::Ris`] come from.
    pub ris_source: RisSource,
    /// Whether lists leave out what is hidden.
    pub list_visibility: ListVisibility,
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
    /// With sixteen frames of statistics, candidates from the cluster, lists without visibility, and the environment apart.
    fn from(sampler: LightSampler) -> Self {
        Self {
            sampler,
            ris_source: RisSource::Cluster,
            list_visibility: ListVisibility::Off,
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
    nodes: Table,
    trails: Table,
    uploaded: bool,
}

/// Which lights clusters see, of those that are where they were when this was made.
struct Seen {
    estimate: VisibilityEstimate,
    /// Index of the first point or spot light, and where these were.
    first: usize,
    positional: Vec<LightBounds>,
}

impl Seen {
    fn new(scene: &Scene, clusters: &Clusters, boxes: &[ClusterBox], lights: &LightLists) -> Result<Self> {
        let first = lights.first_positional();
        let estimate = VisibilityEstimate::new(scene, clusters, boxes, &lights.emissives)?;
        Ok(Self { estimate, first, positional: lights.local[first..].to_vec() })
    }

    /// Whether a cluster may see a local light. Of a light that has changed since, nothing is known. The estimate has no quads of the environment,
    /// which stand between the triangles and the other lights; lists do not ask about them, because they may change.
    fn visible(&self, lights: &LightLists, cluster: u32, light: u32) -> bool {
        let Some(place) = (light as usize).checked_sub(self.first) else {
            return self.estimate.visible(cluster, light);
        };
        let same = self.positional.get(place) == lights.local.get(light as usize);
        !same || self.estimate.visible(cluster, light - lights.quad_count() as u32)
    }
}

/// The lists of all clusters on the device.
struct DeviceLists {
    host: ClusterLists,
    /// What clusters see, if the lists ask for it. Kept, because lists may be built again.
    visibility: Option<Seen>,
    records: Table,
    fixed: Table,
    /// Places of the lights that stand still; `None`: there would be too many words.
    ranks: Option<Table>,
    rank_words: usize,
    changing: Table,
    uploaded: bool,
    scratch: Vec<ClusterListRecord>,
}

impl SamplerTables {
    /// The tables of a sampler, with room for `most_lights` local lights. `keeps_last`: those of the last frame are kept too.
    ///
    /// # Errors
    /// When the device has no memory left.
    pub fn new(
        device: &Device,
        scene: &Scene,
        clusters: &Clusters,
        lights: &LightLists,
        choice: SamplerChoice,
        most_lights: usize,
        keeps_last: bool,
    ) -> Result<Self> {
        let needed = choice.sampler.tables(choice.ris_source);
        let lists = || {
            let with_visibility = choice.list_visibility == ListVisibility::Rays;
            DeviceLists::new(device, scene, clusters, lights, most_lights, (keeps_last, with_visibility))
        };
        let statistics = || {
            let boxes = cluster_boxes(scene, clusters);
            let SamplerChoice { statistics_table: table, statistics_interval: interval, .. } = choice;
            ShadowStatistics::new(device, &boxes, most_lights, table, interval, keeps_last)
        };
        Ok(Self {
            lists: needed.lists.then(lists).transpose()?,
            tree: needed
                .tree
                .then(|| DeviceTree::new(device, lights, most_lights, keeps_last))
                .transpose()?,
            statistics: needed.statistics.then(statistics).transpose()?,
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
        let lists =
            self.lists.iter().flat_map(|l| [&l.records, &l.fixed, &l.changing].into_iter().chain(&l.ranks));
        let tree = self.tree.iter().flat_map(|t| [&t.nodes, &t.trails]);
        lists
            .chain(tree)
            .flat_map(Table::copies)
            .chain(self.statistics.iter().flat_map(|s| s.buffers()))
            .collect()
    }

    pub(crate) fn fill(&self, record: &mut SceneRecord) {
        if let Some(lists) = &self.lists {
            record.light_tables.cluster_lists = lists.records.address();
            record.light_tables.cluster_entries = lists.fixed.address();
            record.light_tables.cluster_moving_entries = lists.changing.address();
            record.light_tables.cluster_ranks = lists.ranks.as_ref().map_or(0, Table::address);
            record.light_tables.cluster_rank_words = lists.rank_words as u32;
        }
        if let Some(tree) = &self.tree {
            record.light_tables.light_bvh = tree.nodes.address();
            record.light_tables.light_bvh_trails = tree.trails.address();
            let power = tree.host.as_ref().map_or(0.0, LightBvh::power);
            record.light_tables.light_bvh_power = power.min(f32::MAX.into()) as f32;
        }
        record.shadow_count_slots = 0;
        if let Some(statistics) = &self.statistics {
            statistics.fill(record);
        }
    }

    /// Completes the addresses of the last frame's tables: `record` holds those that [`SamplerTables::fill`] gave to the last frame, and
    /// statistics are not replaced but updated in place.
    pub(crate) fn fill_last(&self, record: &mut LightTablesRecord) {
        if let Some(statistics) = &self.statistics {
            statistics.fill_last(record);
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
    fn new(device: &Device, lights: &LightLists, most_lights: usize, keeps_last: bool) -> Result<Self> {
        let table = |name, bytes: usize| Table::new(device, name, bytes, keeps_last);
        let nodes = LightBvh::max_nodes(most_lights).max(1);
        Ok(Self {
            host: LightBvh::new(&lights.local),
            nodes: table("light tree", nodes * size_of::<LightBvhNode>())?,
            trails: table("trails of the light tree", most_lights.max(1) * size_of::<u64>())?,
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
            let trails = vec![NO_TRAIL; lights.local.len()];
            frame.upload(self.trails.replace(), bytemuck::cast_slice(&trails))?;
            let node = <LightBvhNode as bytemuck::Zeroable>::zeroed();
            return frame.upload(self.nodes.replace(), bytemuck::bytes_of(&node));
        };
        frame.upload(self.nodes.replace(), bytemuck::cast_slice(tree.nodes()))?;
        frame.upload(self.trails.replace(), bytemuck::cast_slice(tree.trails()))
    }
}

impl DeviceLists {
    fn new(
        device: &Device,
        scene: &Scene,
        clusters: &Clusters,
        lights: &LightLists,
        most_lights: usize,
        (keeps_last, with_visibility): (bool, bool),
    ) -> Result<Self> {
        let boxes = cluster_boxes(scene, clusters);
        let visibility = with_visibility.then(|| Seen::new(scene, clusters, &boxes, lights)).transpose()?;
        let limits = ListLimits::default();
        let room = (most_lights * boxes.len()).min(limits.max_entries) * size_of::<u32>();
        let sees = visibility.as_ref().map(|seen| move |cluster, light| seen.visible(lights, cluster, light));
        let sees = sees.as_ref().map(|sees| sees as &Visible<'_>);
        let host = ClusterLists::new(boxes, &lights.local, &lights.may_change, limits, sees);
        let table = |name, bytes| Table::new(device, name, bytes, keeps_last);
        let rank_words = rank_words(most_lights);
        let rank_bytes = host.count() * rank_words * size_of::<[u32; 2]>();
        let ranks = (rank_bytes <= MAX_RANK_BYTES).then(|| table("places of lights in lists", rank_bytes));
        Ok(Self {
            ranks: ranks.transpose()?,
            rank_words,
            records: table("cluster lists", host.count() * size_of::<ClusterListRecord>())?,
            fixed: table("lights of clusters", room)?,
            changing: table("changing lights of clusters", room)?,
            uploaded: false,
            scratch: Vec::with_capacity(host.count()),
            visibility,
            host,
        })
    }

    fn update(&mut self, frame: &mut Frame<'_>, lights: &LightLists) -> Result<()> {
        let sees =
            self.visibility.as_ref().map(|seen| move |cluster, light| seen.visible(lights, cluster, light));
        let sees = sees.as_ref().map(|sees| sees as &Visible<'_>);
        let change = self.host.update(&lights.local, &lights.may_change, sees);
        let is_first = !std::mem::replace(&mut self.uploaded, true);
        if change == ListUpdate::Nothing && !is_first {
            return Ok(());
        }
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
        frame.upload(self.records.replace(), bytemuck::cast_slice(&self.scratch))?;
        if change == ListUpdate::All || is_first {
            let entries = subset_by_subset(fixed);
            frame.upload(self.fixed.replace(), bytemuck::cast_slice(&entries))?;
            if let Some(table) = &mut self.ranks {
                let ranks = ranks(fixed, self.rank_words);
                frame.upload(table.replace(), bytemuck::cast_slice(&ranks))?;
            }
        }
        frame.upload(self.changing.replace(), bytemuck::cast_slice(&changing.entries))
    }
}
