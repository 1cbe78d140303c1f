//! Times of passes over the last frames.

use crate::protocol::PassTime;
use std::collections::VecDeque;

/// Frames that the median goes over.
const FRAMES: usize = 65;

/// Frames without a pass after which it is forgotten. Uploads come and go with what moves.
const MOST_ABSENT: usize = 8;

/// Times of the last frames, pass by pass.
#[derive(Clone, Debug, Default)]
pub struct PassHistory {
    frame: VecDeque<f64>,
    passes: Vec<Pass>,
}

/// Times of a pass.
#[derive(Clone, Debug)]
struct Pass {
    last: PassTime,
    times: VecDeque<f64>,
    /// Frames since it ran.
    absent: usize,
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
    /// Adds a frame.
    pub fn add(&mut self, frame_ms: f64, passes: &[PassTime]) {
        if passes.is_empty() {
            return;
        }
        push(&mut self.frame, frame_ms);
        self.passes.iter_mut().for_each(|pass| pass.absent += 1);
        // Passes of one name are told apart by their order.
        let mut next = 0;
        for pass in passes {
            let known = self.passes[next..].iter().position(|known| known.last.name == pass.name);
            let at = known.map_or(next, |offset| next + offset);
            if known.is_none() {
                self.passes.insert(at, Pass { last: pass.clone(), times: VecDeque::new(), absent: 0 });
            }
            let known = &mut self.passes[at];
            known.last.clone_from(pass);
            known.absent = 0;
            push(&mut known.times, pass.ms);
            next = at + 1;
        }
        self.passes.retain(|pass| pass.absent <= MOST_ABSENT);
    }

    /// The passes in the order of the frame.
    pub fn rows(&self) -> Vec<PassRow> {
        let row = |pass: &Pass| PassRow { last: pass.last.clone(), median_ms: median(&pass.times) };
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

    fn rows(history: &PassHistory) -> Vec<(String, f64)> {
        history.rows().into_iter().map(|row| (row.last.name, row.median_ms)).collect()
    }

    #[test]
    fn medians_roll() {
        let mut history = PassHistory::default();
        for ms in [1.0, 100.0, 2.0] {
            history.add(ms, &[pass("a", ms)]);
        }
        assert_eq!((history.median_ms(), history.rows()[0].median_ms), (2.0, 2.0));
        (0..FRAMES).for_each(|_| history.add(7.0, &[pass("a", 7.0)]));
        assert_eq!((history.median_ms(), history.frame_times().count()), (7.0, FRAMES));
    }

    #[test]
    fn passes_come_and_go_and_the_others_roll_on() {
        let mut history = PassHistory::default();
        for ms in [1.0, 2.0, 3.0] {
            history.add(ms, &[pass("a", ms), pass("a", 10.0 * ms)]);
            history.add(ms, &[pass("upload", 5.0), pass("a", ms), pass("b", ms), pass("a", 10.0 * ms)]);
        }
        let expected = [("upload", 5.0), ("a", 2.0), ("b", 2.0), ("a", 20.0)];
        assert_eq!(rows(&history), expected.map(|(name, ms)| (name.to_owned(), ms)));
        assert_eq!(history.frame_times().count(), 6);
        (0..=MOST_ABSENT).for_each(|_| history.add(1.0, &[pass("b", 2.0)]));
        assert_eq!(rows(&history), [("b".to_owned(), 2.0)]);
    }
}
