//! Pairs of resources that swap at the start of a frame: this frame's and the last frame's.

/// A value of this frame and of the last one.
#[derive(Clone, Debug)]
pub struct History<T> {
    current: T,
    previous: T,
}

impl<T> History<T> {
    /// Both at their start.
    pub fn new(current: T, previous: T) -> Self {
        Self { current, previous }
    }

    /// This frame's.
    pub fn current(&self) -> &T {
        &self.current
    }

    /// Last frame's.
    pub fn previous(&self) -> &T {
        &self.previous
    }

    /// Swaps the two: the current value becomes the previous one.
    pub fn swap(&mut self) {
        std::mem::swap(&mut self.current, &mut self.previous);
    }
}
