//! Times of frames, and a sample of them of limited size.

use crate::device::Counters;
use crate::rng::pcg4d;

/// Time of one pass.
#[derive(Clone, Debug, serde::Serialize)]
pub struct PassTiming {
    /// Pass name.
    pub pass: String,
    /// GPU time in milliseconds.
    pub ms: f64,
}

/// Times and counters of one frame.
#[derive(Clone, Debug, serde::Serialize)]
pub struct FrameTiming {
    /// Frames since the start of the run.
    pub frame: u32,
    /// From the first to the last timestamp, in milliseconds.
    pub gpu_ms: f64,
    /// Host time between `begin` and `submit`, in milliseconds, waiting for the device left out.
    pub record_ms: f64,
    /// Per pass, in order.
    pub passes: Vec<PassTiming>,
    /// Pipelines and allocations made since the last frame was submitted.
    pub created: Counters,
}

/// Times of frames: all of them up to [`TimingSample::CAPACITY`], from there on a uniform random sample of that size (Vitter 1985,
/// algorithm R), so that a long run takes no more memory than a short one. The choice does not depend on the times and is the same
/// in each run.
#[derive(Debug, Default)]
pub(super) struct TimingSample {
    kept: Vec<FrameTiming>,
    seen: u32,
}

impl TimingSample {
    /// Most frames that are kept, some 1.5 KB each.
    pub(super) const CAPACITY: usize = 2048;

    pub(super) fn add(&mut self, timing: FrameTiming) {
        self.seen = self.seen.saturating_add(1);
        if self.kept.len() < Self::CAPACITY {
            self.kept.push(timing);
            return;
        }
        let random = pcg4d([self.seen, 0, 0, 0])[0];
        // A number below `seen`, each with the same probability.
        let place = (u64::from(random) * u64::from(self.seen)) >> 32;
        if let Some(slot) = self.kept.get_mut(place as usize) {
            *slot = timing;
        }
    }

    /// Empties the sample, in the order of the frames.
    pub(super) fn take(&mut self) -> Vec<FrameTiming> {
        let mut kept = std::mem::take(self).kept;
        kept.sort_by_key(|timing| timing.frame);
        kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn timing(frame: u32) -> FrameTiming {
        let passes = (0..26).map(|i| PassTiming { pass: format!("pass {i}"), ms: 1.0 }).collect();
        FrameTiming { frame, gpu_ms: 1.0, record_ms: 1.0, passes, created: Counters::default() }
    }

    #[test]
    fn short_runs_are_kept_whole() {
        let mut sample = TimingSample::default();
        let count = TimingSample::CAPACITY as u32;
        (0..count).for_each(|frame| sample.add(timing(frame)));
        assert!(sample.take().iter().map(|t| t.frame).eq(0..count));
        assert!(sample.take().is_empty());
    }

    #[test]
    fn memory_is_flat_over_100_000_frames() {
        let mut sample = TimingSample::default();
        (0..100_000).for_each(|frame| sample.add(timing(frame)));
        assert_eq!(sample.kept.capacity(), TimingSample::CAPACITY.next_power_of_two());
        let frames: Vec<_> = sample.take().iter().map(|t| t.frame).collect();
        assert_eq!(frames.len(), TimingSample::CAPACITY);
        assert!(frames.is_sorted_by(|a, b| a < b), "each frame once, in order");
        // Tenths of the run: binomial, standard deviation 14 about 205; five of them.
        for tenth in 0..10 {
            let count = frames.iter().filter(|&&f| f / 10_000 == tenth).count();
            assert!((135..275).contains(&count), "tenth {tenth}: {count}");
        }
        // Frames that alternate are sampled alike: standard deviation 23 about 1024.
        let even = frames.iter().filter(|&&f| f % 2 == 0).count();
        assert!((910..1140).contains(&even), "{even}");
    }
}
