//! Kernels that trace rays, for each of the backends; ray tracing pipelines and their shader binding tables.

use super::constants::{self, Constant};
use super::program::{Module, words_for};
use super::programs::Program;
use super::{Inner, Kernel, Launch, Reflection, reflection};
use crate::backend::TraceBackend;
use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::{Error, Result, VkContext};
use crate::kernels;
use ash::vk;
use pt_shaders::{GpuStruct, ShaderCode, TraceCode};
use std::sync::Arc;

/// Regions of a shader binding table, and the buffer that they lie in.
pub(crate) struct BindingTable {
    #[expect(dead_code, reason = "the regions point into it")]
    buffer: Buffer,
    pub(super) ray_gen: vk::StridedDeviceAddressRegionKHR,
    pub(super) miss: vk::StridedDeviceAddressRegionKHR,
    pub(super) hit: vk::StridedDeviceAddressRegionKHR,
}

/// Shader groups in the order in which they stand in the pipeline and in the table, one a region.
const GROUPS: u32 = 3;

impl Kernel {
    /// A kernel that traces rays, from the variant for `backend`, with push constants `P` (`()` for none) and specialisation
    /// constants as [`Kernel::compute`] takes them. A ray tracing pipeline hands them to all its shaders that declare them.
    ///
    /// # Errors
    /// As [`Kernel::compute`]; [`Error::Unsupported`] when the device lacks the backend, or when it is `Auto`, which
    /// [`crate::trace::choose`] turns into one of the others.
    pub fn trace<P: GpuStruct>(
        device: &Device,
        code: &TraceCode,
        backend: TraceBackend,
        constants: &[(&str, Constant)],
    ) -> Result<Self> {
        backend.check(device)?;
        match backend {
            TraceBackend::Auto => {
                Err(Error::Unsupported("a kernel needs a definite trace backend, not auto".into()))
            }
            TraceBackend::Compute => Self::compute::<P>(device, &code.compute, constants),
            TraceBackend::RayQuery => Self::compute::<P>(device, &code.ray_query, constants),
            TraceBackend::RtPipeline => Self::ray_tracing::<P>(device, code, &code.ray_gen, constants),
            TraceBackend::RtReorder => Self::ray_tracing::<P>(device, code, &code.ray_gen_reorder, constants),
        }
    }

    fn ray_tracing<P: GpuStruct>(
        device: &Device,
        code: &TraceCode,
        ray_gen: &ShaderCode,
        constants: &[(&str, Constant)],
    ) -> Result<Self> {
        let make = || program::<P>(device, code, ray_gen, constants);
        let programs = &device.inner().programs;
        let program = programs.get::<P>(device.raw(), ray_gen, device.variant(), constants, make)?;
        let launch = Launch::RayTracing(BindingTable::new(device, ray_gen.name, program.pipeline)?);
        Ok(Self(Arc::new(Inner { device: device.clone(), name: ray_gen.name, program, launch })))
    }
}

fn program<P: GpuStruct>(
    device: &Device,
    code: &TraceCode,
    ray_gen: &ShaderCode,
    constants: &[(&str, Constant)],
) -> Result<Program> {
    let extension = device.inner().ray_tracing_pipeline.as_ref();
    let extension = extension.ok_or_else(|| Error::Unsupported("no VK_KHR_ray_tracing_pipeline".into()))?;
    let shells = [&kernels::TRACE_MISS, &kernels::TRACE_CLOSEST_HIT, &kernels::TRACE_ANY_HIT];
    // The interface of either ray generation shader; spirq does not know the types of the one that sorts threads.
    let known = words_for(device, code.name, code.ray_gen.spirv)?;
    let mut interface = reflection::reflect::<P>(code.name, code.ray_gen.stage, &known)?;
    let mut shaders = vec![(words_for(device, code.name, ray_gen.spirv)?, interface.constants.clone())];
    for shell in shells {
        let words = words_for(device, shell.name, shell.spirv)?;
        let reflection = reflection::reflect::<()>(shell.name, shell.stage, &words)?;
        shaders.push((words, reflection.constants.clone()));
        merge(code.name, &mut interface, reflection)?;
    }
    constants::check(code.name, &interface.constants, constants)?;
    use vk::ShaderStageFlags as S;
    let all = S::RAYGEN_KHR | S::CLOSEST_HIT_KHR | S::ANY_HIT_KHR | S::MISS_KHR;
    Program::new(device, ray_gen.name, interface, constants, all, |_, layout| {
        let modules = (shaders.iter())
            .map(|(words, declared)| Module::new(device, words, declared, constants))
            .collect::<Result<Vec<_>>>()?;
        let stages = [S::RAYGEN_KHR, S::MISS_KHR, S::CLOSEST_HIT_KHR, S::ANY_HIT_KHR];
        let infos: Vec<_> = (stages.into_iter().zip(&modules))
            .map(|(stage, module)| {
                vk::PipelineShaderStageCreateInfo::default().stage(stage).module(module.handle).name(c"main")
            })
            .collect();
        let group = |ty| {
            vk::RayTracingShaderGroupCreateInfoKHR::default()
                .ty(ty)
                .general_shader(vk::SHADER_UNUSED_KHR)
                .closest_hit_shader(vk::SHADER_UNUSED_KHR)
                .any_hit_shader(vk::SHADER_UNUSED_KHR)
                .intersection_shader(vk::SHADER_UNUSED_KHR)
        };
        let groups = [
            group(vk::RayTracingShaderGroupTypeKHR::GENERAL).general_shader(0),
            group(vk::RayTracingShaderGroupTypeKHR::GENERAL).general_shader(1),
            group(vk::RayTracingShaderGroupTypeKHR::TRIANGLES_HIT_GROUP)
                .closest_hit_shader(2)
                .any_hit_shader(3),
        ];
        let info = [vk::RayTracingPipelineCreateInfoKHR::default()
            .stages(&infos)
            .groups(&groups)
            .max_pipeline_ray_recursion_depth(1)
            .layout(layout.handle)];
        // SAFETY: modules and layout are alive.
        let pipelines = unsafe {
            extension.create_ray_tracing_pipelines(
                vk::DeferredOperationKHR::null(),
                vk::PipelineCache::null(),
                &info,
                None,
            )
        };
        Ok(pipelines
            .map_err(|(_, result)| Error::Vulkan { call: "vkCreateRayTracingPipelinesKHR", result })?[0])
    })
}

/// Adds what another shader of the pipeline uses.
fn merge(kernel: &str, interface: &mut Reflection, other: Reflection) -> Result<()> {
    interface.textures |= other.textures;
    for (name, declaration) in other.constants {
        let first = interface.constants.entry(name.clone()).or_insert(declaration);
        if first.ty != declaration.ty {
            let problem = format!(
                "specialisation constant \"{name}\" has type {} in one of its shaders, {} in another",
                first.ty.name(),
                declaration.ty.name()
            );
            return Err(Error::Kernel { kernel: kernel.into(), problem });
        }
    }
    for (place, binding) in other.bindings {
        interface
            .bindings
            .entry(place)
            .and_modify(|b| {
                b.access.read |= binding.access.read;
                b.access.write |= binding.access.write;
                b.access.unknown |= binding.access.unknown;
            })
            .or_insert(binding);
    }
    Ok(())
}

impl BindingTable {
    fn new(device: &Device, name: &str, pipeline: vk::Pipeline) -> Result<Self> {
        let extension = device.inner().ray_tracing_pipeline.as_ref();
        let extension =
            extension.ok_or_else(|| Error::Unsupported("no VK_KHR_ray_tracing_pipeline".into()))?;
        let properties = device.info().capabilities;
        let handle = properties.shader_group_handle_size as usize;
        let alignment = u64::from(properties.shader_group_base_alignment);
        let stride = u64::from(
            properties.shader_group_handle_size.next_multiple_of(properties.shader_group_handle_alignment),
        );
        // SAFETY: the pipeline has that many groups.
        let handles = unsafe {
            extension.get_ray_tracing_shader_group_handles(pipeline, 0, GROUPS, handle * GROUPS as usize)
        }
        .context("vkGetRayTracingShaderGroupHandlesKHR")?;
        let step = stride.next_multiple_of(alignment);
        // Room to align the first region by hand: the allocator does not know of this alignment.
        let size = u64::from(GROUPS) * step + alignment;
        let buffer = Buffer::with_usage(
            device,
            &format!("{name} binding table"),
            size,
            Location::Device,
            vk::BufferUsageFlags::SHADER_BINDING_TABLE_KHR,
        )?;
        let start = buffer.address().next_multiple_of(alignment);
        let mut bytes = vec![0; size as usize];
        for (index, group) in handles.chunks_exact(handle).enumerate() {
            let offset = (start - buffer.address() + index as u64 * step) as usize;
            bytes[offset..offset + handle].copy_from_slice(group);
        }
        buffer.write_through_staging(&bytes)?;
        let region = |index: u64| vk::StridedDeviceAddressRegionKHR {
            device_address: start + index * step,
            stride,
            size: stride,
        };
        Ok(Self { buffer, ray_gen: region(0), miss: region(1), hit: region(2) })
    }
}

#[cfg(test)]
mod tests {
    use super::super::access;
    use super::*;

    /// Devices without the extension never load the module that sorts threads. Its interface is taken from the other one.
    #[test]
    fn the_module_that_sorts_threads_has_the_same_interface() {
        for code in [&kernels::RAY_LIST_CLOSEST, &kernels::RAY_LIST_CLOSEST_OPAQUE] {
            let [plain, sorting] = [&code.ray_gen, &code.ray_gen_reorder].map(|c| reflection::words(c.spirv));
            let [a, b] = [&plain, &sorting].map(|words| access::examine(words));
            assert!(!a.accesses.is_empty() && a.accesses == b.accesses, "{}", code.name);
            let [a, b] =
                [a, b].map(|m| m.structs.into_iter().map(|s| (s.name, s.members)).collect::<Vec<_>>());
            assert!(!a.is_empty() && a == b, "{}", code.name);
            assert_ne!(plain, sorting);
        }
    }
}
