use crate::cluster_lists::{ClusterLists, ListLimits, ListUpdate, changing_lights, cluster_boxes};
use crate::statistics::ShadowStatistics;
use crate::{DirectParams, LightLists};
use pt_core::{Buffer, Device, Frame, Location, Result, SceneResources};
use pt_scene::{Clusters, Scene};
use pt_shaders::records::{ClusterListRecord, LightSampler, RisSource, SceneRecord};

/// What a light sampler needs besides the lights: the lists of the clusters, and statistics.
pub struct SamplerTables {
    lists: Option<DeviceLists>,
    statistics: Option<ShadowStatistics>,
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
    /// The tables of the sampler that `params` asks for.
    ///
    /// # Errors
    /// When the device has no memory left.
    pub fn new(
        device: &Device,
        scene: &Scene,
        clusters: &Clusters,
        lights: &LightLists,
        params: &DirectParams,
    ) -> Result<Self> {
        let (listed, counted) = match params.sampler {
            LightSampler::ClusterCdf => (true, false),
            LightSampler::ClusterStats => (true, true),
            LightSampler::Ris => (params.ris_source == RisSource::Cluster, false),
            LightSampler::Uniform | LightSampler::Power | LightSampler::NeeAt => (false, false),
        };
        let statistics =
            || ShadowStatistics::new(device, clusters.count(), lights.local.len(), params.statistics_table);
        Ok(Self {
            lists: listed.then(|| DeviceLists::new(device, scene, clusters, lights)).transpose()?,
            statistics: counted.then(statistics).transpose()?,
        })
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        self.buffers().iter().map(|buffer| buffer.size()).sum()
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
        lists.chain(self.statistics.iter().flat_map(|s| s.buffers())).collect()
    }

    pub(crate) fn fill(&self, record: &mut SceneRecord) {
        if let Some(lists) = &self.lists {
            record.cluster_lists = lists.records.address();
            record.cluster_entries = lists.fixed.address();
            record.cluster_moving_entries = lists.changing.address();
        }
        record.shadow_count_slots = 0;
        if let Some(statistics) = &self.statistics {
            statistics.fill(record);
        }
    }

    /// Brings the lists to where the lights are now.
    pub(crate) fn update(&mut self, frame: &mut Frame<'_>, lights: &LightLists) -> Result<()> {
        match &mut self.lists {
            Some(lists) => lists.update(frame, lights),
            None => Ok(()),
        }
    }

    /// Begins the statistics of a frame.
    pub(crate) fn record(
        &self,
        frame: &mut Frame<'_>,
        scene: &dyn SceneResources,
        frames: u32,
    ) -> Result<()> {
        match &self.statistics {
            Some(statistics) => statistics.record(frame, scene, frames),
            None => Ok(()),
        }
    }
}

impl DeviceLists {
    fn new(device: &Device, scene: &Scene, clusters: &Clusters, lights: &LightLists) -> Result<Self> {
        let boxes = cluster_boxes(scene, clusters);
        let may_change = changing_lights(scene, &lights.emissives);
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
