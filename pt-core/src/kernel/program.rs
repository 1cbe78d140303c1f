//! The making of programs.

use super::constants::{self, Constant, Declarations};
use super::formats;
use super::programs::{Layout, Program};
use super::reflection::{self, Reflection};
use super::specialize;
use crate::device::Device;
use crate::error::{Error, Result, VkContext};
use ash::vk;

/// The words of a module, with the formats that images have on this device.
pub(super) fn words_for(device: &Device, kernel: &str, spirv: &[u8]) -> Result<Vec<u32>> {
    let problem = |problem| Error::Kernel { kernel: kernel.into(), problem };
    formats::with_formats(reflection::words(spirv), &device.variant().formats).map_err(problem)
}

/// A SPIR-V module that lives until its pipeline is made.
pub(super) struct Module {
    device: Device,
    pub(super) handle: vk::ShaderModule,
}

impl Module {
    /// With the values of its specialisation constants, of those `given` that it declares.
    pub(super) fn new(
        device: &Device,
        words: &[u32],
        declared: &Declarations,
        given: &[(&str, Constant)],
    ) -> Result<Self> {
        let variant = device.variant();
        let formats = variant.formats.iter().map(|others| (others.constant, true.into()));
        // What is given takes the place of what the device says.
        let from_device = formats.chain([("gpu_traversal", variant.gpu_traversal.into())]);
        let given: Vec<_> = from_device.chain(given.iter().copied()).collect();
        let words = specialize::specialize(words, &constants::values(declared, &given));
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

impl Program {
    /// Makes the layout for `reflection`, then the pipeline.
    pub(super) fn new(
        device: &Device,
        name: &str,
        reflection: Reflection,
        constants: &[(&str, Constant)],
        stages: vk::ShaderStageFlags,
        pipeline: impl FnOnce(&Reflection, &Layout) -> Result<vk::Pipeline>,
    ) -> Result<Self> {
        let layout = Layout::new(device.raw(), device.texture_layout(), &reflection, stages)?;
        match pipeline(&reflection, &layout) {
            Ok(pipeline) => {
                device.count_pipeline();
                device.name(pipeline, name);
                let constants = constants.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
                Ok(Self { reflection, constants, layout, pipeline })
            }
            Err(error) => {
                layout.destroy(device.raw());
                Err(error)
            }
        }
    }
}
