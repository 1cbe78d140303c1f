//! Images that change their memory from frame to frame.

use crate::image::Image;

/// An image of this frame and of the last one: of several images, each frame takes the one before as this frame's, and what was this frame's is the last one's.
pub(crate) struct History {
    images: Vec<Image>,
    current: usize,
}

impl History {
    /// `images`: one for each memory in turn. `first`: the one of the first frame.
    pub(crate) fn new(images: Vec<Image>, first: usize) -> Self {
        let history = Self { images, current: first };
        history.name_images();
        history
    }

    /// This frame's.
    pub(crate) fn current(&self) -> &Image {
        &self.images[self.current]
    }

    /// Last frame's.
    pub(crate) fn previous(&self) -> &Image {
        &self.images[(self.current + 1) % self.images.len()]
    }

    /// Begins a frame: the current image becomes the previous one.
    pub(crate) fn advance(&mut self) {
        self.current = (self.current + self.images.len() - 1) % self.images.len();
        self.name_images();
    }

    fn name_images(&self) {
        self.previous().set_previous(true);
        self.current().set_previous(false);
    }
}
