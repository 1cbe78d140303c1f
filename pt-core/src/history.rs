//! Values that a frame shares with the last one.

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

    /// Ends the frame: what was current becomes previous.
    pub fn swap(&mut self) {
        std::mem::swap(&mut self.current, &mut self.previous);
    }
}
