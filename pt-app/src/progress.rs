//! Progress on standard error: a bar on a terminal, a line now and then elsewhere.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

/// Seconds between lines if standard error is not a terminal.
const LINE_INTERVAL: Duration = Duration::from_secs(5);

/// Counts frames, or other units of work.
pub struct Progress {
    unit: &'static str,
    total: u32,
    done: u32,
    bar: Option<ProgressBar>,
    started: Instant,
    last_line: Instant,
}

impl Progress {
    /// Counts frames. Nothing is shown for a single one.
    pub fn new(total: u32) -> Self {
        Self::counting(total, "frame")
    }

    /// Counts what `unit` names in the singular.
    pub fn counting(total: u32, unit: &'static str) -> Self {
        let bar = (total > 1 && std::io::stderr().is_terminal()).then(|| {
            let style =
                ProgressStyle::with_template(&format!("{{bar:40}} {{pos}}/{{len}} {unit}s, {{eta}} left"));
            let bar = ProgressBar::new(u64::from(total));
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar
        });
        let now = Instant::now();
        Self { unit, total, done: 0, bar, started: now, last_line: now }
    }

    /// One frame more was recorded.
    pub fn step(&mut self) {
        self.done += 1;
        match &self.bar {
            Some(bar) => bar.inc(1),
            None if self.last_line.elapsed() >= LINE_INTERVAL => {
                self.last_line = Instant::now();
                let seconds = self.started.elapsed().as_secs();
                // A closed standard error is no reason to stop.
                let _ =
                    writeln!(std::io::stderr(), "{} {} of {}, {seconds} s", self.unit, self.done, self.total);
            }
            None => {}
        }
    }

    /// Clears the bar.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
