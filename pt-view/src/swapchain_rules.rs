//! When a swapchain is made anew, by the answers that Vulkan gives: a state machine that needs no window.

use ash::vk;

/// What is to be done before the next picture can be shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Nothing can be shown: the window has no area.
    Wait,
    /// The surface is lost: make it and its swapchain anew.
    MakeSurface,
    /// Make a swapchain for the surface.
    MakeSwapchain,
    /// Show a picture.
    Show,
}

/// What became of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It is shown, or can be drawn.
    Done,
    /// It was left out; [`SwapchainRules::next`] says what to do.
    LeftOut,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// There is no surface, or it is lost.
    NoSurface,
    /// There is no swapchain, or one that no longer fits.
    NoSwapchain,
    /// The swapchain fits.
    Ready,
}

/// The state of a window's swapchain.
#[derive(Clone, Copy, Debug)]
pub struct SwapchainRules {
    /// Of the window, pixels.
    size: [u32; 2],
    state: State,
}

impl SwapchainRules {
    /// For a window of `size` pixels that has a surface.
    pub fn new(size: [u32; 2]) -> Self {
        Self { size, state: State::NoSwapchain }
    }

    /// Size of the window in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The window has another size. A minimised one has none.
    pub fn resized(&mut self, size: [u32; 2]) {
        if size != self.size {
            self.size = size;
            self.is_stale();
        }
    }

    /// What to do next.
    pub fn next(&self) -> Step {
        match self.state {
            _ if self.size.contains(&0) => Step::Wait,
            State::NoSurface => Step::MakeSurface,
            State::NoSwapchain => Step::MakeSwapchain,
            State::Ready => Step::Show,
        }
    }

    /// There is a new surface.
    pub fn made_surface(&mut self) {
        self.state = State::NoSwapchain;
    }

    /// There is a new swapchain.
    pub fn made_swapchain(&mut self) {
        self.state = State::Ready;
    }

    /// Vulkan's answer to the request for an image, `true` if it is suboptimal. A suboptimal image is drawn: its semaphore will be signalled.
    ///
    /// # Errors
    /// What no new swapchain cures.
    pub fn acquired(&mut self, answer: Result<bool, vk::Result>) -> Result<Outcome, vk::Result> {
        match answer {
            // Presenting says it again.
            Ok(_) => Ok(Outcome::Done),
            Err(vk::Result::NOT_READY | vk::Result::TIMEOUT) => Ok(Outcome::LeftOut),
            Err(error) => self.failed(error),
        }
    }

    /// Vulkan's answer to the presentation of an image, `true` if it is suboptimal.
    ///
    /// # Errors
    /// What no new swapchain cures.
    pub fn presented(&mut self, answer: Result<bool, vk::Result>) -> Result<Outcome, vk::Result> {
        match answer {
            Ok(suboptimal) => {
                if suboptimal {
                    self.is_stale();
                }
                Ok(Outcome::Done)
            }
            Err(error) => self.failed(error),
        }
    }

    /// Vulkan refused to make a swapchain, or to describe the surface.
    ///
    /// # Errors
    /// What no new surface cures.
    pub fn failed(&mut self, error: vk::Result) -> Result<Outcome, vk::Result> {
        match error {
            vk::Result::ERROR_OUT_OF_DATE_KHR => self.is_stale(),
            vk::Result::ERROR_SURFACE_LOST_KHR => self.state = State::NoSurface,
            other => return Err(other),
        }
        Ok(Outcome::LeftOut)
    }

    /// The swapchain no longer fits; a lost surface stays lost.
    fn is_stale(&mut self) {
        if self.state == State::Ready {
            self.state = State::NoSwapchain;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ready() -> SwapchainRules {
        let mut rules = SwapchainRules::new([8, 8]);
        assert_eq!(rules.next(), Step::MakeSwapchain);
        rules.made_swapchain();
        assert_eq!(rules.next(), Step::Show);
        rules
    }

    #[test]
    fn another_size_needs_another_swapchain_and_none_waits() {
        let mut rules = ready();
        rules.resized([8, 8]);
        assert_eq!(rules.next(), Step::Show, "the same size");
        rules.resized([9, 8]);
        assert_eq!(rules.next(), Step::MakeSwapchain);
        rules.made_swapchain();
        rules.resized([0, 0]);
        assert_eq!(rules.next(), Step::Wait, "minimised");
        rules.resized([9, 8]);
        assert_eq!(rules.next(), Step::MakeSwapchain, "restored");
    }

    #[test]
    fn what_is_out_of_date_is_made_anew() {
        let out_of_date = vk::Result::ERROR_OUT_OF_DATE_KHR;
        let mut rules = ready();
        assert_eq!(rules.acquired(Err(out_of_date)), Ok(Outcome::LeftOut));
        assert_eq!(rules.next(), Step::MakeSwapchain);
        let mut rules = ready();
        assert_eq!(rules.presented(Err(out_of_date)), Ok(Outcome::LeftOut));
        assert_eq!(rules.next(), Step::MakeSwapchain);
        let mut rules = ready();
        assert_eq!(rules.acquired(Ok(true)), Ok(Outcome::Done), "a suboptimal image is drawn");
        assert_eq!(rules.next(), Step::Show);
        assert_eq!(rules.presented(Ok(true)), Ok(Outcome::Done));
        assert_eq!(rules.next(), Step::MakeSwapchain, "and the next swapchain fits");
    }

    #[test]
    fn a_lost_surface_stays_lost_until_there_is_a_new_one() {
        let mut rules = ready();
        assert_eq!(rules.acquired(Err(vk::Result::ERROR_SURFACE_LOST_KHR)), Ok(Outcome::LeftOut));
        rules.resized([3, 3]);
        assert_eq!(rules.next(), Step::MakeSurface, "another size does not bring it back");
        rules.made_surface();
        assert_eq!(rules.next(), Step::MakeSwapchain);
        assert_eq!(rules.failed(vk::Result::ERROR_SURFACE_LOST_KHR), Ok(Outcome::LeftOut));
        assert_eq!(rules.next(), Step::MakeSurface);
    }

    #[test]
    fn no_image_in_time_leaves_the_picture_out_and_other_errors_are_passed_on() {
        let mut rules = ready();
        for late in [vk::Result::NOT_READY, vk::Result::TIMEOUT] {
            assert_eq!(rules.acquired(Err(late)), Ok(Outcome::LeftOut));
            assert_eq!(rules.next(), Step::Show);
        }
        let lost = vk::Result::ERROR_DEVICE_LOST;
        assert_eq!(rules.acquired(Err(lost)), Err(lost));
        assert_eq!(rules.presented(Err(lost)), Err(lost));
    }
}
