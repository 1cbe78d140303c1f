//! Progress and summary of a reference render.

use indicatif::{HumanDuration, ProgressBar, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::ops::Range;
use std::time::{Duration, Instant};

/// Seconds between looks at the error, which wait for the device.
const REPORT_INTERVAL: Duration = Duration::from_secs(5);

/// Progress on standard error: a bar on a terminal, a line now and then elsewhere.
pub struct Report {
    bar: Option<ProgressBar>,
    samples: Range<u32>,
    first: u32,
    started: Instant,
    shown: Instant,
}

impl Report {
    /// Progress of a render of `samples` that starts at `first`.
    pub fn new(samples: &Range<u32>, first: u32) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new(u64::from(samples.end - samples.start));
            let style = ProgressStyle::with_template("{bar:40} {pos}/{len} samples, {msg}");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar
        });
        let now = Instant::now();
        Self { bar, samples: samples.clone(), first, started: now, shown: now }
    }

    /// Whether it is time to show something.
    pub fn is_due(&self) -> bool {
        self.shown.elapsed() >= REPORT_INTERVAL
    }

    /// Shows the estimate from the samples before `next`.
    pub fn show(&mut self, next: u32, relative_error: f64) {
        self.shown = Instant::now();
        let (done, left) = (f64::from(next - self.first), f64::from(self.samples.end - next));
        let left = Duration::try_from_secs_f64(self.started.elapsed().as_secs_f64() / done.max(1.0) * left);
        let left = HumanDuration(left.unwrap_or(Duration::MAX));
        let text = format!("relative error {relative_error:.4}, {left} left");
        match &self.bar {
            Some(bar) => {
                bar.set_position(u64::from(next - self.samples.start));
                bar.set_message(text);
            }
            // A closed standard error is no reason to stop.
            None => {
                let line = format!("sample {next} of {}, {text}", self.samples.end);
                let _ = writeln!(std::io::stderr(), "{line}");
            }
        }
    }

    /// Clears the bar.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
