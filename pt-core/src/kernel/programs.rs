//! Compiled programs: pipelines with their interfaces. A device keeps each until it is closed, so that a stage that is made again, for
//! instance by a study that goes through the values of a knob, does not compile its kernels again.
//!
//! The device stands above this file: what is here takes the raw handle.

use super::constants::Constant;
use super::reflection::Reflection;
use crate::error::{Result, VkContext};
use crate::lock::lock;
use ash::vk;
use pt_shaders::channels::OtherFormats;
use pt_shaders::{GpuStruct, ShaderCode};
use std::any::TypeId;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

/// Descriptor sets of a pipeline layout: frame and scene, channels, the kernel's own, bindless textures.
const SETS: usize = 4;

/// Pipeline layout with the set layouts it was made from.
pub(crate) struct Layout {
    pub(crate) sets: [vk::DescriptorSetLayout; SETS],
    pub(super) handle: vk::PipelineLayout,
    pub(super) stages: vk::ShaderStageFlags,
}

impl Layout {
    /// `textures`: the layout of the table of textures.
    pub(super) fn new(
        raw: &ash::Device,
        textures: vk::DescriptorSetLayout,
        reflection: &Reflection,
        stages: vk::ShaderStageFlags,
    ) -> Result<Self> {
        let mut layout = Self {
            sets: [vk::DescriptorSetLayout::null(); SETS],
            handle: vk::PipelineLayout::null(),
            stages,
        };
        match layout.fill(raw, textures, reflection) {
            Ok(()) => Ok(layout),
            Err(error) => {
                layout.destroy(raw);
                Err(error)
            }
        }
    }

    fn fill(
        &mut self,
        raw: &ash::Device,
        textures: vk::DescriptorSetLayout,
        reflection: &Reflection,
    ) -> Result<()> {
        for (set, slot) in (0u32..).zip(&mut self.sets) {
            if set == crate::sampler::TEXTURE_SET {
                *slot = textures;
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
                        .stage_flags(self.stages)
                })
                .collect();
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            // SAFETY: valid device and create info; destroyed by `destroy`.
            *slot = unsafe { raw.create_descriptor_set_layout(&info, None) }
                .context("vkCreateDescriptorSetLayout")?;
        }
        let push =
            [vk::PushConstantRange { stage_flags: self.stages, offset: 0, size: reflection.push_size }];
        let mut info = vk::PipelineLayoutCreateInfo::default().set_layouts(&self.sets);
        if reflection.push_size > 0 {
            info = info.push_constant_ranges(&push);
        }
        // SAFETY: as above.
        self.handle = unsafe { raw.create_pipeline_layout(&info, None) }.context("vkCreatePipelineLayout")?;
        Ok(())
    }

    pub(super) fn destroy(&self, raw: &ash::Device) {
        // SAFETY: nothing that uses the layout is in flight; null handles are ignored; the device owns the layout of the texture table.
        unsafe {
            raw.destroy_pipeline_layout(self.handle, None);
            for (set, handle) in (0u32..).zip(self.sets) {
                if set != crate::sampler::TEXTURE_SET {
                    raw.destroy_descriptor_set_layout(handle, None);
                }
            }
        }
    }
}

/// A pipeline with its interface. The device destroys it.
pub(crate) struct Program {
    pub(super) reflection: Reflection,
    /// Values that the host gave, by name.
    pub(super) constants: Vec<(String, Constant)>,
    pub(super) layout: Layout,
    pub(super) pipeline: vk::Pipeline,
}

impl Program {
    fn destroy(&self, raw: &ash::Device) {
        // SAFETY: the device is closed, so that nothing is in flight.
        unsafe { raw.destroy_pipeline(self.pipeline, None) };
        self.layout.destroy(raw);
    }
}

/// What a clone of a device says of the kernels and trees that it makes.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) struct Variant {
    /// Formats of images that are not those of their tables.
    pub(crate) formats: Vec<&'static OtherFormats>,
    /// Whether those of the compute backend are as on a GPU.
    pub(crate) gpu_traversal: bool,
}

/// What a program is made from: its code, which is a constant of this program, the type of its push constants, the variant, and the
/// values of its specialisation constants.
#[derive(Clone, PartialEq, Eq, Hash)]
struct Key {
    code: (*const u8, usize),
    push: TypeId,
    variant: Variant,
    constants: Vec<(String, u32)>,
}

// SAFETY: the pointer is only compared.
unsafe impl Send for Key {}

/// The programs of a device.
#[derive(Default)]
pub(crate) struct Programs(Mutex<HashMap<Key, Arc<Program>>>);

impl Programs {
    /// The program for `code`, made by `make` if the device has not got it. Values of constants are checked by `make`.
    pub(super) fn get<P: GpuStruct>(
        &self,
        raw: &ash::Device,
        code: &ShaderCode,
        variant: &Variant,
        constants: &[(&str, Constant)],
        make: impl FnOnce() -> Result<Program>,
    ) -> Result<Arc<Program>> {
        let key = Key {
            code: (code.spirv.as_ptr(), code.spirv.len()),
            push: TypeId::of::<P>(),
            variant: variant.clone(),
            constants: constants.iter().map(|(name, value)| ((*name).to_owned(), value.bits())).collect(),
        };
        if let Some(program) = lock(&self.0).get(&key) {
            return Ok(program.clone());
        }
        // Not locked meanwhile: other threads make theirs.
        let program = make()?;
        let mut programs = lock(&self.0);
        if let Some(first) = programs.get(&key) {
            program.destroy(raw);
            return Ok(first.clone());
        }
        let program = Arc::new(program);
        programs.insert(key, program.clone());
        Ok(program)
    }

    /// Destroys all of them, before the device.
    pub(crate) fn destroy(&self, raw: &ash::Device) {
        for (_, program) in lock(&self.0).drain() {
            program.destroy(raw);
        }
    }
}
