//! How many rays passes trace, for benchmarks.

use super::hazards::Touch;
use super::recorder::{Frame, Recorder, TO_HOST};
use super::resource::{Keep, PassInfo};
use crate::buffer::{Buffer, Location};
use crate::error::Result;
use ash::vk;

/// Most passes of a frame whose rays an earlier pass has listed.
const MAX_LISTS: usize = 128;
const WORD: u64 = 4;

/// How many rays a pass traces.
#[derive(Clone)]
pub enum RayCount {
    /// One for each thread.
    Threads,
    /// One for some of the threads.
    AtMostThreads,
    /// As many as the word at this offset, in bytes, of a buffer says when the pass begins.
    Listed(Buffer, u64),
}

/// The rays that a pass has traced.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PassRays {
    /// Pass name.
    pub pass: String,
    /// Number of rays.
    pub rays: u64,
    /// Whether it has traced fewer, as many as the frame needed.
    pub is_upper_bound: bool,
}

/// What a recorder has noted of the frame that it recorded last.
pub(super) struct RayCounter {
    words: Buffer,
    listed: usize,
    noted: Vec<Noted>,
}

struct Noted {
    pass: String,
    threads: u64,
    is_upper_bound: bool,
    /// The word that holds the number, instead of `threads`.
    word: Option<usize>,
}

impl RayCounter {
    pub(super) fn begin_frame(&mut self) {
        self.listed = 0;
        self.noted.clear();
    }
}

impl Recorder {
    /// From the next frame on the rays of passes are counted. This adds a copy before each pass whose rays are listed: time other frames.
    ///
    /// # Errors
    /// When the device has no memory.
    pub fn count_rays(&mut self) -> Result<()> {
        let words =
            Buffer::new(self.device(), "numbers of rays", MAX_LISTS as u64 * WORD, Location::Readback)?;
        self.ray_counter = Some(RayCounter { words, listed: 0, noted: Vec::new() });
        Ok(())
    }

    /// The rays of the frame that was recorded last, by pass; waits for it. Empty without [`Recorder::count_rays`].
    ///
    /// # Errors
    /// When the device fails.
    pub fn ray_counts(&mut self) -> Result<Vec<PassRays>> {
        self.finish()?;
        let Some(counter) = &self.ray_counter else { return Ok(Vec::new()) };
        let words: Vec<u32> = counter.words.mapped();
        let rays = |noted: &Noted| PassRays {
            pass: noted.pass.clone(),
            rays: noted.word.map_or(noted.threads, |word| u64::from(words[word])),
            is_upper_bound: noted.is_upper_bound,
        };
        Ok(counter.noted.iter().map(rays).collect())
    }
}

impl Frame<'_> {
    /// Notes the rays of the pass that is recorded next, if the recorder counts them.
    pub(super) fn note_rays(&mut self, pass: &str, extent: [u32; 3], count: &RayCount) -> Result<()> {
        let Some(counter) = self.ray_counter() else { return Ok(()) };
        let threads = extent.into_iter().map(u64::from).product();
        let mut noted = Noted { pass: pass.into(), threads, is_upper_bound: false, word: None };
        let mut copy = None;
        match count {
            RayCount::Threads => {}
            RayCount::AtMostThreads => noted.is_upper_bound = true,
            RayCount::Listed(..) if counter.listed == MAX_LISTS => noted.is_upper_bound = true,
            RayCount::Listed(list, offset) => {
                noted.word = Some(counter.listed);
                copy = Some((list, *offset, counter.words.clone(), counter.listed as u64 * WORD));
                counter.listed += 1;
            }
        }
        counter.noted.push(noted);
        match copy {
            Some((list, from, words, to)) => self.copy_word(pass, (list, from), (&words, to)),
            None => Ok(()),
        }
    }

    fn copy_word(
        &mut self,
        pass: &str,
        (list, from): (&Buffer, u64),
        (words, to): (&Buffer, u64),
    ) -> Result<()> {
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
                TO_HOST.encode(raw, cmd);
            }
        })
    }
}
