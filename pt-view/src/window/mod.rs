//! The window: events of winit in, pictures and the panel out.

mod app;
mod events;

use crate::durations::Summary;
use crate::error::{Error, Result};
use crate::panel::PanelContent;
use crate::protocol::{Failure, Frames, Pose};
use crate::renderer_thread::RendererThread;
use app::App;
use pt_core::{Device, DeviceOptions};
use std::ffi::CStr;
use std::time::Duration;
use winit::event_loop::EventLoop;
use winit::raw_window_handle::HasDisplayHandle;

/// Scene time runs at one frame per this interval.
const INTERVAL: Duration = Duration::from_micros(16_667);

/// The renderer has something to collect.
#[derive(Clone, Copy, Debug)]
struct Woken;

/// A window that is not open yet.
pub struct View {
    events: EventLoop<Woken>,
}

/// What a window shows first.
pub struct Opening {
    /// Title of the window.
    pub title: String,
    /// Size of the pictures, pixels.
    pub size: [u32; 2],
    /// Where the camera is.
    pub pose: Pose,
    /// Longest side of the scene, metres.
    pub scene_size: f32,
    /// Content of the panel.
    pub content: PanelContent,
}

impl View {
    /// Connects to the display.
    ///
    /// # Errors
    /// [`Error::NoWindow`] if there is none.
    pub fn new() -> Result<Self> {
        let no_window = |error: &dyn std::fmt::Display| {
            let text = error.to_string();
            // What winit says after the place in its source.
            Error::NoWindow(text.rsplit(": ").next().unwrap_or(&text).trim_end_matches('.').to_owned())
        };
        let events = EventLoop::<Woken>::with_user_event().build();
        Ok(Self { events: events.map_err(|error| no_window(&error))? })
    }

    /// Opens a device that can show images on the display.
    ///
    /// # Errors
    /// A device that can't, or none.
    pub fn open_device(&self, options: &DeviceOptions) -> Result<Device> {
        let display = self.events.display_handle().map_err(|error| Error::NoWindow(error.to_string()))?;
        let names = ash_window::enumerate_required_extensions(display.as_raw())
            .map_err(|error| Error::NoWindow(error.to_string()))?;
        // SAFETY: ash's names are constants.
        let names: Vec<_> = names.iter().map(|&name| unsafe { CStr::from_ptr(name) }).collect();
        Ok(Device::open_presenting(options, &names)?)
    }

    /// Opens the window and shows frames until it is closed. `start` makes the renderer, on a thread of its own; `commands` gets the command
    /// lines that are handed out. Returns how long frames took and input waited.
    ///
    /// # Errors
    /// A display that refuses the window, a device that fails, and what the renderer fails with.
    pub fn run(
        self,
        device: &Device,
        opening: Opening,
        start: impl FnOnce() -> std::result::Result<Box<dyn Frames>, Failure> + Send + 'static,
        commands: &mut dyn FnMut(&str),
    ) -> Result<Summary> {
        let proxy = self.events.create_proxy();
        // The window may be closed before the last frame is done.
        let wake = move || {
            let _ = proxy.send_event(Woken);
        };
        let renderer =
            RendererThread::new(start, wake, INTERVAL).map_err(|error| Error::NoWindow(error.to_string()))?;
        let mut app = App::new(device, opening, renderer, commands);
        self.events.run_app(&mut app).map_err(|error| Error::NoWindow(error.to_string()))?;
        app.end()
    }
}
