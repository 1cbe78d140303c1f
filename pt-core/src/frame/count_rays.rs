//! A recorder that counts the rays of its passes.

use super::hazards::Touch;
use super::rays::{CopyWord, PassRays, RayCount, RayCounter, WORD};
use super::recorder::{Frame, Recorder, TO_HOST};
use super::resource::{Keep, PassInfo};
use crate::error::Result;
use ash::vk;

impl Recorder {
    /// From the next frame on the rays of passes are counted. This adds a copy before each pass whose rays are listed: time other frames.
    ///
    /// # Errors
    /// When the device has no memory.
    pub fn count_rays(&mut self) -> Result<()> {
        self.ray_counter = Some(RayCounter::new(self.device())?);
        Ok(())
    }

    /// The rays of the frame that was recorded last, by pass; waits for it. Empty without [`Recorder::count_rays`].
    ///
    /// # Errors
    /// When the device fails.
    pub fn ray_counts(&mut self) -> Result<Vec<PassRays>> {
        self.finish()?;
        Ok(self.ray_counter.as_ref().map(RayCounter::counts).unwrap_or_default())
    }
}

impl Frame<'_> {
    /// Notes the rays of the pass that is recorded next, if the recorder counts them.
    pub(super) fn note_rays(&mut self, pass: &str, extent: [u32; 3], count: &RayCount) -> Result<()> {
        match self.ray_counter().and_then(|counter| counter.note(pass, extent, count)) {
            Some(copy) => self.copy_word(pass, &copy),
            None => Ok(()),
        }
    }

    fn copy_word(&mut self, pass: &str, copy: &CopyWord<'_>) -> Result<()> {
        let ((list, from), (words, to)) = (copy.from, (&copy.to.0, copy.to.1));
        let touch = |access, write| Touch { stage: vk::PipelineStageFlags2::ALL_TRANSFER, access, write };
        let touches = [
            (list.id(), touch(vk::AccessFlags2::TRANSFER_READ, false)),
            (words.id(), touch(vk::AccessFlags2::TRANSFER_WRITE, true)),
        ];
        let info = PassInfo {
            name: format!("number of {pass}"),
            kernel: "(copy)".into(),
            extent: [WORD as u32, 1, 1],
            reads: vec![list.name().into()],
            writes: vec![words.name().into()],
            bytes: 2 * WORD,
            bytes_are_upper_bound: false,
        };
        let region = [vk::BufferCopy { src_offset: from, dst_offset: to, size: WORD }];
        let keep = [Keep::Buffer(list.clone()), Keep::Buffer(words.clone())];
        self.encode(info, &touches, keep, |raw, cmd| {
            // SAFETY: recording; both buffers are kept alive by the slot.
            unsafe {
                raw.cmd_copy_buffer(cmd, list.handle(), words.handle(), &region);
                TO_HOST.encode(raw, cmd, &[]);
            }
        })
    }
}
