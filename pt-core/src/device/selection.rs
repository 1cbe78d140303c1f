//! Lists the devices and their capabilities, and selects one.

use crate::error::{Error, Result, VkContext};
use crate::memory::host_free_bytes;
use ash::{khr, nv, vk};
use serde::Serialize;
use std::ffi::CStr;

/// Optional capabilities of a device.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Capabilities {
    /// `VK_KHR_ray_query`.
    pub ray_query: bool,
    /// `VK_KHR_ray_tracing_pipeline`.
    pub rt_pipeline: bool,
    /// `VK_NV_ray_tracing_invocation_reorder`.
    pub rt_reorder: bool,
    /// Whether the device really sorts threads then: some only take the instructions.
    pub rt_reorder_sorts: bool,
    /// Nanoseconds per timestamp tick; 0 = no timestamps.
    pub timestamp_period: f32,
    /// Largest storage-buffer binding in bytes.
    pub max_storage_buffer_range: u32,
    /// Largest width or height of an image.
    pub max_image_side: u32,
    /// Images and buffers must not be in one page of memory of so many bytes.
    pub memory_page: u64,
    /// Sampled images may hold compressed blocks (BC1 to BC7).
    pub texture_compression_bc: bool,
    /// Arithmetic in half floats.
    pub half_floats: bool,
    /// Its queue draws triangles, without render passes.
    pub draws: bool,
    /// Sampled images of 16-bit unorm codes are filtered linearly.
    pub texture_16_bit_unorm: bool,
    /// Size of the bindless texture table.
    pub max_textures: u32,
    /// Size of a shader group handle in bytes (ray tracing pipelines).
    pub shader_group_handle_size: u32,
    /// Alignment of shader groups inside the binding table.
    pub shader_group_handle_alignment: u32,
    /// Alignment of the binding table's regions.
    pub shader_group_base_alignment: u32,
    /// Alignment of acceleration structure scratch memory.
    pub scratch_alignment: u32,
}

/// Properties of a device.
#[derive(Clone, Debug, Serialize)]
pub struct DeviceInfo {
    /// Position in the list of devices, best first.
    pub index: usize,
    /// UUID of the device, 32 hexadecimal digits: the same in all processes of the machine.
    pub uuid: String,
    /// Name that the driver gives.
    pub name: String,
    /// `discrete-gpu`, `integrated-gpu`, `virtual-gpu`, `cpu` or `other`.
    pub kind: &'static str,
    /// Driver name.
    pub driver: String,
    /// Driver version as the driver writes it.
    pub driver_version: String,
    /// Vulkan version, such as `1.3.289`.
    pub vulkan: String,
    /// Size of the device-local heap in bytes.
    pub memory_bytes: u64,
    /// Its optional capabilities.
    pub capabilities: Capabilities,
    /// Why the frame can't run on it; `None`: it can.
    pub unusable: Option<String>,
}

impl DeviceInfo {
    /// Driver and its version.
    pub fn driver_line(&self) -> String {
        format!("{} {}", self.driver, self.driver_version)
    }

    /// Bytes that are free for resources, as far as the system tells: a CPU device uses the memory of the host.
    pub fn free_bytes(&self) -> u64 {
        let host = if self.is_cpu() { host_free_bytes() } else { None };
        host.map_or(self.memory_bytes, |free| free.min(self.memory_bytes))
    }

    /// Whether kernels run on the CPU.
    pub fn is_cpu(&self) -> bool {
        self.kind == "cpu"
    }
}

pub(super) struct Candidate {
    pub(super) physical: vk::PhysicalDevice,
    pub(super) queue_family: u32,
    pub(super) info: DeviceInfo,
}

const MAX_TEXTURES: u32 = 4096;

const RAY_TRACING_EXTENSIONS: [&CStr; 2] =
    [khr::acceleration_structure::NAME, khr::deferred_host_operations::NAME];

/// The feature structs that the frame needs, chained anew by each caller (they point to each other).
#[derive(Default)]
struct Features {
    core: vk::PhysicalDeviceFeatures2<'static>,
    v11: vk::PhysicalDeviceVulkan11Features<'static>,
    v12: vk::PhysicalDeviceVulkan12Features<'static>,
    v13: vk::PhysicalDeviceVulkan13Features<'static>,
    acceleration: vk::PhysicalDeviceAccelerationStructureFeaturesKHR<'static>,
    ray_query: vk::PhysicalDeviceRayQueryFeaturesKHR<'static>,
    rt_pipeline: vk::PhysicalDeviceRayTracingPipelineFeaturesKHR<'static>,
    rt_reorder: vk::PhysicalDeviceRayTracingInvocationReorderFeaturesNV<'static>,
}

/// Name and value of each required feature bit, so that a missing one can be named.
fn required(f: &mut Features) -> [(&'static str, &mut vk::Bool32); 14] {
    let core = &mut f.core.features;
    [
        ("shaderInt64", &mut core.shader_int64),
        ("samplerAnisotropy", &mut core.sampler_anisotropy),
        ("shaderStorageImageExtendedFormats", &mut core.shader_storage_image_extended_formats),
        ("shaderSampledImageArrayDynamicIndexing", &mut core.shader_sampled_image_array_dynamic_indexing),
        ("bufferDeviceAddress", &mut f.v12.buffer_device_address),
        ("scalarBlockLayout", &mut f.v12.scalar_block_layout),
        ("runtimeDescriptorArray", &mut f.v12.runtime_descriptor_array),
        ("descriptorBindingPartiallyBound", &mut f.v12.descriptor_binding_partially_bound),
        (
            "shaderSampledImageArrayNonUniformIndexing",
            &mut f.v12.shader_sampled_image_array_non_uniform_indexing,
        ),
        ("hostQueryReset", &mut f.v12.host_query_reset),
        ("timelineSemaphore", &mut f.v12.timeline_semaphore),
        ("uniformBufferStandardLayout", &mut f.v12.uniform_buffer_standard_layout),
        ("synchronization2", &mut f.v13.synchronization2),
        ("maintenance4", &mut f.v13.maintenance4),
    ]
}

pub(super) fn candidates(instance: &ash::Instance) -> Result<Vec<Candidate>> {
    // SAFETY: valid instance.
    let physical = unsafe { instance.enumerate_physical_devices() }.context("vkEnumeratePhysicalDevices")?;
    let mut all: Vec<Candidate> =
        physical.into_iter().map(|p| examine(instance, p)).collect::<Result<_>>()?;
    let rank = |kind: &str| {
        ["discrete-gpu", "integrated-gpu", "virtual-gpu", "cpu", "other"].iter().position(|k| *k == kind)
    };
    all.sort_by_key(|c| (c.info.unusable.is_some(), rank(c.info.kind)));
    for (index, candidate) in all.iter_mut().enumerate() {
        candidate.info.index = index;
    }
    Ok(all)
}

fn examine(instance: &ash::Instance, physical: vk::PhysicalDevice) -> Result<Candidate> {
    let mut id = vk::PhysicalDeviceIDProperties::default();
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut rt = vk::PhysicalDeviceRayTracingPipelinePropertiesKHR::default();
    let mut reorder = vk::PhysicalDeviceRayTracingInvocationReorderPropertiesNV::default();
    let mut acceleration = vk::PhysicalDeviceAccelerationStructurePropertiesKHR::default();
    let mut subgroup = vk::PhysicalDeviceSubgroupProperties::default();
    let mut properties = vk::PhysicalDeviceProperties2::default()
        .push_next(&mut id)
        .push_next(&mut driver)
        .push_next(&mut rt)
        .push_next(&mut reorder)
        .push_next(&mut acceleration)
        .push_next(&mut subgroup);
    // SAFETY: valid handles, chained structs outlive the calls.
    let (memory, families, extensions) = unsafe {
        instance.get_physical_device_properties2(physical, &mut properties);
        (
            instance.get_physical_device_memory_properties(physical),
            instance.get_physical_device_queue_family_properties(physical),
            instance
                .enumerate_device_extension_properties(physical)
                .context("vkEnumerateDeviceExtensionProperties")?,
        )
    };
    let core = properties.properties;
    let has = |name: &CStr| extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(name));
    let new_enough = core.api_version >= vk::API_VERSION_1_3;

    let mut supported = Features::default();
    if new_enough {
        query_features(instance, physical, &mut supported);
    }
    let ray_tracing = RAY_TRACING_EXTENSIONS.iter().all(|name| has(name))
        && supported.acceleration.acceleration_structure != 0;
    let ray_query = ray_tracing && has(khr::ray_query::NAME) && supported.ray_query.ray_query != 0;
    let rt_pipeline = ray_tracing
        && has(khr::ray_tracing_pipeline::NAME)
        && supported.rt_pipeline.ray_tracing_pipeline != 0;
    let rt_reorder = rt_pipeline
        && has(nv::ray_tracing_invocation_reorder::NAME)
        && supported.rt_reorder.ray_tracing_invocation_reorder != 0;
    let mut missing: Vec<_> =
        required(&mut supported).iter().filter(|(_, v)| **v == 0).map(|(n, _)| *n).collect();
    // The path tracer's lanes agree on who takes new rays.
    if !subgroup.supported_operations.contains(vk::SubgroupFeatureFlags::BALLOT)
        || !subgroup.supported_stages.contains(vk::ShaderStageFlags::COMPUTE)
    {
        missing.push("subgroup ballots in compute kernels");
    }
    // A family that also draws is the one that desktop tools can look into.
    let queue_family = (0u32..)
        .zip(&families)
        .filter(|(_, f)| f.queue_flags.contains(vk::QueueFlags::COMPUTE) && f.timestamp_valid_bits > 0)
        .max_by_key(|(index, f)| {
            (f.queue_flags.contains(vk::QueueFlags::GRAPHICS), std::cmp::Reverse(*index))
        })
        .map(|(index, _)| index);
    let unusable = if !new_enough {
        Some("its driver has no Vulkan 1.3".to_owned())
    } else if !missing.is_empty() {
        Some(format!("its driver lacks {}", missing.join(", ")))
    } else if queue_family.is_none() {
        Some("it has no compute queue with timestamps".to_owned())
    } else {
        None
    };
    let text = |s: std::result::Result<&CStr, std::ffi::FromBytesUntilNulError>| {
        s.map_or(String::new(), |s| s.to_string_lossy().into_owned())
    };
    let version = core.api_version;
    let info = DeviceInfo {
        index: 0,
        uuid: id.device_uuid.iter().map(|byte| format!("{byte:02x}")).collect(),
        name: text(core.device_name_as_c_str()),
        kind: match core.device_type {
            vk::PhysicalDeviceType::DISCRETE_GPU => "discrete-gpu",
            vk::PhysicalDeviceType::INTEGRATED_GPU => "integrated-gpu",
            vk::PhysicalDeviceType::VIRTUAL_GPU => "virtual-gpu",
            vk::PhysicalDeviceType::CPU => "cpu",
            _ => "other",
        },
        driver: text(driver.driver_name_as_c_str()),
        driver_version: text(driver.driver_info_as_c_str()),
        vulkan: format!(
            "{}.{}.{}",
            vk::api_version_major(version),
            vk::api_version_minor(version),
            vk::api_version_patch(version)
        ),
        memory_bytes: memory
            .memory_heaps_as_slice()
            .iter()
            .filter(|h| h.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL))
            .map(|h| h.size)
            .max()
            .unwrap_or(0),
        capabilities: Capabilities {
            ray_query,
            rt_pipeline,
            rt_reorder,
            rt_reorder_sorts: rt_reorder
                && reorder.ray_tracing_invocation_reorder_reordering_hint
                    == vk::RayTracingInvocationReorderModeNV::REORDER,
            timestamp_period: core.limits.timestamp_period,
            max_storage_buffer_range: core.limits.max_storage_buffer_range,
            max_image_side: core.limits.max_image_dimension2_d,
            memory_page: core.limits.buffer_image_granularity,
            texture_compression_bc: supported.core.features.texture_compression_bc != 0,
            half_floats: supported.v12.shader_float16 != 0,
            draws: supported.v13.dynamic_rendering != 0
                && queue_family
                    .and_then(|index| families.get(index as usize))
                    .is_some_and(|family| family.queue_flags.contains(vk::QueueFlags::GRAPHICS)),
            texture_16_bit_unorm: filters_16_bit_unorm(instance, physical),
            max_textures: MAX_TEXTURES
                .min(core.limits.max_per_stage_descriptor_samplers)
                .min(core.limits.max_per_stage_descriptor_sampled_images)
                .min(core.limits.max_descriptor_set_samplers),
            shader_group_handle_size: rt.shader_group_handle_size,
            shader_group_handle_alignment: rt.shader_group_handle_alignment,
            shader_group_base_alignment: rt.shader_group_base_alignment,
            scratch_alignment: acceleration.min_acceleration_structure_scratch_offset_alignment,
        },
        unusable,
    };
    Ok(Candidate { physical, queue_family: queue_family.unwrap_or(0), info })
}

/// Vulkan leaves the filter of these formats to the device.
fn filters_16_bit_unorm(instance: &ash::Instance, physical: vk::PhysicalDevice) -> bool {
    let needed = vk::FormatFeatureFlags::SAMPLED_IMAGE_FILTER_LINEAR | vk::FormatFeatureFlags::TRANSFER_DST;
    [vk::Format::R16G16_UNORM, vk::Format::R16G16B16A16_UNORM].into_iter().all(|format| {
        // SAFETY: valid handles.
        let properties = unsafe { instance.get_physical_device_format_properties(physical, format) };
        properties.optimal_tiling_features.contains(needed)
    })
}

fn query_features(instance: &ash::Instance, physical: vk::PhysicalDevice, out: &mut Features) {
    let Features { core, v11, v12, v13, acceleration, ray_query, rt_pipeline, rt_reorder } = out;
    let mut chain = vk::PhysicalDeviceFeatures2::default()
        .push_next(v11)
        .push_next(v12)
        .push_next(v13)
        .push_next(acceleration)
        .push_next(ray_query)
        .push_next(rt_pipeline)
        .push_next(rt_reorder);
    // SAFETY: valid handles; drivers skip structs they do not know.
    unsafe { instance.get_physical_device_features2(physical, &mut chain) };
    core.features = chain.features;
    // The chain's pointers must not outlive this function.
    v11.p_next = std::ptr::null_mut();
    v12.p_next = std::ptr::null_mut();
    v13.p_next = std::ptr::null_mut();
    acceleration.p_next = std::ptr::null_mut();
    ray_query.p_next = std::ptr::null_mut();
    rt_pipeline.p_next = std::ptr::null_mut();
    rt_reorder.p_next = std::ptr::null_mut();
}

pub(super) fn choose(candidates: Vec<Candidate>, wanted: Option<&str>) -> Result<Candidate> {
    if candidates.is_empty() {
        return Err(Error::NoDriver);
    }
    let describe = |c: &Candidate| match &c.info.unusable {
        None => format!("{} \"{}\"", c.info.index, c.info.name),
        Some(why) => format!("{} \"{}\" (unusable: {why})", c.info.index, c.info.name),
    };
    let available = candidates.iter().map(describe).collect::<Vec<_>>().join(", ");
    let matches = |c: &Candidate| match wanted {
        None => true,
        Some("cpu") => c.info.is_cpu(),
        Some("gpu") => c.info.kind.ends_with("gpu"),
        Some(text) => match text.parse::<usize>() {
            Ok(index) => c.info.index == index,
            Err(_) => c.info.name.to_lowercase().contains(&text.to_lowercase()),
        },
    };
    candidates.into_iter().find(|c| c.info.unusable.is_none() && matches(c)).ok_or_else(|| match wanted {
        Some(wanted) => Error::UnknownDevice { wanted: wanted.into(), available },
        None => Error::NoDevice(available),
    })
}

/// `presents`: the device shows images in a window, over which a panel is drawn.
pub(super) fn create_device(
    instance: &ash::Instance,
    candidate: &Candidate,
    presents: bool,
) -> Result<ash::Device> {
    let capabilities = candidate.info.capabilities;
    if presents {
        super::present::check(instance, candidate.physical, &candidate.info.name, capabilities.draws)?;
    }
    let mut f = Features::default();
    for (_, bit) in required(&mut f) {
        *bit = vk::TRUE;
    }
    f.v12.shader_float16 = vk::Bool32::from(capabilities.half_floats);
    f.core.features.texture_compression_bc = vk::Bool32::from(capabilities.texture_compression_bc);
    f.acceleration.acceleration_structure = vk::TRUE;
    f.ray_query.ray_query = vk::TRUE;
    f.rt_pipeline.ray_tracing_pipeline = vk::TRUE;
    f.rt_reorder.ray_tracing_invocation_reorder = vk::TRUE;
    f.v13.dynamic_rendering = vk::Bool32::from(capabilities.draws);
    let mut extensions = Vec::new();
    if presents {
        extensions.push(khr::swapchain::NAME.as_ptr());
    }
    let ray_tracing = capabilities.ray_query || capabilities.rt_pipeline;
    let priorities = [1.0];
    let queues = [vk::DeviceQueueCreateInfo::default()
        .queue_family_index(candidate.queue_family)
        .queue_priorities(&priorities)];
    let mut info = vk::DeviceCreateInfo::default().queue_create_infos(&queues);
    if ray_tracing {
        extensions.extend(RAY_TRACING_EXTENSIONS.map(CStr::as_ptr));
        info = info.push_next(&mut f.acceleration);
    }
    if capabilities.ray_query {
        extensions.push(khr::ray_query::NAME.as_ptr());
        info = info.push_next(&mut f.ray_query);
    }
    if capabilities.rt_pipeline {
        extensions.push(khr::ray_tracing_pipeline::NAME.as_ptr());
        info = info.push_next(&mut f.rt_pipeline);
    }
    if capabilities.rt_reorder {
        extensions.push(nv::ray_tracing_invocation_reorder::NAME.as_ptr());
        info = info.push_next(&mut f.rt_reorder);
    }
    info = info
        .enabled_extension_names(&extensions)
        .push_next(&mut f.v11)
        .push_next(&mut f.v12)
        .push_next(&mut f.v13)
        .push_next(&mut f.core);
    // SAFETY: everything pointed to outlives the call; only supported features and extensions are named.
    unsafe { instance.create_device(candidate.physical, &info, None) }.context("vkCreateDevice")
}
