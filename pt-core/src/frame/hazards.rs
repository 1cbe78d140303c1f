//! Derives barriers from declared accesses.
//!
//! Images stay in GENERAL layout, so ordering needs memory barriers only, and the hazards of one pass merge into a single
//! one (Vulkan specification, "Memory dependencies").

use crate::image::COLOR_RANGE;
use ash::vk::{
    AccessFlags2 as A, DependencyInfo, Image, ImageLayout, ImageMemoryBarrier2, MemoryBarrier2,
    PipelineStageFlags2 as S,
};
use std::collections::HashMap;

/// How a pass touches a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Touch {
    pub(crate) stage: S,
    pub(crate) access: A,
    pub(crate) write: bool,
}

/// Accesses to a resource since its last write.
#[derive(Clone, Copy, Debug, Default)]
struct State {
    write_stage: S,
    write_access: A,
    /// Stages and accesses that the last write has been made visible to.
    visible_stage: S,
    visible_access: A,
    read_stage: S,
}

/// Barrier to put before a pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Barrier {
    pub(crate) src_stage: S,
    pub(crate) src_access: A,
    pub(crate) dst_stage: S,
    pub(crate) dst_access: A,
}

impl Barrier {
    pub(crate) fn is_needed(&self) -> bool {
        !self.src_stage.is_empty()
    }

    /// `fresh`: images whose memory others have used since they were written last. What they hold is undefined, and the layout must be stated anew (Vulkan specification,
    /// "Memory Aliasing").
    ///
    /// # Safety
    /// `cmd` is in recording state, and the images are alive until it is done.
    pub(crate) unsafe fn encode(&self, raw: &ash::Device, cmd: ash::vk::CommandBuffer, fresh: &[Image]) {
        let barrier = [MemoryBarrier2::default()
            .src_stage_mask(self.src_stage)
            .src_access_mask(self.src_access)
            .dst_stage_mask(self.dst_stage)
            .dst_access_mask(self.dst_access)];
        let image_barrier = |&image| {
            ImageMemoryBarrier2::default()
                .image(image)
                .subresource_range(COLOR_RANGE)
                .old_layout(ImageLayout::UNDEFINED)
                .new_layout(ImageLayout::GENERAL)
                .src_stage_mask(self.src_stage)
                .src_access_mask(self.src_access)
                .dst_stage_mask(self.dst_stage)
                // A change of layout is a write, for which the pass's own write has to wait, too.
                .dst_access_mask(self.dst_access | A::MEMORY_READ | A::MEMORY_WRITE)
        };
        let images: Vec<_> = fresh.iter().map(image_barrier).collect();
        let info = DependencyInfo::default().memory_barriers(&barrier).image_memory_barriers(&images);
        // SAFETY: as promised by the caller.
        unsafe { raw.cmd_pipeline_barrier2(cmd, &info) };
    }
}

/// State of all resources, by resource id, over the whole life of a recorder.
#[derive(Default)]
pub(crate) struct Hazards(HashMap<u64, State>);

impl Hazards {
    /// Records one access and adds what must be waited for.
    pub(crate) fn touch(&mut self, id: u64, touch: Touch, barrier: &mut Barrier) {
        let state = self.0.entry(id).or_default();
        let Touch { stage, access, write } = touch;
        let after_write = !state.write_stage.is_empty();
        let visible = state.visible_stage.contains(stage) && state.visible_access.contains(access);
        if after_write && (write || !visible) {
            barrier.src_stage |= state.write_stage;
            barrier.src_access |= state.write_access;
            barrier.dst_stage |= stage;
            barrier.dst_access |= access;
        }
        if write {
            if !state.read_stage.is_empty() {
                // Write after read: execution must be ordered, no memory made visible.
                barrier.src_stage |= state.read_stage;
                barrier.dst_stage |= stage;
            }
            *state = State { write_stage: stage, write_access: access & WRITES, ..State::default() };
        } else {
            if !visible {
                // Only what the barrier makes visible together counts: a stage is added with all accesses asked for.
                state.visible_stage = stage;
                state.visible_access = access;
            }
            state.read_stage |= stage;
        }
    }
}

/// Accesses that a source mask may name.
const WRITES: A = A::from_raw(
    A::SHADER_STORAGE_WRITE.as_raw()
        | A::TRANSFER_WRITE.as_raw()
        | A::ACCELERATION_STRUCTURE_WRITE_KHR.as_raw(),
);

#[cfg(test)]
mod tests {
    use super::*;

    const WRITE: Touch = Touch { stage: S::COMPUTE_SHADER, access: A::SHADER_STORAGE_WRITE, write: true };
    const READ: Touch = Touch { stage: S::COMPUTE_SHADER, access: A::SHADER_STORAGE_READ, write: false };

    fn next(hazards: &mut Hazards, touch: Touch) -> Barrier {
        let mut barrier = Barrier::default();
        hazards.touch(7, touch, &mut barrier);
        barrier
    }

    #[test]
    fn read_after_write_makes_visible_once() {
        let mut h = Hazards::default();
        assert!(!next(&mut h, WRITE).is_needed());
        let barrier = next(&mut h, READ);
        assert_eq!(
            (barrier.src_access, barrier.dst_access),
            (A::SHADER_STORAGE_WRITE, A::SHADER_STORAGE_READ)
        );
        assert!(!next(&mut h, READ).is_needed());
        let ray_tracing = Touch { stage: S::RAY_TRACING_SHADER_KHR, ..READ };
        assert!(next(&mut h, ray_tracing).is_needed(), "another stage has not seen the write");
    }

    #[test]
    fn write_after_read_orders_execution_only() {
        let mut h = Hazards::default();
        next(&mut h, READ);
        let barrier = next(&mut h, WRITE);
        assert!(barrier.is_needed());
        assert_eq!(barrier.src_access, A::NONE);
    }

    #[test]
    fn write_after_write() {
        let mut h = Hazards::default();
        next(&mut h, WRITE);
        let barrier = next(&mut h, WRITE);
        assert_eq!(
            (barrier.src_access, barrier.dst_access),
            (A::SHADER_STORAGE_WRITE, A::SHADER_STORAGE_WRITE)
        );
    }
}
