//! Kernels: a pipeline with its interface. Resources are bound by the names in the SPIR-V.

mod access;
mod constants;
mod control_flow;
mod fold;
mod formats;
mod program;
pub(crate) mod programs;
mod ray_tracing;
mod reflection;
mod specialize;

pub use constants::{Constant, ConstantDeclaration, ConstantType};
pub use reflection::{Binding, BindingKind, Reflection};

use crate::device::Device;
use crate::error::{Error, Result};
use ash::vk;
use program::Module;
use programs::{Layout, Program};
use pt_shaders::{GpuStruct, ShaderCode};
use std::sync::Arc;

/// How a kernel is started.
enum Launch {
    /// Workgroups of this size.
    Compute([u32; 3]),
    /// Ray generation shaders, one a thread.
    RayTracing(ray_tracing::BindingTable),
}

/// A compiled kernel; clones share it.
#[derive(Clone)]
pub struct Kernel(Arc<Inner>);

struct Inner {
    device: Device,
    name: &'static str,
    program: Arc<Program>,
    launch: Launch,
}

impl Kernel {
    /// A compute kernel with push constants `P` (`()` for none). `constants`: values of specialisation constants by the names
    /// that GLSL declares them with; those that are left out keep the values of their declarations.
    ///
    /// # Errors
    /// When the kernel's push constants or shared records are laid out unlike the host's, or its bindings clash; when it has no
    /// constant of a given name, or one of another type.
    pub fn compute<P: GpuStruct>(
        device: &Device,
        code: &ShaderCode,
        constants: &[(&str, Constant)],
    ) -> Result<Self> {
        let make = || {
            let words = program::words_for(device, code.name, code.spirv)?;
            let reflection = reflection::reflect::<P>(code.name, code.stage, &words)?;
            constants::check(code.name, &reflection.constants, constants)?;
            let stages = vk::ShaderStageFlags::COMPUTE;
            Program::new(device, code.name, reflection, constants, stages, |reflection, layout| {
                let module = Module::new(device, &words, &reflection.constants, constants)?;
                let stage = vk::PipelineShaderStageCreateInfo::default()
                    .stage(stages)
                    .module(module.handle)
                    .name(c"main");
                let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout.handle)];
                // SAFETY: module and layout are alive.
                let pipelines =
                    unsafe { device.raw().create_compute_pipelines(vk::PipelineCache::null(), &info, None) };
                Ok(pipelines
                    .map_err(|(_, result)| Error::Vulkan { call: "vkCreateComputePipelines", result })?[0])
            })
        };
        let programs = &device.inner().programs;
        let program = programs.get::<P>(device.raw(), code, device.variant(), constants, make)?;
        let launch = Launch::Compute(program.reflection.workgroup);
        Ok(Self(Arc::new(Inner { device: device.clone(), name: code.name, program, launch })))
    }

    /// The value that it was made with for a specialisation constant; `None`: it was given none.
    pub fn constant(&self, name: &str) -> Option<Constant> {
        self.0.program.constants.iter().find(|(given, _)| given == name).map(|(_, value)| *value)
    }

    /// Whether it has a binding of this name.
    pub fn has_binding(&self, name: &str) -> bool {
        self.0.program.reflection.bindings.values().any(|binding| binding.name == name)
    }

    /// File stem of its GLSL source.
    pub fn name(&self) -> &str {
        self.0.name
    }

    /// Its interface.
    pub fn reflection(&self) -> &Reflection {
        &self.0.program.reflection
    }

    pub(crate) fn layout(&self) -> &Layout {
        &self.0.program.layout
    }

    pub(crate) fn stage(&self) -> vk::PipelineStageFlags2 {
        match self.0.launch {
            Launch::Compute(_) => vk::PipelineStageFlags2::COMPUTE_SHADER,
            Launch::RayTracing(_) => vk::PipelineStageFlags2::RAY_TRACING_SHADER_KHR,
        }
    }

    /// Binds pipeline, sets and push constants, and starts `extent` threads; a compute kernel as many workgroups as stand at
    /// `groups`, if given.
    ///
    /// # Safety
    /// `cmd` is recording; the sets match the layout; the caller keeps the kernel alive until the commands are done.
    pub(crate) unsafe fn encode(
        &self,
        cmd: vk::CommandBuffer,
        sets: &[(u32, vk::DescriptorSet)],
        push: &[u8],
        extent: [u32; 3],
        groups: Option<(vk::Buffer, u64)>,
    ) {
        let Inner { device, program, launch, .. } = &*self.0;
        let layout = &program.layout;
        let raw = device.raw();
        let bind_point = match launch {
            Launch::Compute(_) => vk::PipelineBindPoint::COMPUTE,
            Launch::RayTracing(_) => vk::PipelineBindPoint::RAY_TRACING_KHR,
        };
        // SAFETY: as promised by the caller.
        unsafe {
            raw.cmd_bind_pipeline(cmd, bind_point, program.pipeline);
            for &(index, set) in sets {
                raw.cmd_bind_descriptor_sets(cmd, bind_point, layout.handle, index, &[set], &[]);
            }
            if !push.is_empty() {
                raw.cmd_push_constants(cmd, layout.handle, layout.stages, 0, push);
            }
            match launch {
                Launch::Compute(group) => {
                    if let Some((buffer, offset)) = groups {
                        raw.cmd_dispatch_indirect(cmd, buffer, offset);
                    } else {
                        let n: [u32; 3] = std::array::from_fn(|i| extent[i].div_ceil(group[i]));
                        raw.cmd_dispatch(cmd, n[0], n[1], n[2]);
                    }
                }
                Launch::RayTracing(table) => {
                    if let Some(extension) = &device.inner().ray_tracing_pipeline {
                        let none = vk::StridedDeviceAddressRegionKHR::default();
                        extension.cmd_trace_rays(
                            cmd,
                            &table.ray_gen,
                            &table.miss,
                            &table.hit,
                            &none,
                            extent[0],
                            extent[1],
                            extent[2],
                        );
                    }
                }
            }
        }
    }
}
