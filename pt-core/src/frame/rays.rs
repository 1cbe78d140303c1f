//! How many rays passes trace, for benchmarks.

use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::Result;

/// Most passes of a frame whose rays an earlier pass has listed.
const MAX_LISTS: usize = 128;
/// Bytes of a number of rays.
pub(super) const WORD: u64 = 4;

/// How many rays a pass traces.
#[derive(Clone)]
pub enum RayCount {
    /// One for each thread.
    Threads,
    /// One for some of the threads.
    AtMostThreads,
    /// Up to so many for each thread.
    AtMostPerThread(u32),
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
    rays: u64,
    is_upper_bound: bool,
    /// The word that holds the number, instead of `rays`.
    word: Option<usize>,
}

/// The copy of a number of rays that the device must make before the pass.
pub(super) struct CopyWord<'a> {
    pub from: (&'a Buffer, u64),
    pub to: (Buffer, u64),
}

impl RayCounter {
    pub(super) fn new(device: &Device) -> Result<Self> {
        let words = Buffer::new(device, "numbers of rays", MAX_LISTS as u64 * WORD, Location::Readback)?;
        Ok(Self { words, listed: 0, noted: Vec::new() })
    }

    pub(super) fn begin_frame(&mut self) {
        self.listed = 0;
        self.noted.clear();
    }

    /// Notes a pass.
    pub(super) fn note<'a>(
        &mut self,
        pass: &str,
        extent: [u32; 3],
        count: &'a RayCount,
    ) -> Option<CopyWord<'a>> {
        let rays = extent.into_iter().map(u64::from).product();
        let mut noted = Noted { pass: pass.into(), rays, is_upper_bound: false, word: None };
        let mut copy = None;
        match count {
            RayCount::Threads => {}
            RayCount::AtMostThreads => noted.is_upper_bound = true,
            RayCount::AtMostPerThread(most) => {
                noted.rays *= u64::from(*most);
                noted.is_upper_bound = true;
            }
            RayCount::Listed(..) if self.listed == MAX_LISTS => noted.is_upper_bound = true,
            RayCount::Listed(list, offset) => {
                noted.word = Some(self.listed);
                let to = (self.words.clone(), self.listed as u64 * WORD);
                copy = Some(CopyWord { from: (list, *offset), to });
                self.listed += 1;
            }
        }
        self.noted.push(noted);
        copy
    }

    /// What was noted, after the device is done with the frame.
    pub(super) fn counts(&self) -> Vec<PassRays> {
        let words: Vec<u32> = self.words.mapped();
        let rays = |noted: &Noted| PassRays {
            pass: noted.pass.clone(),
            rays: noted.word.map_or(noted.rays, |word| u64::from(words[word])),
            is_upper_bound: noted.is_upper_bound,
        };
        self.noted.iter().map(rays).collect()
    }
}
