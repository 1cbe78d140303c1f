//! Times of the passes of frames.

use pt_core::frame::FrameTiming;
use pt_core::harness::Spread;

/// Frames whose times count: the first two compile kernels and fill caches.
pub fn warm(timings: &[FrameTiming]) -> &[FrameTiming] {
    let first = timings.partition_point(|timing| timing.frame < 2);
    if first < timings.len() { &timings[first..] } else { timings }
}

/// The passes of the first frame with their times over all frames that have the same pass at the same place.
pub fn pass_spreads(timings: &[FrameTiming]) -> Vec<(String, Spread)> {
    let Some(first) = timings.first() else { return Vec::new() };
    let spread = |(i, name): (usize, &String)| {
        let same = timings.iter().filter_map(|frame| frame.passes.get(i).filter(|pass| pass.pass == *name));
        (name.clone(), Spread::of(same.map(|pass| pass.ms).collect()))
    };
    first.passes.iter().map(|pass| &pass.pass).enumerate().map(spread).collect()
}
