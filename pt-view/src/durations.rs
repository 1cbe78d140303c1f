//! How long frames took and input waited, in memory that does not grow.

use std::fmt;
use std::time::Duration;

/// Classes of durations to a factor of two.
const CLASSES_TO_TWO: f64 = 8.0;
/// Up to some 70 minutes.
const CLASSES: usize = 256;

/// Counts of durations from a microsecond on, in classes whose ends differ by 9 %.
#[derive(Clone, Debug, PartialEq)]
pub struct Durations {
    counts: Vec<u64>,
    longest: Duration,
}

impl Default for Durations {
    fn default() -> Self {
        Self { counts: vec![0; CLASSES], longest: Duration::ZERO }
    }
}

impl Durations {
    /// Adds one.
    pub fn add(&mut self, duration: Duration) {
        let microseconds = duration.as_secs_f64() * 1e6;
        let class = (microseconds.max(1.0).log2() * CLASSES_TO_TWO) as usize;
        self.counts[class.min(CLASSES - 1)] += 1;
        self.longest = self.longest.max(duration);
    }

    /// How many there are.
    pub fn count(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// The longest one; zero without any.
    pub fn longest(&self) -> Duration {
        self.longest
    }

    /// The middle of the class of the median; zero without any.
    pub fn median(&self) -> Duration {
        let (mut seen, count) = (0, self.count());
        let class = self.counts.iter().position(|count_of_class| {
            seen += count_of_class;
            2 * seen >= count && seen > 0
        });
        class.map_or(Duration::ZERO, |class| {
            let middle = ((class as f64 + 0.5) / CLASSES_TO_TWO).exp2() * 1e-6;
            Duration::from_secs_f64(middle).min(self.longest)
        })
    }
}

/// What a window did.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Times of the frames, from the request to the picture.
    pub frames: Durations,
    /// Seconds since the first frame.
    pub seconds: f64,
    /// How long the window's thread was busy without a break: input waits at most that long.
    pub input: Durations,
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ms = |duration: Duration| duration.as_secs_f64() * 1e3;
        let (frames, input, seconds) = (&self.frames, &self.input, self.seconds);
        let rate = if seconds > 0.0 { frames.count() as f64 / seconds } else { 0.0 };
        write!(
            f,
            "{} frames in {seconds:.1} s, {rate:.1} frames per second; a frame took {:.1} ms (median), {:.1} ms at most; \
             input waited {:.1} ms (median), {:.1} ms at most",
            frames.count(),
            ms(frames.median()),
            ms(frames.longest()),
            ms(input.median()),
            ms(input.longest())
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_and_longest_are_those_of_the_durations() {
        let mut durations = Durations::default();
        assert_eq!((durations.median(), durations.longest()), (Duration::ZERO, Duration::ZERO));
        for ms in [1, 20, 21, 20, 5000] {
            durations.add(Duration::from_millis(ms));
        }
        let median = durations.median().as_secs_f64();
        // Half a class.
        assert!((median / 0.02).log2().abs() <= 0.5 / CLASSES_TO_TWO + 1e-9, "{median}");
        assert_eq!((durations.count(), durations.longest()), (5, Duration::from_secs(5)));
        for far in [Duration::ZERO, Duration::from_secs(1 << 20)] {
            durations.add(far);
        }
        assert_eq!(durations.count(), 7);
    }

    #[test]
    fn one_line_says_what_a_window_did() {
        let mut frames = Durations::default();
        (0..30).for_each(|_| frames.add(Duration::from_millis(100)));
        let text = Summary { frames, seconds: 6.0, input: Durations::default() }.to_string();
        assert!(text.starts_with("30 frames in 6.0 s, 5.0 frames per second; a frame took "), "{text}");
        assert!(text.ends_with("100.0 ms at most; input waited 0.0 ms (median), 0.0 ms at most"), "{text}");
    }
}
