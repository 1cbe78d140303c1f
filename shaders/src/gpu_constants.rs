//! Constants shared by host and GPU.

use crate::GlslType;

/// A type that [`gpu_constants!`](crate::gpu_constants!) takes.
pub trait GlslConstant: GlslType {
    /// The value as GLSL reads it back without loss.
    fn literal(self) -> String;
}

impl GlslConstant for u32 {
    fn literal(self) -> String {
        format!("{self}u")
    }
}

impl GlslConstant for f32 {
    fn literal(self) -> String {
        format!("{self:?}")
    }
}

/// Declares constants once for host and GPU: Rust constants, and a function `glsl` with their GLSL declarations.
#[macro_export]
macro_rules! gpu_constants {
    ($($(#[$meta:meta])* pub const $name:ident: $ty:ty = $value:expr;)*) => {
        $($(#[$meta])* pub const $name: $ty = $value;)*

        /// GLSL declarations of these constants.
        pub fn glsl() -> String {
            [$(format!(
                "const {} {} = {};\n",
                <$ty as $crate::GlslType>::NAME,
                stringify!($name),
                $crate::gpu_constants::GlslConstant::literal($name),
            )),*]
            .concat()
        }
    };
}
