//! Frames in flight, their command buffers, timestamps and counters.

use super::hazards::{Barrier, Hazards, Touch};
use super::rays::RayCounter;
use super::resource::{Keep, PassInfo};
use super::timings::{FrameTiming, PassTiming, TimingSample};
use crate::buffer::{Buffer, Location};
use crate::device::{Counters, Device};
use crate::error::{Error, Result, VkContext};
use ash::vk;
use std::ffi::CString;
use std::time::Instant;

/// Frames that the host may be ahead of the device.
pub const FRAMES_IN_FLIGHT: usize = 2;
/// Most passes of a frame, uploads included.
const MAX_PASSES: u32 = 256;
/// A frame that takes longer hangs.
const TIMEOUT_S: u64 = 600;

/// After copies that the host reads.
pub(super) const TO_HOST: Barrier = Barrier {
    src_stage: vk::PipelineStageFlags2::ALL_TRANSFER,
    src_access: vk::AccessFlags2::TRANSFER_WRITE,
    dst_stage: vk::PipelineStageFlags2::HOST,
    dst_access: vk::AccessFlags2::HOST_READ,
};

struct Slot {
    pool: vk::CommandPool,
    cmd: vk::CommandBuffer,
    descriptors: vk::DescriptorPool,
    queries: vk::QueryPool,
    fence: vk::Fence,
    staging: Option<Buffer>,
    staging_used: usize,
    keep: Vec<Keep>,
    in_flight: Option<InFlight>,
}

struct InFlight {
    frame: u32,
    record_ms: f64,
    created: Counters,
    passes: Vec<String>,
}

/// Records and submits frames.
pub struct Recorder {
    device: Device,
    slots: Vec<Slot>,
    frame: u32,
    pub(super) hazards: Hazards,
    timings: TimingSample,
    finished: u32,
    table: Vec<PassInfo>,
    /// Counters when the last frame was submitted.
    counted: Counters,
    pub(super) ray_counter: Option<RayCounter>,
}

impl Recorder {
    /// A recorder with no frame in flight.
    pub fn new(device: &Device) -> Result<Self> {
        let mut recorder = Self {
            device: device.clone(),
            slots: Vec::new(),
            frame: 0,
            hazards: Hazards::default(),
            timings: TimingSample::default(),
            finished: 0,
            table: Vec::new(),
            counted: device.counters(),
            ray_counter: None,
        };
        for _ in 0..FRAMES_IN_FLIGHT {
            recorder.slots.push(Slot::new(device)?);
        }
        Ok(recorder)
    }

    /// The device.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Starts the next frame. Waits only when the device is two frames behind.
    pub fn begin(&mut self) -> Result<Frame<'_>> {
        self.wait_for_room()?;
        let index = self.frame as usize % FRAMES_IN_FLIGHT;
        let started = Instant::now();
        let slot = &mut self.slots[index];
        slot.staging_used = 0;
        let raw = self.device.raw();
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: `collect` has waited for the slot's last submission.
        unsafe {
            raw.reset_command_pool(slot.pool, vk::CommandPoolResetFlags::empty())
                .context("vkResetCommandPool")?;
            raw.reset_descriptor_pool(slot.descriptors, vk::DescriptorPoolResetFlags::empty())
                .context("vkResetDescriptorPool")?;
            raw.reset_query_pool(slot.queries, 0, MAX_PASSES * 2);
            raw.begin_command_buffer(slot.cmd, &begin).context("vkBeginCommandBuffer")?;
        }
        self.table.clear();
        if let Some(counter) = &mut self.ray_counter {
            counter.begin_frame();
        }
        Ok(Frame { recorder: self, slot: index, started, passes: Vec::new(), suffix: String::new() })
    }

    /// Waits until the device is at most one frame behind, as [`Recorder::begin`] does: what all frames but the last have downloaded is there.
    pub fn wait_for_room(&mut self) -> Result<()> {
        self.collect(self.frame as usize % FRAMES_IN_FLIGHT)
    }

    /// Waits for all frames and returns the times of the frames since the last call: of all frames, or, where they are more than 2048, of
    /// a uniform sample of that size.
    pub fn finish(&mut self) -> Result<Vec<FrameTiming>> {
        for offset in 0..FRAMES_IN_FLIGHT {
            self.collect((self.frame as usize + offset) % FRAMES_IN_FLIGHT)?;
        }
        Ok(self.timings.take())
    }

    /// Number of frames that are known to be finished on the device.
    pub fn finished(&self) -> u32 {
        self.finished
    }

    /// Passes of the frame that was recorded last, in order.
    pub fn pass_table(&self) -> &[PassInfo] {
        &self.table
    }

    fn collect(&mut self, index: usize) -> Result<()> {
        let slot = &mut self.slots[index];
        let Some(done) = slot.in_flight.take() else { return Ok(()) };
        let raw = self.device.raw();
        // SAFETY: the fence was submitted with the slot's command buffer.
        unsafe {
            match raw.wait_for_fences(&[slot.fence], true, TIMEOUT_S * 1_000_000_000) {
                Err(vk::Result::TIMEOUT) => return Err(Error::Timeout(TIMEOUT_S)),
                other => other.context("vkWaitForFences")?,
            }
            raw.reset_fences(&[slot.fence]).context("vkResetFences")?;
        }
        slot.keep.clear();
        let mut ticks = vec![0u64; done.passes.len() * 2];
        if !ticks.is_empty() {
            // SAFETY: that many queries were written by the finished command buffer.
            unsafe { raw.get_query_pool_results(slot.queries, 0, &mut ticks, vk::QueryResultFlags::TYPE_64) }
                .context("vkGetQueryPoolResults")?;
        }
        let period = f64::from(self.device.info().capabilities.timestamp_period);
        let ms = |from: u64, to: u64| to.saturating_sub(from) as f64 * period * 1e-6;
        self.finished = self.finished.saturating_add(1);
        self.timings.add(FrameTiming {
            frame: done.frame,
            gpu_ms: ms(ticks.first().copied().unwrap_or(0), ticks.last().copied().unwrap_or(0)),
            record_ms: done.record_ms,
            passes: done
                .passes
                .into_iter()
                .zip(ticks.chunks_exact(2))
                .map(|(pass, t)| PassTiming { pass, ms: ms(t[0], t[1]) })
                .collect(),
            created: done.created,
        });
        Ok(())
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        if let Err(error) = self.device.wait_idle() {
            eprintln!("warning: waiting for the device failed: {error}");
        }
        for slot in &self.slots {
            // SAFETY: the device is idle.
            unsafe {
                self.device.raw().destroy_command_pool(slot.pool, None);
                self.device.raw().destroy_descriptor_pool(slot.descriptors, None);
                self.device.raw().destroy_query_pool(slot.queries, None);
                self.device.raw().destroy_fence(slot.fence, None);
            }
        }
    }
}

impl Slot {
    fn new(device: &Device) -> Result<Self> {
        let raw = device.raw();
        let sizes = [
            (vk::DescriptorType::STORAGE_IMAGE, 4096),
            (vk::DescriptorType::STORAGE_BUFFER, 1024),
            (vk::DescriptorType::UNIFORM_BUFFER, 512),
            (vk::DescriptorType::COMBINED_IMAGE_SAMPLER, 1024),
        ];
        let mut sizes: Vec<_> = sizes
            .iter()
            .map(|&(ty, descriptor_count)| vk::DescriptorPoolSize { ty, descriptor_count })
            .collect();
        if device.inner().acceleration_structure.is_some() {
            let ty = vk::DescriptorType::ACCELERATION_STRUCTURE_KHR;
            sizes.push(vk::DescriptorPoolSize { ty, descriptor_count: 256 });
        }
        let pool_info = vk::CommandPoolCreateInfo::default().queue_family_index(device.inner().queue_family);
        let descriptor_info =
            vk::DescriptorPoolCreateInfo::default().max_sets(3 * MAX_PASSES).pool_sizes(&sizes);
        let query_info = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::TIMESTAMP)
            .query_count(MAX_PASSES * 2);
        // SAFETY: valid device and create infos.
        unsafe {
            let pool = raw.create_command_pool(&pool_info, None).context("vkCreateCommandPool")?;
            let allocate =
                vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            Ok(Self {
                pool,
                cmd: raw.allocate_command_buffers(&allocate).context("vkAllocateCommandBuffers")?[0],
                descriptors: raw
                    .create_descriptor_pool(&descriptor_info, None)
                    .context("vkCreateDescriptorPool")?,
                queries: raw.create_query_pool(&query_info, None).context("vkCreateQueryPool")?,
                fence: raw.create_fence(&vk::FenceCreateInfo::default(), None).context("vkCreateFence")?,
                staging: None,
                staging_used: 0,
                keep: Vec::new(),
                in_flight: None,
            })
        }
    }
}

/// A frame that is being recorded.
pub struct Frame<'r> {
    recorder: &'r mut Recorder,
    slot: usize,
    started: Instant,
    passes: Vec<String>,
    /// At the end of the names of passes.
    suffix: String,
}

impl<'r> Frame<'r> {
    /// Frames since the recorder was made.
    pub fn index(&self) -> u32 {
        self.recorder.frame
    }

    /// Passes recorded so far.
    pub fn pass_count(&self) -> usize {
        self.passes.len()
    }

    /// Ends the names of the kernels' passes from here on with `suffix`, to tell those of stages that run several times in a frame.
    pub fn end_names_with(&mut self, suffix: &str) {
        self.suffix = suffix.into();
    }

    pub(super) fn full_name(&self, pass: &str) -> String {
        format!("{pass}{}", self.suffix)
    }

    pub(super) fn ray_counter(&mut self) -> Option<&mut RayCounter> {
        self.recorder.ray_counter.as_mut()
    }

    /// Fills the start of a device-local buffer from the host, in frame order.
    pub fn upload(&mut self, buffer: &Buffer, bytes: &[u8]) -> Result<()> {
        if bytes.is_empty() {
            return Ok(());
        }
        let device = self.recorder.device.clone();
        let slot = &mut self.recorder.slots[self.slot];
        // Staging grows to what a frame needs and then stays.
        let fits = |b: &Buffer| b.size() as usize >= slot.staging_used + bytes.len();
        let staging = match slot.staging.clone().filter(fits) {
            Some(staging) => staging,
            None => {
                let size = (slot.staging_used + bytes.len()).next_power_of_two().max(1 << 16) as u64;
                let staging = Buffer::new(&device, "frame staging", size, Location::Upload)?;
                slot.staging_used = 0;
                slot.staging.insert(staging).clone()
            }
        };
        let offset = slot.staging_used;
        staging.write(offset, bytes);
        slot.staging_used += bytes.len().next_multiple_of(16);
        let region = [vk::BufferCopy { src_offset: offset as u64, dst_offset: 0, size: bytes.len() as u64 }];
        let touches = [(
            buffer.id(),
            Touch {
                stage: vk::PipelineStageFlags2::ALL_TRANSFER,
                access: vk::AccessFlags2::TRANSFER_WRITE,
                write: true,
            },
        )];
        let info = PassInfo {
            name: format!("upload {}", buffer.name()),
            kernel: "(copy)".into(),
            extent: [bytes.len() as u32, 1, 1],
            reads: Vec::new(),
            writes: vec![buffer.name().into()],
            bytes: bytes.len() as u64,
            bytes_are_upper_bound: false,
        };
        let keep = [Keep::Buffer(buffer.clone()), Keep::Buffer(staging.clone())];
        self.encode(info, &touches, keep, |raw, cmd| {
            // SAFETY: recording; both buffers are kept alive by the slot.
            unsafe { raw.cmd_copy_buffer(cmd, staging.handle(), buffer.handle(), &region) };
        })
    }

    /// Copies a buffer into a [`Location::Readback`] buffer of at least its size, in frame order; [`Buffer::mapped`] shows the
    /// content once the frame is finished.
    pub fn download(&mut self, buffer: &Buffer, to: &Buffer) -> Result<()> {
        let touch = |access, write| Touch { stage: vk::PipelineStageFlags2::ALL_TRANSFER, access, write };
        let touches = [
            (buffer.id(), touch(vk::AccessFlags2::TRANSFER_READ, false)),
            (to.id(), touch(vk::AccessFlags2::TRANSFER_WRITE, true)),
        ];
        let info = PassInfo {
            name: format!("download {}", buffer.name()),
            kernel: "(copy)".into(),
            extent: [buffer.size() as u32, 1, 1],
            reads: vec![buffer.name().into()],
            writes: vec![to.name().into()],
            bytes: buffer.size(),
            bytes_are_upper_bound: false,
        };
        let region = [vk::BufferCopy::default().size(buffer.size())];
        let keep = [Keep::Buffer(buffer.clone()), Keep::Buffer(to.clone())];
        self.encode(info, &touches, keep, |raw, cmd| {
            // SAFETY: recording; both buffers are kept alive by the slot.
            unsafe {
                raw.cmd_copy_buffer(cmd, buffer.handle(), to.handle(), &region);
                TO_HOST.encode(raw, cmd, &[]);
            }
        })
    }

    /// Puts a barrier for `touches`, a label and two timestamps round `record`.
    pub(super) fn encode(
        &mut self,
        info: PassInfo,
        touches: &[(u64, Touch)],
        keep: impl IntoIterator<Item = Keep>,
        record: impl FnOnce(&ash::Device, vk::CommandBuffer),
    ) -> Result<()> {
        self.encode_fresh(info, touches, &[], keep, record)
    }

    /// As [`Frame::encode`], for images that take memory from others, see [`Barrier::encode`].
    pub(super) fn encode_fresh(
        &mut self,
        info: PassInfo,
        touches: &[(u64, Touch)],
        fresh: &[vk::Image],
        keep: impl IntoIterator<Item = Keep>,
        record: impl FnOnce(&ash::Device, vk::CommandBuffer),
    ) -> Result<()> {
        if self.passes.len() as u32 == MAX_PASSES {
            return Err(Error::Pass {
                pass: info.name,
                kernel: info.kernel,
                problem: format!("a frame has at most {MAX_PASSES} passes"),
            });
        }
        let recorder = &mut *self.recorder;
        let slot = &mut recorder.slots[self.slot];
        let raw = recorder.device.raw();
        let mut barrier = Barrier::default();
        for &(id, touch) in touches {
            recorder.hazards.touch(id, touch, &mut barrier);
        }
        let query = self.passes.len() as u32 * 2;
        let label = CString::new(info.name.as_str()).unwrap_or_default();
        let utils = recorder.device.inner().debug_utils.as_ref();
        // SAFETY: the command buffer is recording; the slot keeps everything alive that the commands use.
        unsafe {
            if let Some(utils) = utils {
                let label = vk::DebugUtilsLabelEXT::default().label_name(&label);
                utils.cmd_begin_debug_utils_label(slot.cmd, &label);
            }
            if barrier.is_needed() {
                barrier.encode(raw, slot.cmd, fresh);
            }
            raw.cmd_write_timestamp2(slot.cmd, vk::PipelineStageFlags2::ALL_COMMANDS, slot.queries, query);
            record(raw, slot.cmd);
            raw.cmd_write_timestamp2(
                slot.cmd,
                vk::PipelineStageFlags2::ALL_COMMANDS,
                slot.queries,
                query + 1,
            );
            if let Some(utils) = utils {
                utils.cmd_end_debug_utils_label(slot.cmd);
            }
        }
        slot.keep.extend(keep);
        self.passes.push(info.name.clone());
        recorder.table.push(info);
        Ok(())
    }

    /// Records commands that are not a kernel as a pass: `record` runs between the barrier for `touches` and the timestamps.
    pub(crate) fn encode_other(
        &mut self,
        info: PassInfo,
        touches: &[(u64, Touch)],
        keep: &[Buffer],
        record: impl FnOnce(&ash::Device, vk::CommandBuffer),
    ) -> Result<()> {
        self.encode(info, touches, keep.iter().cloned().map(Keep::Buffer), record)
    }

    pub(super) fn descriptor_sets(
        &self,
        layouts: &[vk::DescriptorSetLayout],
    ) -> Result<Vec<vk::DescriptorSet>> {
        let slot = &self.recorder.slots[self.slot];
        let info =
            vk::DescriptorSetAllocateInfo::default().descriptor_pool(slot.descriptors).set_layouts(layouts);
        // SAFETY: the pool is used by this frame only.
        unsafe { self.recorder.device.raw().allocate_descriptor_sets(&info) }
            .context("vkAllocateDescriptorSets")
    }

    pub(super) fn device(&self) -> &Device {
        &self.recorder.device
    }

    /// Hands the frame to the device and returns at once.
    pub fn submit(self) -> Result<()> {
        let recorder = self.recorder;
        let slot = &mut recorder.slots[self.slot];
        let raw = recorder.device.raw();
        // SAFETY: recording was begun in `begin`.
        unsafe { raw.end_command_buffer(slot.cmd) }.context("vkEndCommandBuffer")?;
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(slot.cmd)];
        recorder.device.submit(&vk::SubmitInfo2::default().command_buffer_infos(&buffers), slot.fence)?;
        let now = recorder.device.counters();
        slot.in_flight = Some(InFlight {
            frame: recorder.frame,
            record_ms: self.started.elapsed().as_secs_f64() * 1e3,
            created: Counters {
                pipelines: now.pipelines - recorder.counted.pipelines,
                allocations: now.allocations - recorder.counted.allocations,
            },
            passes: self.passes,
        });
        recorder.counted = now;
        recorder.frame += 1;
        Ok(())
    }
}
