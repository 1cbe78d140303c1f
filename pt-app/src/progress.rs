//! Progress on standard error: a bar on a terminal, a line now and then elsewhere.

use indicatif::{HumanDuration, ProgressBar, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

/// Seconds between lines if standard error is not a terminal.
const LINE_INTERVAL: Duration = Duration::from_secs(5);

/// Counts frames, samples, or other units of work, and says how long the rest will take.
pub struct Progress {
    unit: &'static str,
    total: u32,
    done: u32,
    bar: Option<ProgressBar>,
    started: Instant,
    pace: Pace,
    last_line: Instant,
}

impl Progress {
    /// Counts frames. Nothing is shown for a single one.
    pub fn new(total: u32) -> Self {
        Self::counting(total, "frame")
    }

    /// Counts what `unit` names in the singular.
    pub fn counting(total: u32, unit: &'static str) -> Self {
        Self::resuming(0, total, unit)
    }

    /// Counts on from `done`.
    pub fn resuming(done: u32, total: u32, unit: &'static str) -> Self {
        let bar = (total > 1 && std::io::stderr().is_terminal()).then(|| {
            let style = ProgressStyle::with_template(&format!("{{bar:40}} {{pos}}/{{len}} {unit}s{{msg}}"));
            let bar = ProgressBar::new(u64::from(total));
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar.set_position(u64::from(done));
            bar
        });
        let now = Instant::now();
        Self { unit, total, done, bar, started: now, pace: Pace::starting_at(done), last_line: now }
    }

    /// One unit more is done.
    pub fn step(&mut self) {
        self.advance_to(self.done + 1);
        self.show("");
    }

    /// `done` units are done: a step, if that is more than before.
    pub fn advance_to(&mut self, done: u32) {
        if done == self.done {
            return;
        }
        self.done = done;
        self.pace.mark(self.started.elapsed(), done);
    }

    /// Whether it is time for another line. On a terminal the first step is shown at once, so that the time that is left is known.
    pub fn is_due(&self) -> bool {
        let is_first = self.bar.is_some() && self.pace.steps == 1;
        is_first || self.last_line.elapsed() >= LINE_INTERVAL
    }

    /// Shows the progress with `note` behind it: the bar at every call, a line only if it is time.
    pub fn show(&mut self, note: &str) {
        let is_due = self.is_due();
        let elapsed = self.started.elapsed();
        let left = self.pace.left(elapsed, self.total).map_or(String::new(), |left| format!(", {left} left"));
        let text = format!("{note}{left}");
        match &self.bar {
            Some(bar) => {
                bar.set_message(text);
                bar.set_position(u64::from(self.done));
            }
            None if is_due && self.pace.steps > 0 => {
                let line =
                    format!("{} {} of {}, {} s{text}", self.unit, self.done, self.total, elapsed.as_secs());
                // A closed standard error is no reason to stop.
                let _ = writeln!(std::io::stderr(), "{line}");
            }
            None => {}
        }
        if is_due {
            self.last_line = Instant::now();
        }
    }

    /// Clears the bar.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// The speed without the first step, in which drivers compile kernels.
#[derive(Clone, Copy, Debug)]
struct Pace {
    /// Units before the first step.
    from: u32,
    steps: u32,
    /// When the first step was over, and the units that were done then.
    first: (Duration, u32),
    /// The same of the last step.
    last: (Duration, u32),
}

impl Pace {
    fn starting_at(from: u32) -> Self {
        Self { from, steps: 0, first: (Duration::ZERO, from), last: (Duration::ZERO, from) }
    }

    /// A step was over at `time` since the start, with `done` units.
    fn mark(&mut self, time: Duration, done: u32) {
        self.steps += 1;
        self.last = (time, done);
        if self.steps == 1 {
            self.first = self.last;
        }
    }

    /// The time that is left at `now`, in words; `None` before the first step. After the first step alone it is an upper bound.
    fn left(&self, now: Duration, total: u32) -> Option<String> {
        let (time, units) = match self.steps {
            0 => return None,
            1 => (self.last.0, self.last.1 - self.from),
            _ => (self.last.0.saturating_sub(self.first.0), self.last.1.saturating_sub(self.first.1)),
        };
        let per_unit = time.as_secs_f64() / f64::from(units.max(1));
        // What has passed since the last step belongs to the next one.
        let ahead = per_unit * f64::from(total.saturating_sub(self.last.1));
        let waited = now.saturating_sub(self.last.0).as_secs_f64().min(ahead);
        let left = Duration::try_from_secs_f64(ahead - waited).unwrap_or(Duration::MAX);
        let bound = if self.steps == 1 { "at most " } else { "" };
        Some(format!("{bound}{}", HumanDuration(left)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A first step of 100 s, 90 of which compile kernels, then steps of 10 s.
    #[test]
    fn the_time_left_is_known_after_the_first_step_and_without_start_up() {
        let seconds = Duration::from_secs;
        let mut pace = Pace::starting_at(0);
        assert_eq!(pace.left(seconds(50), 8), None);
        pace.mark(seconds(100), 1);
        assert_eq!(pace.left(seconds(100), 8).unwrap(), "at most 12 minutes");
        pace.mark(seconds(110), 2);
        assert_eq!(pace.left(seconds(110), 8).unwrap(), "60 seconds");
        pace.mark(seconds(120), 3);
        assert_eq!(pace.left(seconds(120), 8).unwrap(), "50 seconds");
        assert_eq!(pace.left(seconds(125), 8).unwrap(), "45 seconds");
    }

    /// Steps of several units, after a resumption.
    #[test]
    fn steps_may_differ_in_size() {
        let seconds = Duration::from_secs;
        let mut pace = Pace::starting_at(100);
        pace.mark(seconds(30), 101);
        pace.mark(seconds(34), 103);
        pace.mark(seconds(42), 107);
        assert_eq!(pace.left(seconds(42), 117).unwrap(), "20 seconds");
    }
}
