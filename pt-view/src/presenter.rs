//! Shows pictures on a surface, with a panel over them.

use crate::blit::Blit;
use crate::error::{Call, Result};
use crate::panel_renderer::{LaidOut, PanelRenderer};
use crate::swapchain::{Swapchain, WHOLE, surface_format};
use crate::swapchain_rules::{Outcome, Step, SwapchainRules};
use ash::{khr, vk};
use pt_core::{Device, Image};
use std::time::{Duration, Instant};

/// Makes the surface of a window: once, and again whenever it is lost.
pub type MakeSurface =
    Box<dyn Fn(&ash::Entry, &ash::Instance) -> std::result::Result<vk::SurfaceKHR, vk::Result>>;

/// Colour round the picture, as display codes.
const BACKGROUND: [f32; 4] = [0.09, 0.09, 0.10, 1.0];
/// Another swapchain and other textures of the panel wait for the frame that is being rendered, and on a CPU device so does the display of a picture. After a
/// longer wait the picture is left out, so that input is followed before the next one.
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
    panel: Option<PanelRenderer>,
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    queries: vk::QueryPool,
    acquired: vk::Semaphore,
    done: vk::Fence,
    in_flight: bool,
    /// Pictures that are being read.
    reading: Vec<Image>,
    panel_ms: Option<f64>,
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
        let pool = vk::CommandPoolCreateInfo::default().queue_family_index(vulkan.queue_family);
        let queries = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(2);
        // SAFETY: valid device and create infos.
        unsafe {
            let pool = raw.create_command_pool(&pool, None).call("vkCreateCommandPool")?;
            let allocate =
                vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            Ok(Self {
                device: device.clone(),
                surfaces,
                make_surface,
                surface,
                rules: SwapchainRules::new(size),
                swapchain: None,
                format,
                panel: Some(PanelRenderer::new(device, pool, format)?),
                pool,
                commands: raw.allocate_command_buffers(&allocate).call("vkAllocateCommandBuffers")?[0],
                queries: raw.create_query_pool(&queries, None).call("vkCreateQueryPool")?,
                acquired: raw
                    .create_semaphore(&vk::SemaphoreCreateInfo::default(), None)
                    .call("vkCreateSemaphore")?,
                done: raw.create_fence(&vk::FenceCreateInfo::default(), None).call("vkCreateFence")?,
                in_flight: false,
                reading: Vec::new(),
                panel_ms: None,
            })
        }
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
        self.panel_ms
    }

    /// Whether a picture could be drawn now: the last one is done.
    ///
    /// # Errors
    /// When the device fails.
    pub fn is_free(&mut self) -> Result<bool> {
        let raw = self.device.vulkan().device;
        // SAFETY: the fence is of this device.
        if self.in_flight && !unsafe { raw.get_fence_status(self.done) }.call("vkGetFenceStatus")? {
            return Ok(false);
        }
        if std::mem::take(&mut self.in_flight) {
            self.reading.clear();
            self.panel_ms = self.read_time();
        }
        Ok(true)
    }

    /// Shows parts of pictures and, over them, a panel. What is left out was not drawn, and the textures of the panel are kept for the next one.
    ///
    /// # Errors
    /// When the device fails.
    pub fn show(&mut self, blits: &[Blit], panel: Option<&mut LaidOut>) -> Result<Outcome> {
        let begun = Instant::now();
        if !self.is_free()? || !self.make_ready()? {
            return Ok(Outcome::LeftOut);
        }
        let mut panel = panel;
        if let (Some(renderer), Some(panel)) = (&mut self.panel, &mut panel) {
            renderer.prepare(panel)?;
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
        self.record(index, blits, panel)?;
        self.reading = blits.iter().map(|blit| blit.image.clone()).collect();
        let answer = self.submit(index)?;
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

    fn record(&mut self, index: u32, blits: &[Blit], panel: Option<&mut LaidOut>) -> Result<()> {
        let Self { device, swapchain: Some(swapchain), panel: Some(renderer), commands, queries, .. } = self
        else {
            return Ok(());
        };
        let (raw, commands) = (device.vulkan().device, *commands);
        let (image, extent) = (swapchain.images[index as usize], swapchain.extent);
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the last submission is done; the swapchain and the pictures outlive this one.
        unsafe {
            raw.reset_command_pool(self.pool, vk::CommandPoolResetFlags::empty())
                .call("vkResetCommandPool")?;
            raw.begin_command_buffer(commands, &begin).call("vkBeginCommandBuffer")?;
            raw.cmd_reset_query_pool(commands, *queries, 0, 2);
            barrier(
                raw,
                commands,
                Some((image, vk::ImageLayout::UNDEFINED, vk::ImageLayout::TRANSFER_DST_OPTIMAL)),
            );
            let clear = vk::ClearColorValue { float32: BACKGROUND };
            raw.cmd_clear_color_image(
                commands,
                image,
                vk::ImageLayout::TRANSFER_DST_OPTIMAL,
                &clear,
                &[WHOLE],
            );
            barrier(raw, commands, None);
            for blit in blits {
                blit.record(raw, commands, image, [extent.width, extent.height]);
            }
            let attachment = vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL;
            barrier(raw, commands, Some((image, vk::ImageLayout::TRANSFER_DST_OPTIMAL, attachment)));
            raw.cmd_write_timestamp2(commands, vk::PipelineStageFlags2::ALL_COMMANDS, *queries, 0);
            if let Some(panel) = panel {
                let attachments = [vk::RenderingAttachmentInfo::default()
                    .image_view(swapchain.views[index as usize])
                    .image_layout(attachment)
                    .load_op(vk::AttachmentLoadOp::LOAD)
                    .store_op(vk::AttachmentStoreOp::STORE)];
                let rendering = vk::RenderingInfo::default()
                    .render_area(extent.into())
                    .layer_count(1)
                    .color_attachments(&attachments);
                raw.cmd_begin_rendering(commands, &rendering);
                renderer.draw(commands, extent, panel)?;
                raw.cmd_end_rendering(commands);
            }
            raw.cmd_write_timestamp2(commands, vk::PipelineStageFlags2::ALL_COMMANDS, *queries, 1);
            barrier(raw, commands, Some((image, attachment, vk::ImageLayout::PRESENT_SRC_KHR)));
            raw.end_command_buffer(commands).call("vkEndCommandBuffer")
        }
    }

    /// Draws and presents, without a frame between the two; the answer to the second.
    fn submit(&mut self, index: u32) -> Result<std::result::Result<bool, vk::Result>> {
        let raw = self.device.vulkan().device;
        let Some(swapchain) = &self.swapchain else { return Ok(Ok(false)) };
        let semaphore = |semaphore| {
            vk::SemaphoreSubmitInfo::default()
                .semaphore(semaphore)
                .stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        };
        let (wait, signal) = ([semaphore(self.acquired)], [semaphore(swapchain.drawn[index as usize])]);
        let commands = [vk::CommandBufferSubmitInfo::default().command_buffer(self.commands)];
        let info = vk::SubmitInfo2::default()
            .wait_semaphore_infos(&wait)
            .command_buffer_infos(&commands)
            .signal_semaphore_infos(&signal);
        // SAFETY: the fence was signalled by the last submission; what the commands use is kept until it is signalled again.
        unsafe { raw.reset_fences(&[self.done]) }.call("vkResetFences")?;
        let answer = self.device.with_queue(|queue| {
            // SAFETY: as above; nobody else uses the queue.
            unsafe { raw.queue_submit2(queue, &[info], self.done) }.map(|()| swapchain.present(queue, index))
        });
        let answer = answer.call("vkQueueSubmit2")?;
        self.in_flight = true;
        Ok(answer)
    }

    /// Of the last panel, from its timestamps.
    fn read_time(&self) -> Option<f64> {
        let mut ticks = [0u64; 2];
        // SAFETY: the submission that writes them is done.
        unsafe {
            self.device.vulkan().device.get_query_pool_results(
                self.queries,
                0,
                &mut ticks,
                vk::QueryResultFlags::TYPE_64,
            )
        }
        .ok()?;
        let period = f64::from(self.device.info().capabilities.timestamp_period);
        Some(ticks[1].saturating_sub(ticks[0]) as f64 * period * 1e-6)
    }
}

/// Orders what comes before against what follows, other submissions included, and moves an image between layouts.
///
/// # Safety
/// The command buffer is recording, and the image is in the first of the layouts.
unsafe fn barrier(
    raw: &ash::Device,
    commands: vk::CommandBuffer,
    image: Option<(vk::Image, vk::ImageLayout, vk::ImageLayout)>,
) {
    let all = vk::PipelineStageFlags2::ALL_COMMANDS;
    let (write, any) =
        (vk::AccessFlags2::MEMORY_WRITE, vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE);
    let memory = [vk::MemoryBarrier2::default()
        .src_stage_mask(all)
        .src_access_mask(write)
        .dst_stage_mask(all)
        .dst_access_mask(any)];
    let images: Vec<_> = image
        .into_iter()
        .map(|(image, from, to)| {
            vk::ImageMemoryBarrier2::default()
                .image(image)
                .subresource_range(WHOLE)
                .old_layout(from)
                .new_layout(to)
                .src_stage_mask(all)
                .src_access_mask(write)
                .dst_stage_mask(all)
                .dst_access_mask(any)
        })
        .collect();
    let dependencies = vk::DependencyInfo::default().memory_barriers(&memory).image_memory_barriers(&images);
    // SAFETY: as promised by the caller.
    unsafe { raw.cmd_pipeline_barrier2(commands, &dependencies) };
}

impl Drop for Presenter {
    fn drop(&mut self) {
        if let Err(error) = self.device.wait_idle() {
            eprintln!("warning: waiting for the device failed: {error}");
        }
        self.panel = None;
        self.swapchain = None;
        let raw = self.device.vulkan().device;
        // SAFETY: the queue is idle, and nothing else uses the objects.
        unsafe {
            raw.destroy_fence(self.done, None);
            raw.destroy_semaphore(self.acquired, None);
            raw.destroy_query_pool(self.queries, None);
            raw.destroy_command_pool(self.pool, None);
            self.surfaces.destroy_surface(self.surface, None);
        }
    }
}
