//! What changes its memory from frame to frame.

use crate::image::Image;

/// Something in several places: each frame takes the one before as this frame's, and what was this frame's is the last one's.
pub(crate) struct Turns<T> {
    all: Vec<T>,
    current: usize,
}

impl<T> Turns<T> {
    /// `all`: one for each place in turn. `first`: the one of the first frame.
    pub(crate) fn new(all: Vec<T>, first: usize) -> Self {
        Self { all, current: first }
    }

    /// This frame's.
    pub(crate) fn current(&self) -> &T {
        &self.all[self.current]
    }

    /// Last frame's.
    pub(crate) fn previous(&self) -> &T {
        &self.all[(self.current + 1) % self.all.len()]
    }

    /// Begins a frame: the current one becomes the previous one.
    pub(crate) fn advance(&mut self) {
        self.current = (self.current + self.all.len() - 1) % self.all.len();
    }

    /// All of them.
    pub(crate) fn all(&self) -> &[T] {
        &self.all
    }
}

impl Turns<Image> {
    /// Says which image is this frame's and which one the last one's.
    pub(crate) fn name_images(&self) {
        self.previous().set_previous(true);
        self.current().set_previous(false);
    }
}
