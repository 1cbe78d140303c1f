//! Reflection of a kernel: bindings by name, push constants, workgroup size; and the check of its structs against the host's records.

use super::access::{self, Access, StructLayout};
use super::constants::{ConstantDeclaration, ConstantType, Declarations};
use crate::error::{Error, Result};
use ash::vk;
use pt_shaders::{Field, GpuStruct, Stage};
use spirq::ReflectConfig;
use spirq::ty::{DescriptorType, ImageFormat, Type};
use spirq::var::Variable;
use std::collections::BTreeMap;

/// The kind of resource that can be bound to a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BindingKind {
    /// `uniform` block.
    Uniform,
    /// `buffer` block.
    Storage,
    /// `image2D`/`uimage2D` with the format of its layout qualifier.
    Image(ImageFormat),
    /// `sampler2D`.
    Sampled,
    /// `accelerationStructureEXT`.
    AccelerationStructure,
}

impl BindingKind {
    pub(crate) fn descriptor_type(self) -> vk::DescriptorType {
        match self {
            Self::Uniform => vk::DescriptorType::UNIFORM_BUFFER,
            Self::Storage => vk::DescriptorType::STORAGE_BUFFER,
            Self::Image(_) => vk::DescriptorType::STORAGE_IMAGE,
            Self::Sampled => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
            Self::AccelerationStructure => vk::DescriptorType::ACCELERATION_STRUCTURE_KHR,
        }
    }
}

/// One binding of a kernel.
#[derive(Clone, Debug)]
pub struct Binding {
    /// Name in GLSL (block name for buffers).
    pub name: String,
    /// Descriptor set.
    pub set: u32,
    /// Binding number.
    pub binding: u32,
    /// Kind of resource.
    pub kind: BindingKind,
    pub(crate) access: Access,
}

/// A kernel's interface.
#[derive(Clone, Debug, Default)]
pub struct Reflection {
    /// Bindings except the bindless table, by (set, binding).
    pub bindings: BTreeMap<(u32, u32), Binding>,
    /// Whether the bindless texture table is used.
    pub textures: bool,
    /// Size of the push constant block; 0 = none.
    pub push_size: u32,
    /// Workgroup size of compute kernels.
    pub workgroup: [u32; 3],
    /// Specialisation constants by name.
    pub constants: Declarations,
}

pub(crate) fn words(spirv: &[u8]) -> Vec<u32> {
    spirv.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}

/// Reflects one module of `kernel` and checks the layout of all records that it shares with the host.
pub(crate) fn reflect<P: GpuStruct>(kernel: &str, stage: Stage, words: &[u32]) -> Result<Reflection> {
    let problem = |problem: String| Error::Kernel { kernel: kernel.into(), problem };
    let module = access::examine(words);
    check_records::<P>(&module.structs).map_err(problem)?;

    let entries = ReflectConfig::new()
        .spv(access::without_constant_expressions(words))
        .combine_img_samplers(true)
        .reflect()
        .map_err(|e| problem(format!("SPIR-V reflection failed: {e}")))?;
    let entry = entries.first().ok_or_else(|| problem("no entry point".into()))?;
    let mut out = Reflection { workgroup: [1; 3], ..Default::default() };
    for variable in &entry.vars {
        match variable {
            Variable::Descriptor { name, desc_bind, desc_ty, ty, .. } => {
                let (set, binding) = desc_bind.into_inner();
                if set == crate::sampler::TEXTURE_SET {
                    out.textures = true;
                    continue;
                }
                let kind = match desc_ty {
                    DescriptorType::UniformBuffer() => BindingKind::Uniform,
                    DescriptorType::StorageBuffer(_) => BindingKind::Storage,
                    DescriptorType::StorageImage(_) => match ty {
                        Type::StorageImage(image) => BindingKind::Image(image.fmt),
                        _ => {
                            return Err(problem(format!(
                                "set {set} binding {binding}: arrays of images are not used here"
                            )));
                        }
                    },
                    DescriptorType::CombinedImageSampler() => BindingKind::Sampled,
                    DescriptorType::AccelStruct() => BindingKind::AccelerationStructure,
                    other => {
                        return Err(problem(format!(
                            "set {set} binding {binding}: {other:?} is not used here"
                        )));
                    }
                };
                let block = match ty {
                    Type::Struct(block) => block.name.clone(),
                    _ => None,
                };
                let name = name.clone().filter(|n| !n.is_empty()).or(block).unwrap_or_default();
                let access = module.accesses.get(&(set, binding)).copied().unwrap_or_default();
                let new = Binding { name, set, binding, kind, access };
                if let Some(old) = out.bindings.insert((set, binding), new.clone())
                    && old.name != new.name
                {
                    return Err(problem(format!(
                        "set {set} binding {binding} is declared for both \"{}\" and \"{}\"",
                        old.name, new.name
                    )));
                }
            }
            Variable::PushConstant { ty, .. } => {
                out.push_size = ty.nbyte().unwrap_or(0) as u32;
            }
            Variable::SpecConstant { name, spec_id, ty } => {
                let name = name.clone().unwrap_or_default();
                let ty = ConstantType::of(ty).ok_or_else(|| {
                    problem(format!("specialisation constant \"{name}\": {ty} is not used here"))
                })?;
                out.constants.insert(name, ConstantDeclaration { id: *spec_id, ty });
            }
            _ => {}
        }
    }
    if stage == Stage::Compute {
        out.workgroup = module.workgroup.ok_or_else(|| problem("no local_size".into()))?;
    }
    let expected = size_of::<P>() as u32;
    if out.push_size != expected {
        return Err(problem(format!(
            "its push constants have {} bytes, the host's {} has {expected}",
            out.push_size,
            if expected == 0 { "(none)" } else { P::STRUCT_NAME }
        )));
    }
    Ok(out)
}

/// Compares every struct of the module that has a host twin, member by member.
fn check_records<P: GpuStruct>(structs: &[StructLayout]) -> std::result::Result<(), String> {
    let mut records = pt_shaders::records::all();
    if size_of::<P>() > 0 {
        records.push((P::STRUCT_NAME, size_of::<P>(), P::fields()));
    }
    for layout in structs {
        if let Some((name, size, fields)) = records.iter().find(|(name, ..)| *name == layout.name) {
            check_record(name, *size, fields, layout)?;
        }
    }
    Ok(())
}

fn check_record(
    name: &str,
    size: usize,
    fields: &[Field],
    layout: &StructLayout,
) -> std::result::Result<(), String> {
    let host: Vec<_> = fields.iter().map(|f| (f.name.to_owned(), f.offset as u32)).collect();
    if let Some((gpu, host)) = layout.members.iter().zip(&host).find(|(gpu, host)| gpu != host) {
        return Err(format!(
            "{name}: GLSL has member `{}` at byte {}, the host has `{}` at byte {}",
            gpu.0, gpu.1, host.0, host.1
        ));
    }
    if layout.members.len() != host.len() {
        return Err(format!(
            "{name}: GLSL has {} members, the host has {}",
            layout.members.len(),
            host.len()
        ));
    }
    match layout.array_strides.iter().find(|&&stride| stride as usize != size) {
        Some(stride) => {
            Err(format!("{name}: GLSL arrays of it have stride {stride}, the host's size is {size}"))
        }
        None => Ok(()),
    }
}
