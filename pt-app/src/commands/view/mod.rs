//! `pt view` shows frames in a window. The window is pt-view's; here is the renderer behind it.

mod args;
#[cfg(feature = "view")]
pub(crate) mod content;
#[cfg(feature = "view")]
mod frames;
#[cfg(feature = "view")]
mod hand_out;
#[cfg(feature = "view")]
mod looking;
#[cfg(feature = "view")]
mod pace;
#[cfg(feature = "view")]
mod running;
#[cfg(feature = "view")]
mod show;
#[cfg(feature = "view")]
mod truth;

pub use args::ViewArgs;
#[cfg(feature = "view")]
pub(crate) use show::off_screen;
#[cfg(feature = "view")]
pub use show::run;

/// Runs the command: without the feature `view` it says how to get it.
///
/// # Errors
/// Always.
#[cfg(not(feature = "view"))]
pub fn run(_: &ViewArgs, _: &mut impl std::io::Write) -> anyhow::Result<bool> {
    anyhow::bail!(
        "pt view: this pt is built without the window; build it with cargo build --release -p pt-app --features view"
    )
}
