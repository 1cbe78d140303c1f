//! Frames and the panel over them without a window: what the panel takes of the frame rate.

use crate::blit::Blit;
use crate::error::{Error, Result};
use crate::headless::lay_out;
use crate::offscreen::Offscreen;
use crate::panel::Panel;
use crate::protocol::{Failure, Frames, Status};
use crate::renderer_thread::RendererThread;
use pt_core::Device;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Between two looks at what the renderer has left.
const TICK: Duration = Duration::from_micros(50);

/// The two threads of a window, with an image in its place. Each frame follows at once.
pub struct OffscreenView {
    target: Offscreen,
    size: [u32; 2],
    context: egui::Context,
    status: Status,
    /// Last: it waits for the renderer's last frame.
    renderer: RendererThread,
}

impl OffscreenView {
    /// An image of `size` pixels. `start` makes the renderer, on a thread of its own.
    ///
    /// # Errors
    /// A device that can't draw, or fails.
    pub fn new(
        device: &Device,
        size: [u32; 2],
        start: impl FnOnce() -> std::result::Result<Box<dyn Frames>, Failure> + Send + 'static,
    ) -> Result<Self> {
        let target = Offscreen::new(device, size)?;
        let renderer = RendererThread::new(start, || {}, Duration::ZERO)
            .map_err(|error| Error::Renderer(Box::new(error)))?;
        Ok(Self { target, size, context: egui::Context::default(), status: Status::default(), renderer })
    }

    /// Shows the next `frames` frames, with a panel over them or without. Frames a second.
    ///
    /// # Errors
    /// When the device or the renderer fails.
    pub fn rate(&mut self, frames: u32, mut panel: Option<&mut Panel>) -> Result<f64> {
        let mut begun = None;
        loop {
            if self.collect()? {
                let last = self.status.frames;
                let (first, since) = *begun.get_or_insert_with(|| (last, Instant::now()));
                if last - first >= frames {
                    return Ok(f64::from(last - first) / since.elapsed().as_secs_f64());
                }
                if let Some(panel) = &mut panel {
                    panel.frame_done(&self.status);
                }
                self.draw(panel.as_deref_mut())?;
            }
            sleep(TICK);
        }
    }

    /// Whether there is a new frame to show, and the last one is shown.
    fn collect(&mut self) -> Result<bool> {
        if !self.target.is_free()? {
            return Ok(false);
        }
        match self.renderer.collect() {
            Some(status) => self.status = status.map_err(Error::Renderer)?,
            None if self.renderer.is_running() => return Ok(false),
            None => return Err(Error::Renderer("its thread ended".into())),
        }
        Ok(true)
    }

    fn draw(&mut self, panel: Option<&mut Panel>) -> Result<()> {
        let whole = [0, 0, self.size[0] as i32, self.size[1] as i32];
        let blit = self.status.picture.as_ref().map(|picture| {
            let [width, height] = picture.extent().map(|side| side as i32);
            Blit { image: picture.clone(), from: [0, 0, width, height], to: whole }
        });
        let mut panel = panel.map(|panel| lay_out(&self.context, self.size, panel, &self.status));
        self.target.draw(blit.as_slice(), panel.as_mut())?;
        Ok(())
    }
}
