//! The window of `pt`: shows frames beside a panel of knobs, moves the camera, and hands requests to a renderer that it does not know
//! ([`protocol::Frames`]).

pub mod blit;
pub mod camera;
mod drawing;
pub mod durations;
mod error;
pub mod headless;
mod input;
pub mod knob_sheet;
pub mod layout;
pub mod offscreen;
pub mod offscreen_view;
pub mod panel;
pub mod panel_renderer;
pub mod pass_history;
pub mod presenter;
pub mod protocol;
mod renderer_thread;
mod swapchain;
pub mod swapchain_rules;
mod window;

pub use egui::Context;
pub use error::{Error, Result};
pub use window::{Opening, View};
