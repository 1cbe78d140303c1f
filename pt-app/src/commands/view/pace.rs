//! Which scene time each frame shows, and whether a command line can say how the picture came about.

/// The frames since the renderer was started or made anew.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pace {
    /// Scene time of the frame `since`, seconds.
    start: f64,
    since: u32,
    /// Frames so far.
    frames: u32,
    is_playing: bool,
    /// Scene time of the last frame.
    time: f64,
    /// Whether nothing has changed since the first frame.
    is_whole: bool,
}

impl Pace {
    /// Begins with the scene at `start`.
    pub(super) fn new(start: f64, is_playing: bool) -> Self {
        Self { start, since: 0, frames: 0, is_playing, time: start, is_whole: true }
    }

    /// Times of the next frame and of the one before it, seconds.
    pub(super) fn next(&mut self, fps: f64) -> [f64; 2] {
        let previous = if self.frames == 0 { self.start } else { self.time };
        // The expression of `pt render`, to the bit.
        let passed = if self.is_playing { f64::from(self.frames - self.since) / fps } else { 0.0 };
        self.time = self.start + passed;
        self.frames += 1;
        [self.time, previous]
    }

    /// Scene time runs or stands still from here on.
    pub(super) fn play(&mut self, is_playing: bool) {
        if is_playing != self.is_playing {
            self.is_playing = is_playing;
            // The next frame is one interval later where time runs.
            (self.start, self.since) = (self.time, self.frames.saturating_sub(u32::from(is_playing)));
            self.is_whole &= self.frames == 0;
        }
    }

    /// The next frame shows the scene at `time`.
    pub(super) fn seek(&mut self, time: f64) {
        (self.start, self.time, self.since) = (time, time, self.frames);
        self.is_whole &= self.frames == 0;
    }

    /// Something else than time has changed.
    pub(super) fn changed(&mut self) {
        self.is_whole &= self.frames == 0;
    }

    /// Frames so far.
    pub(super) fn frames(&self) -> u32 {
        self.frames
    }

    /// Scene time of the last frame, seconds.
    pub(super) fn time(&self) -> f64 {
        self.time
    }

    /// Whether scene time runs.
    pub(super) fn is_playing(&self) -> bool {
        self.is_playing
    }

    /// The scene time that a command line begins at, if it can say how the picture came about.
    pub(super) fn whole_from(&self) -> Option<f64> {
        (self.is_whole && self.frames > 0).then_some(self.start)
    }

    /// The pace of the picture that is rendered anew: its last frame, of `frames`, shows what is shown now.
    pub(super) fn anew(&self, frames: u32, fps: f64) -> Self {
        let passed = if self.is_playing { f64::from(frames.saturating_sub(1)) / fps } else { 0.0 };
        Self::new((self.time - passed).max(0.0), self.is_playing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_those_of_a_sequence() {
        let mut pace = Pace::new(2.0, true);
        assert_eq!(pace.next(60.0), [2.0, 2.0]);
        assert_eq!(pace.next(60.0), [2.0 + 1.0 / 60.0, 2.0]);
        assert_eq!(pace.next(60.0), [2.0 + 2.0 / 60.0, 2.0 + 1.0 / 60.0]);
        assert_eq!(pace.whole_from(), Some(2.0));
        pace.play(false);
        let [time, previous] = pace.next(60.0);
        assert_eq!((time, previous), (2.0 + 2.0 / 60.0, 2.0 + 2.0 / 60.0), "it stands still");
        assert_eq!(pace.whole_from(), None);
        pace.play(true);
        assert_eq!(pace.next(60.0)[0], time + 1.0 / 60.0, "it goes on");
    }

    #[test]
    fn what_changes_before_the_first_frame_does_not_count() {
        let mut pace = Pace::new(0.0, false);
        pace.seek(3.0);
        pace.changed();
        pace.next(60.0);
        assert_eq!(pace.whole_from(), Some(3.0));
        pace.changed();
        assert_eq!(pace.whole_from(), None);
    }

    #[test]
    fn a_picture_made_anew_ends_at_the_time_that_is_shown() {
        let mut pace = Pace::new(5.0, true);
        for _ in 0..10 {
            pace.next(60.0);
        }
        let mut anew = pace.anew(4, 60.0);
        let last = (0..4).map(|_| anew.next(60.0)[0]).last().unwrap();
        assert!((last - pace.time()).abs() < 1e-12, "{last}");
        assert!(anew.whole_from().is_some());
        pace.play(false);
        assert_eq!(pace.anew(4, 60.0), Pace::new(pace.time(), false));
    }
}
