//! Times of passes over the last frames.

use crate::protocol::PassTime;
use std::collections::VecDeque;

/// Frames that the median goes over.
const FRAMES: usize = 65;

/// Times of the last frames, pass by pass.
#[derive(Clone, Debug, Default)]
pub struct PassHistory {
    frame: VecDeque<f64>,
    passes: Vec<(PassTime, VecDeque<f64>)>,
}

/// A row of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct PassRow {
    /// The pass as it was last.
    pub last: PassTime,
    /// Median over the last frames, milliseconds.
    pub median_ms: f64,
}

impl PassHistory {
    /// Adds a frame. Other passes than before begin anew.
    pub fn add(&mut self, frame_ms: f64, passes: &[PassTime]) {
        if passes.is_empty() {
            return;
        }
        let same = self.passes.len() == passes.len()
            && self.passes.iter().zip(passes).all(|((known, _), pass)| known.name == pass.name);
        if !same {
            self.frame.clear();
            self.passes = passes.iter().map(|pass| (pass.clone(), VecDeque::new())).collect();
        }
        push(&mut self.frame, frame_ms);
        for ((last, times), pass) in self.passes.iter_mut().zip(passes) {
            push(times, pass.ms);
            last.clone_from(pass);
        }
    }

    /// The passes in the order of the frame.
    pub fn rows(&self) -> Vec<PassRow> {
        let row = |(last, times): &(PassTime, VecDeque<f64>)| PassRow {
            last: last.clone(),
            median_ms: median(times),
        };
        self.passes.iter().map(row).collect()
    }

    /// Times of the last frames, the oldest first, milliseconds.
    pub fn frame_times(&self) -> impl Iterator<Item = f64> {
        self.frame.iter().copied()
    }

    /// Their median.
    pub fn median_ms(&self) -> f64 {
        median(&self.frame)
    }
}

fn push(times: &mut VecDeque<f64>, ms: f64) {
    if times.len() == FRAMES {
        times.pop_front();
    }
    times.push_back(ms);
}

fn median(times: &VecDeque<f64>) -> f64 {
    let mut sorted: Vec<_> = times.iter().copied().collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pass(name: &str, ms: f64) -> PassTime {
        PassTime { name: name.into(), ms, rays: 0, bytes: 0 }
    }

    #[test]
    fn the_median_rolls_and_other_passes_begin_anew() {
        let mut history = PassHistory::default();
        for ms in [1.0, 100.0, 2.0] {
            history.add(ms, &[pass("a", ms)]);
        }
        assert_eq!((history.median_ms(), history.rows()[0].median_ms), (2.0, 2.0));
        (0..FRAMES).for_each(|_| history.add(7.0, &[pass("a", 7.0)]));
        assert_eq!((history.median_ms(), history.frame_times().count()), (7.0, FRAMES));
        history.add(3.0, &[pass("a", 1.0), pass("b", 2.0)]);
        assert_eq!(history.rows().iter().map(|row| row.median_ms).collect::<Vec<_>>(), [1.0, 2.0]);
        assert_eq!(history.frame_times().count(), 1);
    }
}
