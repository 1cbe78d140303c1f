//! Shows pictures on a surface, with a panel over them.

use crate::blit::Blit;
use crate::drawing::{Drawing, Target};
use crate::error::{Call, Result};
use crate::panel_renderer::LaidOut;
use crate::swapchain::{Swapchain, surface_format};
use crate::swapchain_rules::{Outcome, Step, SwapchainRules};
use ash::{khr, vk};
use pt_core::Device;
use std::time::{Duration, Instant};

/// Makes the surface of a window: once, and again whenever it is lost.
pub type MakeSurface =
    Box<dyn Fn(&ash::Entry, &ash::Instance) -> std::result::Result<vk::SurfaceKHR, vk::Result>>;

/// Another swapchain and other textures of the panel wait for the frame that is being rendered, and on a CPU device so do the times of the last panel and the
/// display of a picture. After a longer wait the picture is left out, so that input is followed before the next one.
const MOST_WAIT: Duration = Duration::from_millis(10);

/// Shows pictures on a surface. A picture for which there is no room yet is left out instead of waiting for room; a call waits for one frame at most.
pub struct Presenter {
    device: Device,
    surfaces: khr::surface::Instance,
    make_surface: MakeSurface,
    surface: vk::SurfaceKHR,
    rules: SwapchainRules,
    swapchain: Option<Swapchain>,
    format: vk::Format,
    drawing: Drawing,
    acquired: vk::Semaphore,
}

impl Presenter {
    /// For a window of `size` pixels.
    ///
    /// # Errors
    /// A device that can't present there.
    pub fn new(device: &Device, size: [u32; 2], make_surface: MakeSurface) -> Result<Self> {
        let vulkan = device.vulkan();
        let raw = vulkan.device;
        let surfaces = khr::surface::Instance::new(vulkan.entry, vulkan.instance);
        let surface = make_surface(vulkan.entry, vulkan.instance).call("vkCreateSurface")?;
        let format = match surface_format(device, &surfaces, surface) {
            Ok(format) => format,
            Err(error) => {
                // SAFETY: made above, not used any more.
                unsafe { surfaces.destroy_surface(surface, None) };
                return Err(error);
            }
        };
        // SAFETY: valid device and create info.
        let acquired = unsafe { raw.create_semaphore(&vk::SemaphoreCreateInfo::default(), None) };
        Ok(Self {
            device: device.clone(),
            surfaces,
            make_surface,
            surface,
            rules: SwapchainRules::new(size),
            swapchain: None,
            format,
            drawing: Drawing::new(device, format)?,
            acquired: acquired.call("vkCreateSemaphore")?,
        })
    }

    /// The window has another size, pixels; a minimised one has none.
    pub fn resized(&mut self, size: [u32; 2]) {
        self.rules.resized(size);
    }

    /// The surface is gone, or the test says so.
    ///
    /// # Errors
    /// None in practice: a lost surface is made anew.
    pub fn surface_lost(&mut self) -> Result<()> {
        self.rules.failed(vk::Result::ERROR_SURFACE_LOST_KHR).call("surface").map(drop)
    }

    /// Size of what is shown, pixels; `None` before the first picture.
    pub fn extent(&self) -> Option<[u32; 2]> {
        self.swapchain.as_ref().map(|swapchain| [swapchain.extent.width, swapchain.extent.height])
    }

    /// GPU time of the last panel in milliseconds; `None` before the second picture.
    pub fn panel_ms(&self) -> Option<f64> {
        self.drawing.panel_ms()
    }

    /// Whether a picture could be drawn now: the last one is done, and this did not have to be waited for.
    ///
    /// # Errors
    /// When the device fails.
    pub fn is_free(&mut self) -> Result<bool> {
        let begun = Instant::now();
        Ok(self.drawing.is_free()? && begun.elapsed() <= MOST_WAIT)
    }

    /// Shows parts of pictures and, over them, a panel. What is left out was not drawn, and the textures of the panel are kept for the next one.
    ///
    /// # Errors
    /// When the device fails.
    pub fn show(&mut self, blits: &[Blit], panel: Option<&mut LaidOut>) -> Result<Outcome> {
        let begun = Instant::now();
        if !self.is_free()? || !self.make_ready()? || begun.elapsed() > MOST_WAIT {
            return Ok(Outcome::LeftOut);
        }
        let mut panel = panel;
        if let Some(panel) = &mut panel {
            self.drawing.prepare(panel)?;
        }
        if begun.elapsed() > MOST_WAIT {
            return Ok(Outcome::LeftOut);
        }
        let Some(swapchain) = &self.swapchain else { return Ok(Outcome::LeftOut) };
        let answer = swapchain.acquire(self.acquired);
        let index = answer.map(|(index, _)| index).unwrap_or_default();
        let outcome = self.rules.acquired(answer.map(|(_, suboptimal)| suboptimal));
        if outcome.call("vkAcquireNextImageKHR")? == Outcome::LeftOut {
            return Ok(Outcome::LeftOut);
        }
        let place = index as usize;
        let target = Target {
            image: swapchain.images[place],
            view: swapchain.views[place],
            extent: swapchain.extent,
            layout: vk::ImageLayout::PRESENT_SRC_KHR,
        };
        let (wait, signal) = ([self.acquired], [swapchain.drawn[place]]);
        let present = |queue| swapchain.present(queue, index);
        let answer = self.drawing.draw(target, blits, panel.as_deref(), &wait, &signal, present)?;
        self.rules.presented(answer).call("vkQueuePresentKHR")?;
        Ok(Outcome::Done)
    }

    /// Makes surface and swapchain where they are missing; whether there is one to show on.
    fn make_ready(&mut self) -> Result<bool> {
        loop {
            match self.rules.next() {
                Step::Wait => return Ok(false),
                Step::Show => return Ok(true),
                Step::MakeSurface => {
                    self.swapchain = None;
                    let vulkan = self.device.vulkan();
                    // SAFETY: its swapchain is gone.
                    unsafe { self.surfaces.destroy_surface(self.surface, None) };
                    self.surface = vk::SurfaceKHR::null();
                    self.surface =
                        (self.make_surface)(vulkan.entry, vulkan.instance).call("vkCreateSurface")?;
                    // Whether the device can present is not asked again: the window is the same.
                    surface_format(&self.device, &self.surfaces, self.surface)?;
                    self.rules.made_surface();
                }
                Step::MakeSwapchain => {
                    let old = self.swapchain.take();
                    let made = Swapchain::new(
                        &self.device,
                        &self.surfaces,
                        self.surface,
                        self.format,
                        self.rules.size(),
                        old.as_ref(),
                    );
                    drop(old);
                    match made {
                        Ok(Some(made)) => {
                            self.swapchain = Some(made);
                            self.rules.made_swapchain();
                        }
                        Ok(None) => return Ok(false),
                        Err(error) => {
                            self.rules.failed(error).call("vkCreateSwapchainKHR")?;
                            return Ok(false);
                        }
                    }
                }
            }
        }
    }
}

impl Drop for Presenter {
    fn drop(&mut self) {
        if let Err(error) = self.device.wait_idle() {
            eprintln!("warning: waiting for the device failed: {error}");
        }
        self.swapchain = None;
        let raw = self.device.vulkan().device;
        // SAFETY: the queue is idle, and nothing else uses the objects.
        unsafe {
            raw.destroy_semaphore(self.acquired, None);
            self.surfaces.destroy_surface(self.surface, None);
        }
    }
}
