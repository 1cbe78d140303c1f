//! Specialisation constants, by the names of their GLSL declarations: values that are fixed when a pipeline is created.
//!
//! GLSL declares them as `layout(constant_id = 0) const uint scene_features = 0xffffffffu;`. A constant that the host does not give
//! keeps the value of its declaration.

use crate::error::ConstantError;
use spirq::ty::{ScalarType, Type};
use std::collections::{BTreeMap, HashMap};

/// Value of a specialisation constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Constant {
    /// `const bool`.
    Bool(bool),
    /// `const uint`.
    Uint(u32),
    /// `const int`.
    Int(i32),
    /// `const float`.
    Float(f32),
}

impl From<bool> for Constant {
    fn from(value: bool) -> Self {
        Self::Bool(value)
    }
}

impl From<u32> for Constant {
    fn from(value: u32) -> Self {
        Self::Uint(value)
    }
}

impl From<i32> for Constant {
    fn from(value: i32) -> Self {
        Self::Int(value)
    }
}

impl From<f32> for Constant {
    fn from(value: f32) -> Self {
        Self::Float(value)
    }
}

impl Constant {
    /// Its GLSL type.
    pub fn ty(self) -> ConstantType {
        match self {
            Self::Bool(_) => ConstantType::Bool,
            Self::Uint(_) => ConstantType::Uint,
            Self::Int(_) => ConstantType::Int,
            Self::Float(_) => ConstantType::Float,
        }
    }

    pub(super) fn bits(self) -> u32 {
        match self {
            Self::Bool(value) => value.into(),
            Self::Uint(value) => value,
            Self::Int(value) => value as u32,
            Self::Float(value) => value.to_bits(),
        }
    }
}

/// GLSL type of a specialisation constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConstantType {
    /// `bool`.
    Bool,
    /// `uint`.
    Uint,
    /// `int`.
    Int,
    /// `float`.
    Float,
}

impl ConstantType {
    /// Its name in GLSL.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bool => "bool",
            Self::Uint => "uint",
            Self::Int => "int",
            Self::Float => "float",
        }
    }

    /// Of a SPIR-V type; `None`: no type that constants have here.
    pub(crate) fn of(ty: &Type) -> Option<Self> {
        match ty {
            Type::Scalar(ScalarType::Boolean) => Some(Self::Bool),
            Type::Scalar(ScalarType::Integer { bits: 32, is_signed: false }) => Some(Self::Uint),
            Type::Scalar(ScalarType::Integer { bits: 32, is_signed: true }) => Some(Self::Int),
            Type::Scalar(ScalarType::Float { bits: 32 }) => Some(Self::Float),
            _ => None,
        }
    }
}

/// A specialisation constant as a kernel declares it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConstantDeclaration {
    /// `constant_id` of its layout qualifier.
    pub id: u32,
    /// Its type.
    pub ty: ConstantType,
}

/// The constants of a kernel by name.
pub(crate) type Declarations = BTreeMap<String, ConstantDeclaration>;

/// Checks values against the declarations in the shaders of a kernel.
pub(crate) fn check(
    kernel: &str,
    declared: &Declarations,
    given: &[(&str, Constant)],
) -> Result<(), ConstantError> {
    for (index, &(name, value)) in given.iter().enumerate() {
        let (kernel, constant) = (kernel.to_owned(), name.to_owned());
        let Some(&ConstantDeclaration { ty, .. }) = declared.get(name) else {
            let names: Vec<_> = declared.keys().map(String::as_str).collect();
            let declared = if names.is_empty() { "none".into() } else { names.join(", ") };
            return Err(ConstantError::Unknown { kernel, constant, declared });
        };
        if ty != value.ty() {
            let (declared, given) = (ty.name(), value.ty().name());
            return Err(ConstantError::Type { kernel, constant, declared, given });
        }
        if given[..index].iter().any(|(earlier, _)| *earlier == name) {
            return Err(ConstantError::Repeated { kernel, constant });
        }
    }
    Ok(())
}

/// The values that a shader declares of the checked ones, as `specialize` takes them: bits by `constant_id`.
pub(crate) fn values(declared: &Declarations, given: &[(&str, Constant)]) -> HashMap<u32, u32> {
    given.iter().filter_map(|(name, value)| Some((declared.get(*name)?.id, value.bits()))).collect()
}
