//! Records shared by host and GPU.
//!
//! `bytemuck::Pod` admits no padding, and without padding `repr(C)` and GLSL's scalar block layout
//! (`GL_EXT_scalar_block_layout`) give the same offsets. pt-core checks that once more against the reflected SPIR-V of
//! every kernel, member by member, when its pipeline is created.

use glam::{IVec2, Mat4, UVec2, UVec3, UVec4, Vec2, Vec3, Vec4};

/// A Rust type with a GLSL counterpart of the same bytes.
pub trait GlslType {
    /// GLSL type name without array suffix.
    const NAME: &'static str;
    /// Array suffix, outermost first; empty for non-arrays.
    fn array_suffix() -> String {
        String::new()
    }
}

macro_rules! glsl_types {
    ($($rust:ty => $glsl:literal),* $(,)?) => { $(impl GlslType for $rust { const NAME: &'static str = $glsl; })* };
}

glsl_types! {
    f32 => "float", u32 => "uint", i32 => "int", u64 => "uint64_t",
    Vec2 => "vec2", Vec3 => "vec3", Vec4 => "vec4",
    UVec2 => "uvec2", UVec3 => "uvec3", UVec4 => "uvec4", IVec2 => "ivec2", Mat4 => "mat4",
}

impl<T: GlslType, const N: usize> GlslType for [T; N] {
    const NAME: &'static str = T::NAME;
    fn array_suffix() -> String {
        format!("[{N}]{}", T::array_suffix())
    }
}

/// One member of a [`GpuStruct`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// Member name, the same on both sides.
    pub name: &'static str,
    /// Byte offset from the start of the record.
    pub offset: usize,
    /// Size in bytes.
    pub size: usize,
    /// GLSL type name without array suffix.
    pub glsl_type: &'static str,
    /// GLSL array suffix, such as `[3]`.
    pub array_suffix: String,
}

/// A record declared with [`gpu_struct!`](crate::gpu_struct!).
pub trait GpuStruct: bytemuck::Pod {
    /// Name of the struct in Rust and GLSL.
    const STRUCT_NAME: &'static str;
    /// Members in order of declaration.
    fn fields() -> Vec<Field>;
    /// The GLSL declaration.
    fn glsl() -> String {
        let members: String = Self::fields()
            .iter()
            .map(|f| format!("    {} {}{};\n", f.glsl_type, f.name, f.array_suffix))
            .collect();
        format!("struct {} {{\n{members}}};\n", Self::STRUCT_NAME)
    }
}

/// No push constants.
impl GpuStruct for () {
    const STRUCT_NAME: &'static str = "()";
    fn fields() -> Vec<Field> {
        Vec::new()
    }
}

/// Declares a record once for host and GPU: a `repr(C)` Pod struct with a generated GLSL declaration.
///
/// The crate that uses it needs `bytemuck` (with `derive`) as a dependency.
#[macro_export]
macro_rules! gpu_struct {
    ($(#[$meta:meta])* pub struct $name:ident { $($(#[$field_meta:meta])* pub $field:ident: $ty:ty),* $(,)? }) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        pub struct $name { $($(#[$field_meta])* pub $field: $ty),* }

        impl $crate::GlslType for $name {
            const NAME: &'static str = stringify!($name);
        }

        impl $crate::GpuStruct for $name {
            const STRUCT_NAME: &'static str = stringify!($name);
            fn fields() -> Vec<$crate::Field> {
                vec![$($crate::Field {
                    name: stringify!($field),
                    offset: std::mem::offset_of!($name, $field),
                    size: std::mem::size_of::<$ty>(),
                    glsl_type: <$ty as $crate::GlslType>::NAME,
                    array_suffix: <$ty as $crate::GlslType>::array_suffix(),
                }),*]
            }
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    gpu_struct! {
        /// Test record.
        pub struct Sample {
            /// Four rows.
            pub rows: [Vec4; 3],
            /// Address.
            pub address: u64,
            /// Pair.
            pub pair: [[f32; 2]; 1],
        }
    }

    #[test]
    fn declaration_and_offsets() {
        assert_eq!(
            Sample::glsl(),
            "struct Sample {\n    vec4 rows[3];\n    uint64_t address;\n    float pair[1][2];\n};\n"
        );
        let offsets: Vec<_> = Sample::fields().iter().map(|f| (f.offset, f.size)).collect();
        assert_eq!(offsets, [(0, 48), (48, 8), (56, 8)]);
    }
}
