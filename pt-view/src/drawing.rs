//! Draws pictures and a panel over them into an image: that of a swapchain, or one that nobody sees.

use crate::blit::Blit;
use crate::error::{Call, Result};
use crate::panel_renderer::{LaidOut, PanelRenderer};
use ash::vk;
use pt_core::{Device, Image};

/// Colour round the picture, as display codes.
const BACKGROUND: [f32; 4] = [0.09, 0.09, 0.10, 1.0];

/// All of an image.
pub(crate) const WHOLE: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: 1,
    base_array_layer: 0,
    layer_count: 1,
};

/// The image that is drawn into.
#[derive(Clone, Copy)]
pub(crate) struct Target {
    pub(crate) image: vk::Image,
    pub(crate) view: vk::ImageView,
    pub(crate) extent: vk::Extent2D,
    /// Layout in which it is left.
    pub(crate) layout: vk::ImageLayout,
}

/// One picture at a time.
pub(crate) struct Drawing {
    device: Device,
    panel: Option<PanelRenderer>,
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    queries: vk::QueryPool,
    done: vk::Fence,
    in_flight: bool,
    /// Pictures that are being read.
    reading: Vec<Image>,
    panel_ms: Option<f64>,
}

impl Drawing {
    /// For targets of `format`.
    ///
    /// # Errors
    /// When the device fails.
    pub(crate) fn new(device: &Device, format: vk::Format) -> Result<Self> {
        let vulkan = device.vulkan();
        let raw = vulkan.device;
        let pool = vk::CommandPoolCreateInfo::default().queue_family_index(vulkan.queue_family);
        let queries = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(2);
        // SAFETY: valid device and create infos.
        unsafe {
            let pool = raw.create_command_pool(&pool, None).call("vkCreateCommandPool")?;
            let allocate =
                vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            Ok(Self {
                device: device.clone(),
                panel: Some(PanelRenderer::new(device, pool, format)?),
                pool,
                commands: raw.allocate_command_buffers(&allocate).call("vkAllocateCommandBuffers")?[0],
                queries: raw.create_query_pool(&queries, None).call("vkCreateQueryPool")?,
                done: raw.create_fence(&vk::FenceCreateInfo::default(), None).call("vkCreateFence")?,
                in_flight: false,
                reading: Vec::new(),
                panel_ms: None,
            })
        }
    }

    /// GPU time of the last panel in milliseconds; `None` before the second picture.
    pub(crate) fn panel_ms(&self) -> Option<f64> {
        self.panel_ms
    }

    /// Whether a picture could be drawn now: the last one is done.
    ///
    /// # Errors
    /// When the device fails.
    pub(crate) fn is_free(&mut self) -> Result<bool> {
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

    /// Uploads textures of a panel before it is drawn. The last picture is done.
    ///
    /// # Errors
    /// When the device fails.
    pub(crate) fn prepare(&mut self, panel: &mut LaidOut) -> Result<()> {
        self.panel.as_mut().map_or(Ok(()), |renderer| renderer.prepare(panel))
    }

    /// Draws parts of pictures and, over them, a panel that is prepared. The last picture is done. `wait`: the target is free; `signal`: it is drawn.
    /// `then` has the queue before anybody else; what it gives.
    ///
    /// # Errors
    /// When the device fails.
    pub(crate) fn draw<T>(
        &mut self,
        target: Target,
        blits: &[Blit],
        panel: Option<&LaidOut>,
        wait: &[vk::Semaphore],
        signal: &[vk::Semaphore],
        then: impl FnOnce(vk::Queue) -> T,
    ) -> Result<T> {
        self.record(target, blits, panel)?;
        self.reading = blits.iter().map(|blit| blit.image.clone()).collect();
        self.submit(wait, signal, then)
    }

    fn record(&mut self, target: Target, blits: &[Blit], panel: Option<&LaidOut>) -> Result<()> {
        let Self { device, panel: Some(renderer), commands, queries, .. } = self else { return Ok(()) };
        let (raw, commands) = (device.vulkan().device, *commands);
        let Target { image, view, extent, layout } = target;
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the last submission is done; the target and the pictures outlive this one.
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
                    .image_view(view)
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
            barrier(raw, commands, Some((image, attachment, layout)));
            raw.end_command_buffer(commands).call("vkEndCommandBuffer")
        }
    }

    fn submit<T>(
        &mut self,
        wait: &[vk::Semaphore],
        signal: &[vk::Semaphore],
        then: impl FnOnce(vk::Queue) -> T,
    ) -> Result<T> {
        let raw = self.device.vulkan().device;
        let infos = |semaphores: &[vk::Semaphore]| -> Vec<_> {
            let info = |&semaphore: &vk::Semaphore| {
                vk::SemaphoreSubmitInfo::default()
                    .semaphore(semaphore)
                    .stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
            };
            semaphores.iter().map(info).collect()
        };
        let (wait, signal) = (infos(wait), infos(signal));
        let commands = [vk::CommandBufferSubmitInfo::default().command_buffer(self.commands)];
        let info = vk::SubmitInfo2::default()
            .wait_semaphore_infos(&wait)
            .command_buffer_infos(&commands)
            .signal_semaphore_infos(&signal);
        // SAFETY: the fence was signalled by the last submission; what the commands use is kept until it is signalled again.
        unsafe { raw.reset_fences(&[self.done]) }.call("vkResetFences")?;
        let answer = self.device.with_queue(|queue| {
            // SAFETY: as above; nobody else uses the queue.
            unsafe { raw.queue_submit2(queue, &[info], self.done) }.map(|()| then(queue))
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

impl Drop for Drawing {
    fn drop(&mut self) {
        if let Err(error) = self.device.wait_idle() {
            eprintln!("warning: waiting for the device failed: {error}");
        }
        self.panel = None;
        let raw = self.device.vulkan().device;
        // SAFETY: the queue is idle, and nothing else uses the objects.
        unsafe {
            raw.destroy_fence(self.done, None);
            raw.destroy_query_pool(self.queries, None);
            raw.destroy_command_pool(self.pool, None);
        }
    }
}
