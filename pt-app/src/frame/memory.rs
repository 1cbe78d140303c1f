//! What a frame takes of the device's memory, by stage.

use super::{FrameStage, FullFrame};
use pt_core::channels::SHARED;
use pt_core::frame::PassInfo;
use serde::Serialize;
use std::collections::BTreeMap;

/// Device memory of a frame: the allocations that were made for it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameMemory {
    /// Bytes of all of them.
    pub bytes: u64,
    /// The same for each pixel of the picture.
    pub bytes_a_pixel: f64,
    /// By the stage that writes them first, in the order of the frame.
    pub stages: Vec<StageMemory>,
}

/// Device memory of a stage.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageMemory {
    /// Name of the stage, or what several of them use.
    pub stage: String,
    /// Bytes of its allocations.
    pub bytes: u64,
    /// The same for each pixel of the picture.
    pub bytes_a_pixel: f64,
    /// Its allocations by name, the largest first. Last frame's content of an image counts as the image.
    pub allocations: Vec<(String, u64)>,
}

/// Device memory by name and bytes, as [`pt_core::Device::memory_in_use`] reports it.
type Allocations = Vec<(String, u64)>;

impl FullFrame {
    /// What was allocated for the frame. `before` and `after`: the allocations of the device before the frame was made and after `passes`, its
    /// last ones, were recorded.
    pub fn memory(&self, before: &Allocations, after: Allocations, passes: &[PassInfo]) -> FrameMemory {
        let [width, height] = self.images().output_size();
        let pixels = f64::from(width) * f64::from(height);
        let stages = self.pass_stages();
        let stage_of = |name: &str| {
            if name == SHARED {
                return (FrameStage::Scene.code(), "all, in turn");
            }
            let touching = |names: fn(&PassInfo) -> &Vec<String>| {
                let mut found = passes
                    .iter()
                    .zip(&stages)
                    .filter(|(pass, _)| names(pass).iter().any(|touched| without_frame(touched) == name));
                found.next().map(|(_, stage)| *stage)
            };
            match touching(|pass| &pass.writes).or_else(|| touching(|pass| &pass.reads)) {
                Some(stage) => (stage.code(), stage.name()),
                None => (u32::MAX, "other"),
            }
        };
        let mut parts: BTreeMap<_, BTreeMap<String, u64>> = BTreeMap::new();
        for (name, bytes) in without(after, before) {
            let name = without_frame(&name);
            *parts.entry(stage_of(name)).or_default().entry(name.to_owned()).or_default() += bytes;
        }
        let stages: Vec<_> = parts
            .into_iter()
            .map(|((_, stage), allocations)| {
                let mut allocations: Vec<_> = allocations.into_iter().collect();
                allocations.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
                let bytes = allocations.iter().map(|(_, bytes)| bytes).sum();
                StageMemory { stage: stage.into(), bytes, bytes_a_pixel: bytes as f64 / pixels, allocations }
            })
            .collect();
        let bytes = stages.iter().map(|stage| stage.bytes).sum();
        FrameMemory { bytes, bytes_a_pixel: bytes as f64 / pixels, stages }
    }
}

/// The image that holds this content, of this frame or the last one.
fn without_frame(name: &str) -> &str {
    name.strip_suffix("_prev").unwrap_or(name)
}

/// The allocations of `after` that were not there `before`.
fn without(mut after: Allocations, before: &Allocations) -> Allocations {
    for allocation in before {
        if let Some(at) = after.iter().position(|other| other == allocation) {
            after.swap_remove(at);
        }
    }
    after
}
