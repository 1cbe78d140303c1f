//! Instance, device choice, queue, memory allocator, one-off submissions.

mod present;
mod selection;
mod validation;

pub use present::Vulkan;
pub use selection::{Capabilities, DeviceInfo};
pub use validation::ValidationLog;

use crate::error::{Error, Result, VkContext, gib};
use crate::kernel::programs::{Programs, Variant};
use crate::lock::lock;
use crate::sampler::{SamplerDesc, Wrap, create_sampler, table_layout};
use ash::{ext, khr, vk};
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, Allocator, AllocatorCreateDesc};
use pt_shaders::channels::{ChannelId, Format, OtherFormats};
use std::ffi::CStr;
use std::mem::ManuallyDrop;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

/// How to open a device.
#[derive(Clone, Debug, Default)]
pub struct DeviceOptions {
    /// Index in the list of devices, part of a device's name, `gpu` or `cpu`; `None`: the best one, a discrete GPU before the CPU.
    pub device: Option<String>,
    /// Enable the validation layers with synchronization validation and collect their messages.
    pub validation: bool,
}

/// Counts of what is expensive to create; a steady-state frame creates none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Counters {
    /// Pipelines created so far.
    pub pipelines: u64,
    /// Buffers and images for which device memory was taken so far.
    pub allocations: u64,
}

/// Allocations from this size on are compared with the free memory.
const LARGE: u64 = 1 << 28;

/// An open device. Cheap to clone; resources keep it alive.
#[derive(Clone)]
pub struct Device {
    inner: Arc<Inner>,
    /// Of the images and kernels that this clone makes.
    variant: Variant,
}

pub(crate) struct Inner {
    pub(crate) raw: ash::Device,
    pub(crate) debug_utils: Option<ext::debug_utils::Device>,
    pub(crate) acceleration_structure: Option<khr::acceleration_structure::Device>,
    pub(crate) ray_tracing_pipeline: Option<khr::ray_tracing_pipeline::Device>,
    physical: vk::PhysicalDevice,
    pub(crate) queue_family: u32,
    queue: Mutex<vk::Queue>,
    allocator: ManuallyDrop<Mutex<Allocator>>,
    one_off: Mutex<vk::CommandPool>,
    texture_layout: vk::DescriptorSetLayout,
    pub(crate) programs: Programs,
    /// Bilinear, clamped to the edge, no mips: for sampled screen-space images.
    pub(crate) linear_sampler: vk::Sampler,
    info: DeviceInfo,
    pipelines: AtomicU64,
    allocations: AtomicU64,
    next_id: AtomicU64,
    // Dropped after the device: the messenger belongs to the instance.
    instance: ManuallyDrop<Instance>,
}

/// Instance with its loader and, when validating, the message log.
pub(crate) struct Instance {
    pub(crate) raw: ash::Instance,
    validation: Option<validation::Messenger>,
    debug_utils: bool,
    entry: ash::Entry,
}

impl Instance {
    /// `surfaces`: the extensions that surfaces of windows need; none without a window.
    fn new(validate: bool, surfaces: &[&CStr]) -> Result<Self> {
        // SAFETY: libvulkan is trusted to be a Vulkan loader.
        let entry = unsafe { ash::Entry::load() }.map_err(|e| Error::NoLoader(e.to_string()))?;
        let application =
            vk::ApplicationInfo::default().application_name(c"pt").api_version(vk::API_VERSION_1_3);
        let mut layers = Vec::new();
        let mut extensions = Vec::new();
        // SAFETY: no preconditions.
        let offered = unsafe { entry.enumerate_instance_extension_properties(None) }.unwrap_or_default();
        let debug_utils =
            validate || offered.iter().any(|e| e.extension_name_as_c_str() == Ok(ext::debug_utils::NAME));
        for &name in surfaces {
            if !offered.iter().any(|e| e.extension_name_as_c_str() == Ok(name)) {
                return Err(Error::NoPresentation(format!(
                    "the Vulkan drivers of this machine lack {}",
                    name.to_string_lossy()
                )));
            }
            extensions.push(name.as_ptr());
        }
        if debug_utils {
            extensions.push(ext::debug_utils::NAME.as_ptr());
        }
        if validate {
            if !validation::layer_available(&entry) {
                return Err(Error::NoValidationLayer);
            }
            layers.push(validation::LAYER.as_ptr());
        }
        let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
        let mut create = vk::InstanceCreateInfo::default()
            .application_info(&application)
            .enabled_layer_names(&layers)
            .enabled_extension_names(&extensions);
        if validate {
            create = create.push_next(&mut features);
        }
        // SAFETY: `create` and what it points to outlive the call.
        let raw = match unsafe { entry.create_instance(&create, None) } {
            Err(vk::Result::ERROR_INCOMPATIBLE_DRIVER) => return Err(Error::NoDriver),
            other => other.context("vkCreateInstance")?,
        };
        let validation = if validate { Some(validation::Messenger::new(&entry, &raw)?) } else { None };
        Ok(Self { raw, validation, debug_utils, entry })
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        drop(self.validation.take());
        // SAFETY: every device of this instance is gone; `Inner` drops the instance last.
        unsafe { self.raw.destroy_instance(None) };
    }
}

impl Device {
    /// All devices, best first, with their capabilities and, if one cannot be used, the reason.
    pub fn list() -> Result<Vec<DeviceInfo>> {
        let instance = Instance::new(false, &[])?;
        Ok(selection::candidates(&instance.raw)?.into_iter().map(|c| c.info).collect())
    }

    /// Opens a device.
    pub fn open(options: &DeviceOptions) -> Result<Self> {
        Self::open_with(options, &[])
    }

    fn open_with(options: &DeviceOptions, surfaces: &[&CStr]) -> Result<Self> {
        let instance = Instance::new(options.validation, surfaces)?;
        let candidate = selection::choose(selection::candidates(&instance.raw)?, options.device.as_deref())?;
        let capabilities = candidate.info.capabilities;
        let raw = selection::create_device(&instance.raw, &candidate, !surfaces.is_empty())?;
        let queue_family = candidate.queue_family;
        // SAFETY: the family has at least one queue and was requested above.
        let queue = unsafe { raw.get_device_queue(queue_family, 0) };
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.raw.clone(),
            device: raw.clone(),
            physical_device: candidate.physical,
            debug_settings: Default::default(),
            buffer_device_address: true,
            allocation_sizes: Default::default(),
        })
        .map_err(|e| Error::Allocation {
            name: "allocator".into(),
            bytes: 0,
            reason: e.to_string(),
        })?;
        let pool_info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(queue_family)
            .flags(vk::CommandPoolCreateFlags::TRANSIENT);
        // SAFETY: valid device and create info.
        let one_off = unsafe { raw.create_command_pool(&pool_info, None) }.context("vkCreateCommandPool")?;
        let texture_layout = table_layout(&raw, capabilities.max_textures)?;
        let linear_sampler = create_sampler(
            &raw,
            &SamplerDesc { wrap: [Wrap::ClampToEdge; 2], max_anisotropy: 1.0, ..SamplerDesc::default() },
        )?;
        let debug_utils = instance.debug_utils.then(|| ext::debug_utils::Device::new(&instance.raw, &raw));
        let acceleration_structure = (capabilities.ray_query || capabilities.rt_pipeline)
            .then(|| khr::acceleration_structure::Device::new(&instance.raw, &raw));
        let ray_tracing_pipeline =
            capabilities.rt_pipeline.then(|| khr::ray_tracing_pipeline::Device::new(&instance.raw, &raw));
        let inner = Arc::new(Inner {
            raw,
            debug_utils,
            acceleration_structure,
            ray_tracing_pipeline,
            physical: candidate.physical,
            queue_family,
            queue: Mutex::new(queue),
            allocator: ManuallyDrop::new(Mutex::new(allocator)),
            one_off: Mutex::new(one_off),
            texture_layout,
            programs: Programs::default(),
            linear_sampler,
            info: candidate.info,
            pipelines: AtomicU64::new(0),
            allocations: AtomicU64::new(0),
            next_id: AtomicU64::new(1),
            instance: ManuallyDrop::new(instance),
        });
        let variant = Variant { formats: Vec::new(), gpu_traversal: !inner.info.is_cpu() };
        Ok(Self { inner, variant })
    }

    /// The same device for a frame whose images have these formats: images and kernels that are made with it fit each other.
    pub fn with_formats(&self, formats: impl IntoIterator<Item = &'static OtherFormats>) -> Self {
        let variant = Variant { formats: formats.into_iter().collect(), ..self.variant.clone() };
        Self { inner: self.inner.clone(), variant }
    }

    /// The same device with trees and kernels of the compute backend as on a GPU (true, the default there) or on a CPU device (false, the default
    /// there), where leaves hold one triangle instead of two and steps visit one node instead of two. Results have the same bits; the times differ. The kernels
    /// that read a tree must be made with the same.
    pub fn with_gpu_traversal(&self, gpu_traversal: bool) -> Self {
        Self { inner: self.inner.clone(), variant: Variant { gpu_traversal, ..self.variant.clone() } }
    }

    pub(crate) fn variant(&self) -> &Variant {
        &self.variant
    }

    /// The format of an image: what [`Device::with_formats`] says, else that of the table.
    pub fn format(&self, image: ChannelId) -> Format {
        let others = self.variant.formats.iter().flat_map(|others| others.images);
        others.copied().find(|(id, _)| *id == image).map_or(image.channel().format, |(_, format)| format)
    }

    /// Properties and capabilities of the device.
    pub fn info(&self) -> &DeviceInfo {
        &self.inner.info
    }

    /// Creation counters since the device was opened.
    pub fn counters(&self) -> Counters {
        Counters {
            pipelines: self.inner.pipelines.load(Ordering::Relaxed),
            allocations: self.inner.allocations.load(Ordering::Relaxed),
        }
    }

    /// Messages of the validation layers; `None` when opened without them.
    pub fn validation(&self) -> Option<&ValidationLog> {
        self.inner.instance.validation.as_ref().map(|messenger| messenger.log())
    }

    /// Layout of the bindless texture set ([`crate::sampler::TEXTURE_SET`]), the same for every kernel.
    pub(crate) fn texture_layout(&self) -> vk::DescriptorSetLayout {
        self.inner.texture_layout
    }

    pub(crate) fn inner(&self) -> &Inner {
        &self.inner
    }

    pub(crate) fn raw(&self) -> &ash::Device {
        &self.inner.raw
    }

    pub(crate) fn next_id(&self) -> u64 {
        self.inner.next_id.fetch_add(1, Ordering::Relaxed)
    }

    pub(crate) fn count_pipeline(&self) {
        self.inner.pipelines.fetch_add(1, Ordering::Relaxed);
    }

    pub(crate) fn allocate(&self, desc: &AllocationCreateDesc<'_>) -> Result<Allocation> {
        self.inner.allocations.fetch_add(1, Ordering::Relaxed);
        let bytes = desc.requirements.size;
        // A CPU driver takes what it is asked for from the host, and the system then ends the program.
        if bytes >= LARGE && bytes > self.info().free_bytes() {
            let reason = format!("{} are free", gib(self.info().free_bytes()));
            return Err(Error::Allocation { name: desc.name.into(), bytes, reason });
        }
        lock(&self.inner.allocator).allocate(desc).map_err(|e| Error::Allocation {
            name: desc.name.into(),
            bytes: desc.requirements.size,
            reason: e.to_string(),
        })
    }

    /// Name and bytes of each allocation of device memory, as the allocator reports them.
    pub fn memory_in_use(&self) -> Vec<(String, u64)> {
        let report = lock(&self.inner.allocator).generate_report();
        report.allocations.into_iter().map(|allocation| (allocation.name, allocation.size)).collect()
    }

    pub(crate) fn free(&self, allocation: Allocation) {
        if let Err(error) = lock(&self.inner.allocator).free(allocation) {
            eprintln!("warning: freeing device memory failed: {error}");
        }
    }

    pub(crate) fn name<T: vk::Handle>(&self, object: T, name: &str) {
        if let Some(utils) = &self.inner.debug_utils {
            let text = std::ffi::CString::new(name.replace('\0', "?")).unwrap_or_default();
            let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(object).object_name(&text);
            // SAFETY: the object belongs to this device. A failure only loses the name.
            let _ = unsafe { utils.set_debug_utils_object_name(&info) };
        }
    }

    /// Submits to the one queue.
    pub(crate) fn submit(&self, info: &vk::SubmitInfo2<'_>, fence: vk::Fence) -> Result<()> {
        let queue = lock(&self.inner.queue);
        // SAFETY: the queue is locked, the submitted objects are kept alive by the caller until the fence signals.
        unsafe { self.raw().queue_submit2(*queue, &[*info], fence) }.context("vkQueueSubmit2")
    }

    /// Waits until the queue is empty.
    pub fn wait_idle(&self) -> Result<()> {
        let queue = lock(&self.inner.queue);
        // SAFETY: the queue is locked.
        unsafe { self.raw().queue_wait_idle(*queue) }.context("vkQueueWaitIdle")
    }

    /// Records, submits and waits: for set-up and read-back, never inside a frame.
    pub(crate) fn submit_once(&self, record: impl FnOnce(vk::CommandBuffer)) -> Result<()> {
        let pool = lock(&self.inner.one_off);
        let raw = self.raw();
        let allocate = vk::CommandBufferAllocateInfo::default()
            .command_pool(*pool)
            .level(vk::CommandBufferLevel::PRIMARY)
            .command_buffer_count(1);
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the pool is locked for the whole life of the command buffer; full barriers on both sides order the
        // commands against everything submitted before and after.
        unsafe {
            let cmd = raw.allocate_command_buffers(&allocate).context("vkAllocateCommandBuffers")?[0];
            raw.begin_command_buffer(cmd, &begin).context("vkBeginCommandBuffer")?;
            full_barrier(raw, cmd);
            record(cmd);
            full_barrier(raw, cmd);
            raw.end_command_buffer(cmd).context("vkEndCommandBuffer")?;
            let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(cmd)];
            let result = self
                .submit(&vk::SubmitInfo2::default().command_buffer_infos(&buffers), vk::Fence::null())
                .and_then(|()| self.wait_idle());
            raw.free_command_buffers(*pool, &[cmd]);
            result
        }
    }
}

unsafe fn full_barrier(raw: &ash::Device, cmd: vk::CommandBuffer) {
    let barrier = [vk::MemoryBarrier2::default()
        .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .src_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)
        .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS | vk::PipelineStageFlags2::HOST)
        .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)];
    // SAFETY: the caller passes a command buffer in recording state.
    unsafe { raw.cmd_pipeline_barrier2(cmd, &vk::DependencyInfo::default().memory_barriers(&barrier)) };
}

impl Drop for Inner {
    fn drop(&mut self) {
        // SAFETY: resources hold a clone of the device, so none is left; order: allocator, device, instance.
        unsafe {
            let _ = self.raw.device_wait_idle();
            self.programs.destroy(&self.raw);
            self.raw.destroy_sampler(self.linear_sampler, None);
            self.raw.destroy_descriptor_set_layout(self.texture_layout, None);
            self.raw.destroy_command_pool(*lock(&self.one_off), None);
            ManuallyDrop::drop(&mut self.allocator);
            self.raw.destroy_device(None);
            ManuallyDrop::drop(&mut self.instance);
        }
    }
}
