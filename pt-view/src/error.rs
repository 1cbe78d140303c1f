//! Errors of the window.

use ash::vk;

/// Why there is no window, or no longer one.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// There is no display, or it refuses.
    #[error("no window can be shown: {0}; pt render writes pictures without one")]
    NoWindow(String),
    /// The device can't show images on the window's surface.
    #[error(
        "no window can be shown: {device} can't present on this display ({lacks}); pt render writes pictures without one"
    )]
    NoPresentation {
        /// The device.
        device: String,
        /// What is missing.
        lacks: &'static str,
    },
    /// A Vulkan call failed.
    #[error("{call}: {result}")]
    Vulkan {
        /// What was attempted.
        call: &'static str,
        /// The driver's answer.
        result: vk::Result,
    },
    /// The panel can't be drawn.
    #[error("the panel can't be drawn: {0}")]
    Panel(String),
    /// The renderer failed, with its own words.
    #[error(transparent)]
    Renderer(Box<dyn std::error::Error + Send + Sync>),
    /// The device failed.
    #[error(transparent)]
    Device(#[from] pt_core::Error),
}

/// Result with [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// Names the failed call.
pub(crate) trait Call<T> {
    fn call(self, call: &'static str) -> Result<T>;
}

impl<T> Call<T> for std::result::Result<T, vk::Result> {
    fn call(self, call: &'static str) -> Result<T> {
        self.map_err(|result| Error::Vulkan { call, result })
    }
}
