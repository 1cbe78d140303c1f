//! Kernels: a pipeline with its interface. Resources are bound by the names in the SPIR-V.

mod access;
mod constants;
mod control_flow;
mod ray_tracing;
mod reflection;
mod specialize;

pub use constants::{Constant, ConstantDeclaration, ConstantType};
pub use reflection::{Binding, BindingKind, Reflection};

use crate::device::Device;
use crate::error::{Error, Result, VkContext};
use ash::vk;
use constants::Declarations;
use pt_shaders::{GpuStruct, ShaderCode};
use std::sync::Arc;

/// Descriptor sets of a pipeline layout: frame and scene, channels, the kernel's own, bindless textures.
const SETS: usize = 4;

/// How a kernel is started.
pub(crate) enum Launch {
    /// Workgroups of this size.
    Compute([u32; 3]),
    /// Ray generation shaders, one a thread.
    RayTracing(ray_tracing::BindingTable),
}

/// A compiled kernel; clones share it.
#[derive(Clone)]
pub struct Kernel(Arc<Inner>);

struct Inner {
    name: String,
    reflection: Reflection,
    /// Values that the host gave, by name.
    constants: Vec<(String, Constant)>,
    layout: Layout,
    pipeline: vk::Pipeline,
    launch: Launch,
}

/// Pipeline layout with the set layouts it was made from.
pub(crate) struct Layout {
    device: Device,
    pub(crate) sets: [vk::DescriptorSetLayout; SETS],
    pub(crate) handle: vk::PipelineLayout,
    stages: vk::ShaderStageFlags,
}

impl Layout {
    pub(crate) fn new(
        device: &Device,
        reflection: &Reflection,
        stages: vk::ShaderStageFlags,
    ) -> Result<Self> {
        let raw = device.raw();
        let mut layout = Self {
            device: device.clone(),
            sets: [vk::DescriptorSetLayout::null(); SETS],
            handle: vk::PipelineLayout::null(),
            stages,
        };
        for (set, slot) in (0u32..).zip(&mut layout.sets) {
            if set == crate::sampler::TEXTURE_SET {
                *slot = device.texture_layout();
                continue;
            }
            let bindings: Vec<_> = reflection
                .bindings
                .values()
                .filter(|b| b.set == set)
                .map(|b| {
                    vk::DescriptorSetLayoutBinding::default()
                        .binding(b.binding)
                        .descriptor_type(b.kind.descriptor_type())
                        .descriptor_count(1)
                        .stage_flags(stages)
                })
                .collect();
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            // SAFETY: valid device and create info; destroyed by Drop.
            *slot = unsafe { raw.create_descriptor_set_layout(&info, None) }
                .context("vkCreateDescriptorSetLayout")?;
        }
        let push = [vk::PushConstantRange { stage_flags: stages, offset: 0, size: reflection.push_size }];
        let mut info = vk::PipelineLayoutCreateInfo::default().set_layouts(&layout.sets);
        if reflection.push_size > 0 {
            info = info.push_constant_ranges(&push);
        }
        // SAFETY: as above.
        layout.handle =
            unsafe { raw.create_pipeline_layout(&info, None) }.context("vkCreatePipelineLayout")?;
        Ok(layout)
    }
}

impl Drop for Layout {
    fn drop(&mut self) {
        // SAFETY: the kernel that owns the layout is no longer in flight; null handles are ignored.
        unsafe {
            self.device.raw().destroy_pipeline_layout(self.handle, None);
            for (set, handle) in (0u32..).zip(self.sets) {
                if set != crate::sampler::TEXTURE_SET {
                    self.device.raw().destroy_descriptor_set_layout(handle, None);
                }
            }
        }
    }
}

/// A SPIR-V module that lives until its pipeline is made.
pub(crate) struct Module {
    device: Device,
    pub(crate) handle: vk::ShaderModule,
}

impl Module {
    /// With the values of its specialisation constants, of those `given` that it declares.
    pub(crate) fn new(
        device: &Device,
        spirv: &[u8],
        declared: &Declarations,
        given: &[(&str, Constant)],
    ) -> Result<Self> {
        let words = specialize::specialize(&reflection::words(spirv), &constants::values(declared, given));
        let info = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: SPIR-V from our own compiler; destroyed by Drop.
        let handle =
            unsafe { device.raw().create_shader_module(&info, None) }.context("vkCreateShaderModule")?;
        Ok(Self { device: device.clone(), handle })
    }
}

impl Drop for Module {
    fn drop(&mut self) {
        // SAFETY: pipelines keep what they need of a module.
        unsafe { self.device.raw().destroy_shader_module(self.handle, None) };
    }
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
        let reflection = reflection::reflect::<P>(code.name, code.stage, code.spirv)?;
        constants::check(code.name, &reflection.constants, constants)?;
        let stages = vk::ShaderStageFlags::COMPUTE;
        let layout = Layout::new(device, &reflection, stages)?;
        let module = Module::new(device, code.spirv, &reflection.constants, constants)?;
        let stage =
            vk::PipelineShaderStageCreateInfo::default().stage(stages).module(module.handle).name(c"main");
        let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout.handle)];
        // SAFETY: module and layout are alive.
        let pipeline =
            unsafe { device.raw().create_compute_pipelines(vk::PipelineCache::null(), &info, None) }
                .map_err(|(_, result)| Error::Vulkan { call: "vkCreateComputePipelines", result })?[0];
        let launch = Launch::Compute(reflection.workgroup);
        Ok(Self::assemble((code.name, constants), reflection, layout, pipeline, launch))
    }

    pub(crate) fn assemble(
        (name, constants): (&str, &[(&str, Constant)]),
        reflection: Reflection,
        layout: Layout,
        pipeline: vk::Pipeline,
        launch: Launch,
    ) -> Self {
        layout.device.count_pipeline();
        layout.device.name(pipeline, name);
        let constants = constants.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
        Self(Arc::new(Inner { name: name.into(), reflection, constants, layout, pipeline, launch }))
    }

    /// The value that it was made with for a specialisation constant; `None`: it was given none.
    pub fn constant(&self, name: &str) -> Option<Constant> {
        self.0.constants.iter().find(|(given, _)| given == name).map(|(_, value)| *value)
    }

    /// Whether it has a binding of this name.
    pub fn has_binding(&self, name: &str) -> bool {
        self.0.reflection.bindings.values().any(|binding| binding.name == name)
    }

    /// File stem of its GLSL source.
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// Its interface.
    pub fn reflection(&self) -> &Reflection {
        &self.0.reflection
    }

    pub(crate) fn layout(&self) -> &Layout {
        &self.0.layout
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
        let Inner { layout, pipeline, launch, .. } = &*self.0;
        let raw = layout.device.raw();
        let bind_point = match launch {
            Launch::Compute(_) => vk::PipelineBindPoint::COMPUTE,
            Launch::RayTracing(_) => vk::PipelineBindPoint::RAY_TRACING_KHR,
        };
        // SAFETY: as promised by the caller.
        unsafe {
            raw.cmd_bind_pipeline(cmd, bind_point, *pipeline);
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
                    if let Some(extension) = &layout.device.inner().ray_tracing_pipeline {
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

impl Drop for Inner {
    fn drop(&mut self) {
        // SAFETY: the frame recorder keeps clones of what is in flight.
        unsafe { self.layout.device.raw().destroy_pipeline(self.pipeline, None) };
    }
}
